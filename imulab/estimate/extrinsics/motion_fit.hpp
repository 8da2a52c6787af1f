// The motion of a body as a spline, with the mountings and the errors of the IMUs that felt it: least squares by Gauss-Newton steps.
//
//   gyros           y = (I + E) R w + b + G y_f
//   accelerometers  y = (I + L) R (f + w' x r + w x (w x r)) + c
//
// w, f: rate and force of the first IMU; R, r: rotation and lever arm of another one; E, G, L, b, c: errors of its own, under priors.
#pragma once

#include "imulab/estimate/extrinsics/bordered_band.hpp"
#include "imulab/estimate/extrinsics/stream.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab::extrinsics {

/// Columns of an IMU among the constants. Matrices by rows.
enum Column { gyro_matrix = 0, g_sensitivity = 9, accel_matrix = 18, gyro_offset = 27, accel_offset = 30, own_columns = 33 };
/// Columns after them of each IMU but the first, and their number.
enum MountColumn {
  turn = Mounting::rotation_row,
  arm = Mounting::lever_arm_row,
  offset = Mounting::clock_offset_row,
  drift = Mounting::clock_drift_row,
  delay = Mounting::accel_delay_row,
  mount_columns = Mounting::rows
};

/// One sigma of a mounting before the motion: m, rad, s, relative, s.
inline constexpr double any_arm = 2, any_turn = 10, any_offset = 1, any_drift = 2e-4, any_delay = 0.01;

struct ImuState {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d lever_arm = Vector3d::Zero();
  double offset = 0, drift = 0, delay = 0;
  Eigen::Matrix<double, own_columns, 1> errors = Eigen::Matrix<double, own_columns, 1>::Zero();
  double gyro_sigma = 1, accel_sigma = 1;  ///< of a sample

  Matrix3d matrix(Column first) const { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(errors.data() + first); }
};

/// Information about an IMU's errors before the motion.
using Prior = Eigen::Matrix<double, own_columns, own_columns>;

/// The covariance of the constants, without what noise of the motion seems to show. It is enlarged where the seconds of the motion disagree by more
/// than the noise explains.
struct ConstantsCovariance {
  Eigen::MatrixXd covariance;
  Eigen::VectorXd enlargement;  ///< factor of each standard uncertainty
  Eigen::VectorXd scatter;      ///< chi-square of each constant by the seconds over what the noise explains: 1 is expected
  int seconds = 0;              ///< of the motion
  double change = 0;            ///< of the constants by another step, in standard uncertainties
  Eigen::VectorXd step;         ///< of the constants, that the slope of the squares asks for with the curvature that is not of noise
};

class MotionFit {
 public:
  /// `states`: start. `spans`: on the first clock. `tilt_sigma` [rad]: of a gyro's axis of the first IMU.
  MotionFit(std::vector<Stream> streams, std::vector<ImuState> states, std::vector<Prior> priors, std::vector<Span> spans, double tilt_sigma);

  /// One step; the constants are held where `with_constants` is false. Returns the largest change of a constant in standard uncertainties.
  double step(bool with_constants);
  void move(const Eigen::VectorXd& constants);  ///< adds this to them
  /// Sets the noise of each sensor to that of its residuals after the latest step, corrected for the degrees of freedom; returns the largest relative
  /// change.
  double take_noise();

  const std::vector<ImuState>& states() const { return states_; }
  double epoch() const { return epoch_; }
  static int mount_column(std::size_t imu) { return static_cast<int>(own_columns * imu + mount_columns * (imu - 1)) + own_columns; }
  ConstantsCovariance covariance();  ///< at the present state
  std::vector<BodyResidual> residuals() const;
  enum Sensor : std::size_t { gyros, accels };
  /// Rates as the fit has them and as an IMU has measured them, in its axes; or forces.
  BodyRates rates(std::size_t imu, Sensor sensor = gyros) const;

 private:
  struct Place {
    Eigen::Index knot = 0;  ///< the first of four
    double value[4], first[4], second[4];
  };
  struct Means;
  Place place_at(double t, std::size_t span) const;
  Means means_over(const ImuState& state, const Sample& sample, std::size_t span, double delay) const;
  /// Three rows of the equations, linear at the motion.
  struct Equation {
    Eigen::Index first = 0;  ///< row of the motion
    BorderedBand::ThreeRows knots, constants;
    Vector3d residual;
  };
  Equation equation_of(std::size_t imu, Sensor sensor, std::size_t span, const Sample& sample) const;
  BorderedBand::Solution linearize(bool with_constants);
  template <class Use>
  void for_each_reading(const Use& use) const;
  /// The information about the constants that the difference between this motion and another one gives.
  Eigen::MatrixXd information_of_difference(Eigen::VectorXd other);
  Eigen::VectorXd noisy_motion() const;          ///< with its noise once more
  Eigen::VectorXd motion_without_tilts() const;  ///< without turns that the tilt of a gyro's axis makes of those about another axis
  void add_priors(BorderedBand& equations, Eigen::VectorXd& border) const;
  void take_step(const BorderedBand::Solution& change, bool with_constants);

  std::vector<Stream> streams_;
  std::vector<ImuState> states_;
  std::vector<Prior> priors_;
  std::vector<Span> spans_;
  std::vector<double> start_offsets_;
  std::vector<Eigen::Index> first_knot_;
  double tilt_sigma_ = 0, knot_s_ = 0, epoch_ = 0;
  Eigen::Index longest_ = 0;  ///< knots that a sample depends on
  Eigen::VectorXd motion_;    ///< rate and force at each knot
  int constants_ = 0;
  std::vector<std::vector<int>> columns_;  ///< of the equations of each sensor

  // Of the latest step
  struct SensorSum {
    double squares = 0, samples = 0, used = 0;
  };
  std::vector<double> weights_;  ///< of the readings of each sensor
  std::vector<SensorSum> sums_;  ///< gyros and accelerometers of each IMU
  std::optional<BorderedBand> equations_;
  Eigen::MatrixXd covariance_;  ///< of the constants
  /// Of a second's squares, by the constants and by the knots from the first one on.
  struct Slope {
    Eigen::VectorXd constants;
    Eigen::Index first = 0;
    std::vector<double> motion;
  };
  static void add_to(Slope& slope, Eigen::Index first, const Eigen::VectorXd& by_knots);
  std::vector<Slope> slopes_;
};

}  // namespace imulab::extrinsics
