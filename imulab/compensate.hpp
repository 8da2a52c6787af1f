// Compensation raw -> calibrated by the sensor model (Dai 2011 eqs 1-4, doi:10.3788/OPE.20111907.1620), and its inverse: for a sample, for columns in
// your memory, for a recording as a whole or in pieces as it arrives.
//
// Example:
//   const Motion motion = compensate(calibration.model, RawSample{.gyro = {0, 0, 0.01}, .accel = {0.1, 0.2, 9.7}});
//   std::printf("%g m/s^2, %g rad/s\n", motion.force.z(), motion.rate.z());  // in body axes
//   const SampleCompensator compensator(calibration.model);                  // in a real-time loop: checks once, takes temperatures as they are read
//   const Motion now = compensator({0, 0, 0.01}, {0.1, 0.2, 9.7}, 31.5);     // degC
//   const CompensatedRecording whole = compensate(calibration.model, recording, Outliers::reject);
//
// Valid within the ranges of readings and temperatures that the calibration covered; samples outside these temperatures are listed. Units are those
// of the model (`raw_unit`): a recording in others is refused with an Error; of single samples the caller answers for them. The inverse converges
// where the polynomial is monotone. One sample takes 40 ns, without allocation; a model and a SampleCompensator may be used by several threads, a
// Compensator by one.
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

/// Raw readings of one sample, and the thermal readings less their reference (tau), per axis; zero where there are none.
struct RawSample {
  Vector3d gyro = Vector3d::Zero(), accel = Vector3d::Zero();
  Vector3d gyro_tau = Vector3d::Zero(), accel_tau = Vector3d::Zero();
};

/// Dai 2011 eqs 1-4. Equal to the overload for columns, to the last bit.
Motion compensate(const SensorModel& model, const RawSample& raw);

/// The raw readings that compensate to `motion`: Newton from the linear solution. Throws Error where the polynomial cannot be inverted there.
RawSample decompensate(const SensorModel& model, const Motion& motion, const Vector3d& gyro_tau = Vector3d::Zero(),
                       const Vector3d& accel_tau = Vector3d::Zero());

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
void decompensate(const SensorModel& model, const std::array<std::span<const double>, 3>& gyro_temperature,
                  const std::array<std::span<const double>, 3>& accel_temperature, const MotionColumns& columns);

/// Covariance of a compensated sample (rate, then force) from that of the estimated coefficients alone (not from the sample's own noise). Throws
/// Error for a calibration that `validate` refuses.
Eigen::Matrix<double, 6, 6> output_covariance(const Calibration& calibration, const RawSample& raw);

/// The form of the samples that a SampleCompensator takes.
struct SampleOptions {
  std::string_view gyro_unit = "rad/s", accel_unit = "m/s^2";                        ///< of the readings: these, or "count"
  std::string_view gyro_temperature_unit = "degC", accel_temperature_unit = "degC";  ///< or "K", "raw"
  /// Lever arms act over several samples, not on one. false: a model that has some is refused; true: the forces stay those at the accelerometers'
  /// own places, as in all overloads of `compensate` (remove_lever_arms brings those of a recording to the body's origin).
  bool leave_lever_arms = false;
};

/// Compensation for a real-time loop. The model is checked once, when it is made; a call allocates nothing, takes some tens of nanoseconds, and gives
/// what `compensate` and the command give, to the last bit. A reading that is not finite gives a motion that is not.
///
/// Constant after its construction: any number of threads may call one object at the same time without a lock. Copies are independent.
class SampleCompensator {
 public:
  /// Throws Error that lists all of it: a coefficient that is not finite, readings or temperatures in other units than those of the model, thermal
  /// terms without a reference temperature, and lever arms, unless the options leave them.
  explicit SampleCompensator(const SensorModel& model, const SampleOptions& options = {});

  /// Throws Error where the model has thermal terms.
  Motion operator()(const Vector3d& gyro, const Vector3d& accel) const;
  /// With the thermal readings of each axis, as they are read: not less the reference. Those of a triad without thermal terms are not used.
  Motion operator()(const Vector3d& gyro, const Vector3d& accel, const Vector3d& gyro_temperature, const Vector3d& accel_temperature) const {
    return compensate(model_, {gyro, accel, gyro_temperature - gyro_reference_, accel_temperature - accel_reference_});
  }
  /// With one thermal reading for all axes.
  Motion operator()(const Vector3d& gyro, const Vector3d& accel, double temperature) const {
    return (*this)(gyro, accel, Vector3d::Constant(temperature), Vector3d::Constant(temperature));
  }

  bool needs_temperature() const { return needs_temperature_; }

 private:
  SensorModel model_;
  Vector3d gyro_reference_ = Vector3d::Zero(), accel_reference_ = Vector3d::Zero();
  bool needs_temperature_ = false;
};

struct CompensatedRecording {
  Recording recording;                    ///< rates [rad/s] and specific forces [m/s^2] in place of raw readings; the other columns as they were
  std::vector<std::size_t> out_of_range;  ///< samples with a temperature outside the calibrated range, ascending
  std::vector<std::size_t> replaced;      ///< samples with an outlier that was replaced, ascending
};

/// Outliers among the raw readings are kept, or replaced first (outlier_filter.hpp); thermal readings are always kept.
enum class Outliers { keep, reject };

/// Throws Error where the model needs a temperature that the recording lacks, where the recording's units are not those of the model, and where a
/// reading has no finite compensation.
CompensatedRecording compensate(const SensorModel& model, Recording recording, Outliers outliers = Outliers::keep);

/// Brings the forces of a compensated recording from each accelerometer's place (row i of `lever_arm` [m]) to the body's origin, with the angular
/// acceleration from the samples before and after; one-sided at a gap and at the ends.
void remove_lever_arms(Recording& recording, const Matrix3d& lever_arm);

class Compensator {
 public:
  Compensator(SensorModel model, Outliers outliers);

  /// Takes the next samples. With outlier rejection the output lags by two samples until rest().
  CompensatedRecording next(Recording piece);
  /// At the end.
  CompensatedRecording rest();

 private:
  SensorModel model_;
  std::optional<OutlierFilter> filter_;
  Recording held_;  // the samples that are still in the filter
};

}  // namespace imulab
