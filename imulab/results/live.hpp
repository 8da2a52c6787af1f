// A calibration by hand while the unit is being turned: as a picture for a terminal, and as lines.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/eigen.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// "turn by 90 deg about -y until +x points up"
std::string turn_text(const HandTurn& turn);
/// Several: "turn ..., hold still; turn ..., hold still".
std::string turns_text(const std::vector<HandTurn>& turns);

/// "+x", "the edge +x-y", "the corner +x+y-z": the side, edge or corner of the IMU in a direction of its axes.
std::string direction_text(const Eigen::Vector3d& direction);

/// "gyro.matrix.diagonal 812 ppm of 500 ppm", or "... not determined".
std::string progress_text(const RequirementResult& requirement);

/// The state so far.
struct LiveView {
  std::string imu;
  double time_s = 0;  ///< since the first sample
  std::size_t samples = 0;
  std::optional<double> resting_s;                       ///< time at rest so far; absent: it moves
  double rest_s = 4;                                     ///< required time at rest
  std::vector<Eigen::Vector3d> up;                       ///< at each rest, body axes; empty as long as the scale is not known
  std::optional<Eigen::Vector3d> now;                    ///< up where it rests now
  Eigen::Vector3d turned_deg = Eigen::Vector3d::Zero();  ///< about each axis, all turns together
  std::vector<RequirementResult> requirements;           ///< empty before the first rest
  std::optional<HandTurn> next;
  std::string problem;  ///< why there is no result yet
  bool done = false;
};

/// At most 23 lines of at most 79 columns, each ending in a newline.
std::string live_picture(const LiveView& view, bool color);
/// On one line.
std::string live_json(const LiveView& view);

}  // namespace imulab
