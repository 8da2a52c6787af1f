// Compensation of raw readings by the sensor model (Dai 2011 eqs 1-4, doi:10.3788/OPE.20111907.1620), and its inverse: for a single sample, for
// columns in the caller's memory, and for a recording, whole or piece by piece.
//
// Example:
//   const Motion motion = compensate(calibration.model, RawSample{.gyro = {0, 0, 0.01}, .accel = {0.1, 0.2, 9.7}});
//   std::printf("%g m/s^2, %g rad/s\n", motion.force.z(), motion.rate.z());  // in body axes
//   const SampleCompensator compensator(calibration.model);                  // in a real-time loop: checks once, takes temperatures as they are read
//   const Motion now = compensator({0, 0, 0.01}, {0.1, 0.2, 9.7}, 31.5);     // degC
//   const CompensatedRecording whole = compensate(calibration.model, recording, Outliers::reject);
//
// The result is valid within the readings and temperatures that the calibration covered. Outside these temperatures the thermal terms keep their
// values at the limit, and the samples are listed. Units are those of the model (`raw_unit`): a recording in other units is refused with an Error,
// but single samples are not checked. The inverse converges if the polynomial is monotone. One sample takes 40 ns, without allocation. Several
// threads may use a model or a SampleCompensator at the same time, but only one a Compensator.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/outlier_filter.hpp"
#include "imulab/recording.hpp"
#include "imulab/sensor_model.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace imulab {

/// Angular rate and specific force of one sample [rad/s, m/s^2].
struct Motion {
  Vector3d rate = Vector3d::Zero(), force = Vector3d::Zero();
};

/// Raw readings of one sample, and the thermal readings minus their reference (tau), per axis; zero if the unit has none.
struct RawSample {
  Vector3d gyro = Vector3d::Zero(), accel = Vector3d::Zero();
  Vector3d gyro_tau = Vector3d::Zero(), accel_tau = Vector3d::Zero();
};

/// Compensates one sample by Dai 2011 eqs 1-4; `raw` is in the units of the model. The overload for columns gives bit-identical results.
Motion compensate(const SensorModel& model, const RawSample& raw);

/// Returns the raw readings that compensate to `motion` [rad/s, m/s^2], by Newton's method. `gyro_tau` and `accel_tau` are the thermal readings minus
/// their reference, per axis. Throws Error if the polynomial cannot be inverted there.
RawSample decompensate(const SensorModel& model, const Motion& motion, const Vector3d& gyro_tau = Vector3d::Zero(),
                       const Vector3d& accel_tau = Vector3d::Zero());

/// A block of samples as columns: six readings and up to six absolute thermal readings (empty if there are none).
struct RawColumns {
  std::array<std::span<const double>, 3> gyro, accel, gyro_temperature, accel_temperature;
};
struct MotionColumns {
  std::array<std::span<double>, 3> rate, force;
};

/// Compensates columns of equal length; the columns of `out` may use the memory of the input.
void compensate(const SensorModel& model, const RawColumns& raw, const MotionColumns& out);

/// Converts `columns` of motion [rad/s, m/s^2] to raw readings, in place. The columns of absolute thermal readings have the same length, or are empty
/// if the model has no thermal terms.
void decompensate(const SensorModel& model, const std::array<std::span<const double>, 3>& gyro_temperature,
                  const std::array<std::span<const double>, 3>& accel_temperature, const MotionColumns& columns);

/// Returns the covariance of a compensated sample (rate [rad/s], then force [m/s^2]) at the readings `raw`, due to the estimated coefficients; the
/// noise of the sample is not included. Throws Error if `validate` refuses the calibration.
Eigen::Matrix<double, 6, 6> output_covariance(const Calibration& calibration, const RawSample& raw);

