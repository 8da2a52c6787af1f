// The points that a session's machines give: each step of a chamber, rate table or centrifuge one, the means of its samples with their noise.
#pragma once

#include "imulab/compensate.hpp"
#include "imulab/eigen.hpp"
#include "imulab/recording.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/session.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace imulab {

/// Accelerometers x y z, then gyros x y z.
using Vector6d = Eigen::Matrix<double, 6, 1>;

struct MachinePoint {
  std::size_t recording = 0;  ///< index in the session
  std::size_t number = 0;     ///< of its step in that recording, from 1
  RigKind machine = RigKind::none;
  Step step;
  std::size_t samples = 0;
  Vector6d raw;                 ///< means of the readings
  Vector6d variance;            ///< of one reading, from neighbors' differences
  Vector6d scatter;             ///< variance of the readings about their mean
  Vector6d temperature;         ///< mean thermal readings; the set point where nothing was measured
  std::optional<double> drift;  ///< K/s (or raw/s) of the first thermal reading, where it is significant

  /// "rate_table.csv, step 12 (spin +z+x at 100 deg/s)"
  std::string name(const Session& session) const;
};

/// Thermal readings of a triad over all points, in their unit.
struct ThermalRange {
  bool known = false;    ///< is there a reading?
  bool excited = false;  ///< does it change by more than its noise and a kelvin?
  std::string unit;
  double low = 0, high = 0;
  double size() const { return high - low; }
};

struct MachinePoints {
  std::vector<MachinePoint> all;
  double interval_s = 0;                ///< of a sample
  Vector6d thermal_variance;            ///< of one thermal reading
  Vector6d correlation;                 ///< variance of block means of holds over that of independent samples, where it is larger; else 1
  std::array<ThermalRange, 2> thermal;  ///< accelerometers, gyros
  std::vector<std::string> warnings;

  /// The triad whose thermal readings a chamber is judged by.
  std::size_t thermometer() const { return thermal[0].known ? 0 : 1; }
};

/// Saturated points and those without samples are left out with a warning. Throws Error where there is not one recording for each of the session's,
/// where a recording's rig is not a machine or cannot do its steps, where units or rates differ between recordings, Unsupported where nothing is
/// left.
MachinePoints machine_points(std::span<const Recording> recordings, const Session& session);

/// The points of a procedure, before any data: the exact means of an ideal IMU with these variances of a sample of force and rate, its temperatures
/// those of the set points. Throws as machine_points does.
MachinePoints planned_points(const Session& procedure, const Vector6d& variance);

/// "3 of the chamber's points had not settled (up to 0.2 K/min; the first: NAME)"; empty where all had.
std::string unsettled_points(const MachinePoints& points, const Session& session);

// Was the IMU mounted on a machine as the session says? Another mount, or turning the other way, may explain its readings better.

/// Points of one mounting, and what the IMU measured at each of them, to some percent. Throws Error where another mount or sense of rotation explains
/// that and the declared one does not.
void expect_declared_mount(std::span<const MachinePoint> points, std::span<const Motion> measured, const Session& session);

}  // namespace imulab
