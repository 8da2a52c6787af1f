// The parts of a calibration that a target cannot hold, and their size in the output, in user units.
#pragma once

#include "imulab/exchange.hpp"

#include <string>
#include <vector>

namespace imulab::export_io {

/// The terms that a target's own equation has. A term that it has not is left out in this order; biases are those of the readings
/// (consumer_model.hpp).
struct Held {
  bool nonlinear = false;                            ///< quadratic and cubic
  bool accel_thermal = false, gyro_thermal = false;  ///< drift of the readings
  bool matrix_thermal = false;                       ///< of both triads
  bool g_sensitivity = false;                        ///< of the gyros
  bool accel_matrix = false, gyro_matrix = false;    ///< whole matrices
  bool accel_scale = false, gyro_scale = false;      ///< their diagonals
  bool bias = false;
  bool lever_arm = false;
};

/// The conditions for which losses are stated: any direction of force and rate.
inline constexpr double stated_rate_deg_s = 100;

/// The model without the terms that are not held.
SensorModel reduced(SensorModel model, const Held& held);

/// One sentence a term that is left out and not zero: "accelerometers' off-diagonal terms: up to 1.9 mg at 1 g". Where several terms of a triad are
/// lost, their sum as the largest difference from `compensate`; thermal terms without a known range for a change of 10 degrees, and not in the sum.
/// Numbers are the largest error of any axis. Throws Error where the calibration has no inverse there.
std::vector<std::string> losses(const SensorModel& model, const Held& held);

/// For a target that does not hold the model at all: the same sum, one sentence per triad.
std::vector<std::string> whole_calibration(const SensorModel& model);

/// For a target of noise alone: that the calibration is to be applied before, and what leaving it out costs.
std::vector<std::string> whole_calibration_left_out(const ExportInput& input);

/// A size in user units: "1.9 mg", "340 deg/h".
std::string accel_size(double si);
std::string gyro_size(double si);

}  // namespace imulab::export_io
