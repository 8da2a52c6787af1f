// Extrinsics: rotation, lever arm and clock offset between IMUs on one rigid body, from any motion that all of them felt.
//
// Example:
//   const BodyImu calibrated{.name = "a", .recording = recording, .calibration = calibration};
//   const Extrinsics found = estimate_extrinsics({calibrated, {.name = "b", .recording = make_recording(t, gyro, accel)}});
//   const Mounting b = found.between(0, 1);
//   std::printf("x %g m, u = %g m\n", b.lever_arm.x(), b.uncertainties(Mounting::lever_arm_row).x());
//
// The motion is a cubic spline of the rates and forces of the first IMU, estimated with the mountings, so its noise biases no lever arm. Errors of
// the IMUs themselves are considered: with the covariance of their calibrations, else as large as is expected of the grade. Values are SI. Readings
// are means over the interval that ends at their stamp.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/finding.hpp"
#include "imulab/recording.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// An IMU of a body.
struct BodyImu {
  std::string name;
  Recording recording;                       ///< in the units of the calibration; in SI without one
  std::optional<Calibration> calibration{};  ///< removes the IMU's own errors
  std::string grade = "mems";                ///< sizes of the errors that no calibration has determined
  std::int64_t clock_zero_ns = 0;            ///< time of the recording's stamp 0 on its clock
};

/// The pose and clock of IMU `to` relative to IMU `from`.
struct Mounting {
  /// Rows of the covariance: rotation [rad, about the axes of `to`] and lever arm have three each.
  enum Row { rotation_row = 0, lever_arm_row = 3, clock_offset_row = 6, clock_drift_row = 7, accel_delay_row = 8, rows = 9 };

  std::string from, to;
  Matrix3d rotation = Matrix3d::Identity();  ///< takes a vector from the axes of `from` to those of `to`
  Vector3d lever_arm = Vector3d::Zero();     ///< m: position of `to` in the axes of `from`
  double clock_offset = 0;                   ///< s: stamp of `to` minus stamp of `from` for the same instant, at `epoch`
  double clock_drift = 0;                    ///< relative: rate of the clock of `to`, minus 1
  double accel_delay = 0;                    ///< s: delay of the accelerometers of `to` against its gyros, minus that of `from`
  double epoch = 0;                          ///< s on the clock of the first IMU, from its first stamp
  Eigen::Matrix<double, rows, rows> covariance = Eigen::Matrix<double, rows, rows>::Zero();
  std::vector<std::string> not_shown = {};  ///< what this motion does not show: "lever arm along (0.00, 0.71, 0.71)"

  double uncertainty(int row) const;        ///< standard uncertainty
  Vector3d uncertainties(Row first) const;  ///< of rotation_row or lever_arm_row
  /// Takes points from the axes of `from` to those of `to`, as Kalibr's T_i_b does: rotation, and minus the rotated lever arm.
  Eigen::Matrix4d matrix() const;
};

/// What a fit left of an IMU's readings.
struct BodyResidual {
  double gyro = 0, accel = 0;  ///< rad/s, m/s^2: RMS over axes and samples, corrected for the degrees of freedom
  std::size_t samples = 0;
};

/// Rates of two IMUs in the axes of the second, for a picture.
struct BodyRates {
  std::vector<double> time;          ///< s on the clock of the first IMU, from its first stamp
  Columns3 first, second, residual;  ///< rad/s
};

struct Extrinsics {
  std::vector<std::string> imus;
  std::vector<Mounting> from_first;     ///< of each other IMU
  Eigen::MatrixXd covariance;           ///< of all mountings, Mounting::rows each
  std::vector<BodyResidual> residuals;  ///< of each IMU
  std::vector<BodyRates> rates;         ///< of each other IMU beside the first
  std::vector<double> agreement;        ///< of each other IMU: correlation of its angular rate with that of the first, at the found offset
  double duration = 0, used = 0;        ///< s in common, and used
  Verdict verdict = Verdict::none;
  Findings findings = {};

  /// The mounting of IMU `to` relative to IMU `from`, by index.
  Mounting between(std::size_t from, std::size_t to) const;
};

/// Estimates the mountings of two or more IMUs. `progress` receives the fraction done. Throws Error for fewer than two IMUs, equal names, an unknown
/// grade, recordings in counts without a calibration, and as `compensate` does; Unsupported if the records have no 5 s in common, show no turns, or
/// one is mirrored.
Extrinsics estimate_extrinsics(const std::vector<BodyImu>& imus, const std::function<void(double)>& progress = {});

/// What this motion of one IMU would show of another one like it, 0.1 m away along each axis and turned about none of them alone: the uncertainties are those that estimate_extrinsics
/// would state, the values are NaN, and the findings have a note of it. Errors are as large as expected of the grade; a calibration only converts the readings. Throws as
/// estimate_extrinsics does.
Extrinsics predict_extrinsics(const BodyImu& imu);

/// Improves the calibrations of two or more IMUs by a motion that all of them felt, also if they are of the same records: each coefficient stays as
/// it is or becomes more certain, whatever the correlation. The calibrations' errors must be independent but for that of g, so not those of one table.
/// Each result says so in a note; where the calibrations contradict each other, all are doubtful and keep their values. Throws Error for one without a
/// calibration that is good, and Unsupported if the motion is not in common; also as estimate_extrinsics does.
std::vector<Calibration> calibrate_jointly(std::vector<BodyImu> imus, const std::function<void(double)>& progress = {});

}  // namespace imulab
