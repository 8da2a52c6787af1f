// Compensation raw -> calibrated, and its inverse.
#pragma once

#include "imulab/model/sensor_model.hpp"

#include <array>
#include <span>

namespace imulab {

/// Specific force and angular rate of one sample [m/s^2, rad/s].
struct Motion {
  Vector3d force, rate;
};

/// Raw readings of one sample, and the thermal readings less their reference (tau), per axis; zero where there are none.
struct RawSample {
  Vector3d accel, gyro;
  Vector3d accel_tau = Vector3d::Zero(), gyro_tau = Vector3d::Zero();
};

/// Whether this thermal reading, in its unit, is in the calibrated range. A range of [0, 0] was not given: it contains every reading.
inline bool in_range(const ThermalReading& calibrated, double reading) {
  const auto [low, high] = calibrated.range;
  return (low == 0 && high == 0) || (reading >= low && reading <= high);
}

/// Dai 2011 eqs 1-4.
Motion compensate(const SensorModel& model, const RawSample& raw);

/// The raw readings that compensate to `motion`: Newton from the linear solution. Throws Error where the polynomial cannot be inverted there.
RawSample decompensate(const SensorModel& model, const Motion& motion, const Vector3d& accel_tau = Vector3d::Zero(),
                       const Vector3d& gyro_tau = Vector3d::Zero());

/// A block of samples as columns: six readings, and up to six thermal readings (not less the reference; empty where there are none).
struct RawColumns {
  std::array<std::span<const double>, 3> gyro, accel, gyro_temperature, accel_temperature;
};
struct MotionColumns {
  std::array<std::span<double>, 3> rate, force;
};

/// compensate on columns; `out` may be the input's own memory.
void compensate(const SensorModel& model, const RawColumns& raw, const MotionColumns& out);

/// decompensate on columns, in place: motion becomes raw readings. Thermal readings (not less the reference) may be empty where the model has no
/// thermal terms.
void decompensate(const SensorModel& model, const std::array<std::span<const double>, 3>& accel_temperature,
                  const std::array<std::span<const double>, 3>& gyro_temperature, const MotionColumns& columns);

}  // namespace imulab
