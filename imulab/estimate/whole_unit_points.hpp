// What whole-unit calibration uses of its recordings: each step of a chamber, rate table or centrifuge becomes one point, the means of its samples.
#pragma once

#include "imulab/model/compensate.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"

#include <Eigen/Core>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

using Vector6d = Eigen::Matrix<double, 6, 1>;

struct WholeUnitPoint {
  std::size_t recording = 0;  ///< index in the session
  std::size_t number = 0;     ///< of its step in that recording, from 1
  Step step;
  std::size_t samples = 0;
  Vector6d raw;                 ///< means: accel x y z, gyro x y z
  Vector6d variance;            ///< of one sample, from neighbours' differences
  Vector6d temperature;         ///< mean thermal readings, likewise; those of set points where nothing was measured
  std::optional<double> drift;  ///< K/s (or raw/s) of the first thermal reading, where it is significant

  /// "rate_table.csv, step 12 (spin +z+x at 100 deg/s)"
  std::string name(const Session& session) const;
};

struct WholeUnitPoints {
  std::vector<WholeUnitPoint> points;
  double interval_s = 0;          ///< of a sample
  Vector6d thermal_variance;      ///< of one thermal reading, likewise
  Vector6d correlation;           ///< variance of block means of holds over that of independent samples, where it is larger; else 1
  std::array<bool, 2> thermal{};  ///< is there a thermal reading: accelerometers, gyros
  std::array<std::string, 2> thermal_unit;
  std::array<double, 2> thermal_range_low{}, thermal_range_high{};
  std::array<bool, 2> thermal_excited{};  ///< do the readings change by more than their noise and a kelvin?
  std::vector<std::string> warnings;
};

/// One of `recordings` for each of the session's. Saturated points and those without samples are left out, and said. Throws Error where a recording's
/// rig is no machine, units differ between recordings, or nothing is left.
WholeUnitPoints whole_unit_points(const std::vector<Recording>& recordings, const Session& session);

}  // namespace imulab
