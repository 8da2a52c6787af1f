#include "tests/tested_build.hpp"

namespace imulab {

std::string command_path() { return IMULAB_COMMAND; }

bool under_sanitizers() {
#ifdef __SANITIZE_ADDRESS__
  return true;
#else
  return false;
#endif
}

}  // namespace imulab
