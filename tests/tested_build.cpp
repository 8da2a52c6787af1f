#include "tests/tested_build.hpp"

#include "imulab/core/memory.hpp"

namespace imulab {

std::string command_path() { return IMULAB_COMMAND; }

bool under_sanitizers() {
#ifdef IMULAB_ADDRESS_SANITIZER
  return true;
#else
  return false;
#endif
}

}  // namespace imulab
