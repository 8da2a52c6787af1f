#include "imulab/aid.hpp"

#include <algorithm>
#include <array>

namespace imulab {

std::string_view to_string(AidKind kind) {
  switch (kind) {
    case AidKind::vehicle:
      return "vehicle";
    case AidKind::wheels:
      return "wheels";
    case AidKind::barometer:
      return "barometer";
    case AidKind::heading:
      return "heading";
    case AidKind::zero_velocity:
      return "zero_velocity";
    case AidKind::pose:
      return "pose";
    case AidKind::attitude:
      return "attitude";
    case AidKind::odometry:
      return "odometry";
    case AidKind::gnss:
      break;
  }
  return "gnss";
}

bool has_attitude(AidKind kind) { return kind == AidKind::pose || kind == AidKind::attitude || kind == AidKind::odometry; }

std::string_view to_string(AidFrame frame) { return frame == AidFrame::free ? "free" : frame == AidFrame::level ? "level" : "north"; }

bool has_record(AidKind kind) { return kind != AidKind::vehicle && kind != AidKind::zero_velocity; }

std::string_view to_string(TimeScale scale) {
  switch (scale) {
    case TimeScale::gps:
      return "gps";
    case TimeScale::utc:
      return "utc";
    case TimeScale::recording:
      return "recording";
    case TimeScale::own:
      break;
  }
  return "own";
}

int leap_seconds(double utc) {
  // UTC, as seconds since 1970, from which on GPS time is ahead by another second: 1981-07-01, 1982-07-01, ..., 2015-07-01, 2017-01-01.
  static constexpr std::array<double, 18> steps{362793600, 394329600,  425865600,  489024000,  567993600,  631152000,
                                                662688000, 709948800,  741484800,  773020800,  820454400,  867715200,
                                                915148800, 1136073600, 1230768000, 1341100800, 1435708800, 1483228800};
  return static_cast<int>(std::upper_bound(steps.begin(), steps.end(), utc) - steps.begin());
}

}  // namespace imulab
