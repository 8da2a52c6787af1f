// An error of a machine as a message names it.
#pragma once

#include "imulab/rig/rig_errors.hpp"

#include <string>

namespace imulab::rig {

struct ErrorInWords {
  std::string name;  ///< "rate", "mount +z+x, turned about y", "its axis, towards south", "radius of mount +z+x"
  double unit;       ///< in which it is stated, SI
  const char* unit_name;
  double largest;  ///< SI: beyond this its effect is not linear
};
/// Of a tilt, a rate, a mount or a radius.
ErrorInWords in_words(const RigErrorSource& source);

}  // namespace imulab::rig
