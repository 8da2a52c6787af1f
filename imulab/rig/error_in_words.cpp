#include "imulab/rig/error_in_words.hpp"

#include "imulab/core/units.hpp"
#include "imulab/rig/machine.hpp"

#include <fmt/core.h>

namespace imulab::rig {

ErrorInWords in_words(const RigErrorSource& source) {
  const std::string mount = "mount " + mount_name(source.place);
  switch (source.kind) {
    case RigErrorKind::rate:
      return {"rate", 1e-2, "%", 0.1};
    case RigErrorKind::radius:
      return {"radius of " + mount, 1e-3, "mm", 1};
    case RigErrorKind::mount:
      return {fmt::format("{}, turned about {}", mount, "xyz"[source.axis]), unit::deg, "deg", 10 * unit::deg};
    default:
      return {fmt::format("its axis, towards {}", source.axis == 0 ? "south" : "east"), unit::deg, "deg", 10 * unit::deg};
  }
}

}  // namespace imulab::rig