/// The units of the samples for a SampleCompensator.
struct SampleOptions {
  std::string_view gyro_unit = "rad/s", accel_unit = "m/s^2";                        ///< units of the readings: these, or "count"
  std::string_view gyro_temperature_unit = "degC", accel_temperature_unit = "degC";  ///< these, "K" or "raw"
  /// Lever arms act over several samples, not on one. false: a model with lever arms is refused; true: forces remain those at the accelerometers' own
  /// positions, as in all overloads of `compensate` (remove_lever_arms moves a recording's forces to the body's origin).
  bool leave_lever_arms = false;
};

/// Compensation for a real-time loop. The constructor checks the model. A call allocates nothing, takes some tens of nanoseconds, and its result is
/// bit-identical to those of `compensate` and the command. A reading that is not finite gives a motion that is not finite.
///
/// An object is constant after its construction: any number of threads may call it at the same time without a lock. Copies are independent.
class SampleCompensator {
 public:
  /// Throws Error with all faults: coefficients that are not finite, units that differ from the model's, thermal terms without a reference
  /// temperature, and lever arms unless `leave_lever_arms` is set.
  explicit SampleCompensator(const SensorModel& model, const SampleOptions& options = {});

  /// Compensates `gyro` and `accel`, readings of one sample in the declared units, without temperatures. Throws Error if the model has thermal terms.
  Motion operator()(const Vector3d& gyro, const Vector3d& accel) const;
  /// Compensates with the absolute thermal readings of each axis. Those of a triad without thermal terms are not used.
  Motion operator()(const Vector3d& gyro, const Vector3d& accel, const Vector3d& gyro_temperature, const Vector3d& accel_temperature) const {
    const auto tau = [](const ThermalReading& of, const Vector3d& t) { return Vector3d(of.tau(t[0]), of.tau(t[1]), of.tau(t[2])); };
    return compensate(model_, {gyro, accel, tau(gyro_temperature_, gyro_temperature), tau(accel_temperature_, accel_temperature)});
  }
  /// Compensates with one thermal reading for all axes.
  Motion operator()(const Vector3d& gyro, const Vector3d& accel, double temperature) const {
    return (*this)(gyro, accel, Vector3d::Constant(temperature), Vector3d::Constant(temperature));
  }

  bool needs_temperature() const { return needs_temperature_; }  ///< true if the model has thermal terms

 private:
  SensorModel model_;
  ThermalReading gyro_temperature_, accel_temperature_;
  bool needs_temperature_ = false;
};

struct CompensatedRecording {
  Recording recording;                    ///< rates [rad/s] and specific forces [m/s^2] instead of raw readings; other columns are unchanged
  std::vector<std::size_t> out_of_range;  ///< samples with a temperature outside the calibrated range, ascending
  std::vector<std::size_t> replaced;      ///< samples with a replaced outlier, ascending
};

/// Outliers among the raw readings are kept, or replaced before compensation (outlier_filter.hpp). Thermal readings are always kept.
enum class Outliers { keep, reject };

/// Compensates a recording in the units of the model; `outliers` states whether outliers are replaced. Throws Error if the recording lacks a
/// temperature that the model needs or has other units than the model, or if a reading has no finite compensation.
CompensatedRecording compensate(const SensorModel& model, Recording recording, Outliers outliers = Outliers::keep);

/// Moves the forces of a compensated recording from each accelerometer's position (row i of `lever_arm` [m]) to the body's origin. Angular
/// accelerations are central differences of the rates, one-sided at gaps and at the ends.
void remove_lever_arms(Recording& recording, const Matrix3d& lever_arm);

/// Compensates a recording that arrives in pieces.
class Compensator {
 public:
  Compensator(SensorModel model, Outliers outliers);  ///< `outliers`: whether outliers are replaced before compensation

  /// Compensates the next samples. With outlier rejection the output lags by two samples until rest().
  CompensatedRecording next(Recording piece);
  /// Returns the remaining samples at the end of the recording.
  CompensatedRecording rest();

 private:
  SensorModel model_;
  std::optional<OutlierFilter> filter_;
  Recording held_;  // samples that are still in the filter
};

}  // namespace imulab
