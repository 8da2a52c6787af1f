// What a recording shows of a table's steps: the means of the holds and the sums of the turns.
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/table_plan.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace imulab::rig {

struct TableObservations {
  TablePlan parts;  ///< those that were observed, with the times of their samples
  /// Raw: of each hold the means of accelerometers and gyros (six rows), then of each turn the integral of the gyros (three).
  Eigen::VectorXd readings;
  Eigen::Vector3d accel_density = Eigen::Vector3d::Zero(), gyro_density = Eigen::Vector3d::Zero();  ///< raw / sqrt(Hz), from the samples of the holds
  double interval_s = 0.01;                                                                         ///< of the samples
  bool noise_measured = true;                                                                       ///< false: the holds are too short for that
  std::string accel_unit = "m/s^2", gyro_unit = "rad/s";                                            ///< of the raw readings; "count" for raw counts
  std::vector<std::string> notes, warnings;
};

/// Throws Error as table_plan does, Unsupported where no sample falls into the steps.
TableObservations observe(const Recording& recording, const Session& session);

}  // namespace imulab::rig

namespace imulab {
using namespace rig;  // until all callers say rig::
}  // namespace imulab
