#include "imulab/navigation/aided/aided.hpp"

namespace imulab {

std::string showing_manoeuvre(const std::string& c) {
  if (c.ends_with("lever_arm.up")) return "roll or pitch: a slope, a bank, braking";
  if (c.ends_with("lever_arm.right") || c.ends_with("lever_arm.forward")) return "turns in both directions";
  if (c.ends_with("delay") || c.ends_with("drift")) return "changes of speed, and turns";
  if (c.ends_with("mounting.pitch") || c.ends_with("mounting.yaw")) return "a straight drive at speed";
  if (c == "gyro.matrix.zz") return "turns in both directions, of several full circles";
  if (c.starts_with("gyro.matrix") && c.ends_with("z")) return "turns in both directions";
  if (c.starts_with("gyro.matrix")) return "rotations about that axis: rolls and pitches of 30 deg and more, or turns by hand before the drive";
  if (c.starts_with("gyro.g_sensitivity")) return "figure eights and braking; rests on several faces";
  if (c == "accel.offset.z" || c == "accel.matrix.zz") return "rests upside down or on a side: level motion does not tell offset and scale apart";
  if (c.starts_with("accel.offset")) return "the same road in both directions, figure eights";
  if (c.starts_with("accel.matrix")) return "braking and turns in both directions; rests on several faces";
  if (c.starts_with("gyro.offset")) return "a minute at rest";
  if (c.ends_with("scale")) return "a straight drive at speed";
  return "";
}

}  // namespace imulab
