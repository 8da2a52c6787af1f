// Generalized least squares for a turntable: everything that depends on the procedure alone is computed once, and an estimate is then one product of
// a matrix with the readings.
#pragma once

#include "imulab/estimate/turntable_problem.hpp"

#include <Eigen/Core>

namespace imulab {

struct TurntableSettings {
  std::vector<int> terms;             ///< table indices; matrices whole or diagonal, the other terms whole or not at all
  bool table_errors = true;           ///< false: weights from the sensors' noise alone
  bool bias_while_turning = false;    ///< true: the gyros' bias in turns is unknown by itself, so that W0 is that at rest, as Zhang estimates it
  std::vector<std::size_t> left_out;  ///< parts (holds, then turns) without any weight
  Eigen::VectorXd around;             ///< errors of the table and the site to linearise at; empty: the nominal ones. Others need linearised readings
};

/// Covariance of white noise in raw readings, raw^2/Hz.
struct RawNoise {
  Matrix3d accel, gyro;
};

class TurntableEstimator {
 public:
  /// `nominal` sets the weights (table errors are propagated to raw readings with it) and is the starting value of what stays undetermined.
  TurntableEstimator(const TableMotion& motion, const SensorModel& nominal, const RawNoise& noise, const TurntableSettings& settings);

  /// To first order in the table's errors.
  SensorModel estimate(const Eigen::VectorXd& readings) const;
  /// Columns of the forward model, a run each.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& readings) const;
  /// The most probable errors of the table and the site, as TableMotion::sources.
  Eigen::VectorXd table_errors(const Eigen::VectorXd& readings) const;
  /// The readings (a run each column) less what the most probable table errors do to them beyond first order; every other function takes them as it
  /// takes readings. At 2 arcsec nothing of it is seen; at 1 arcmin it is of the size of navigation-grade noise.
  Eigen::MatrixXd linearised(const Eigen::MatrixXd& readings) const;

  /// What the readings determine, and how well.
  struct Uncertainty {
    std::vector<int> determined, undetermined;  ///< table indices
    Eigen::MatrixXd covariance;                 ///< of the determined
  };
  Uncertainty uncertainty(const SensorModel& at) const;
  /// d coefficient / d reading, one row for each of `coefficients`.
  Eigen::MatrixXd sensitivity(const SensorModel& at, const std::vector<int>& coefficients) const;

  /// What remains of `linearised` readings beyond first order: products of the table errors that no reading shows and of the model's own errors. They
  /// shift an estimate by `bias` (estimate less truth) and scatter it by `covariance` on top of the first order's.
  struct SecondOrder {
    Eigen::VectorXd bias;
    Eigen::MatrixXd covariance;
  };
  SecondOrder second_order(const SensorModel& at, const std::vector<int>& coefficients) const;

  /// d reading / d error of the table and the site.
  const Eigen::MatrixXd& table_jacobian() const { return table_jacobian_; }
  /// Covariance of the readings without the table's errors.
  const Eigen::MatrixXd& noise() const { return noise_; }

  double chi2(const Eigen::VectorXd& readings) const;
  int degrees_of_freedom() const;
  double condition() const { return condition_; }
  /// By part, the natural logarithm of the probability that leaving it out lowers chi-square by as much as it does by chance.
  std::vector<double> log_probabilities(const Eigen::VectorXd& readings) const;

 private:
  Eigen::VectorXd whitened_residual(const Eigen::VectorXd& readings) const;

  TableMotion motion_;
  std::size_t holds_, parts_;
  std::vector<int> terms_;
  std::vector<char> left_out_;         ///< by part
  Eigen::VectorXd start_;              ///< all columns of the forward model
  std::vector<Eigen::Index> columns_;  ///< asked for
  std::vector<Eigen::Index> known_, unknown_;
  Eigen::VectorXd prior_;   ///< sigma, all columns
  Eigen::VectorXd weight_;  ///< by row: 1 / noise, 0 where left out
  Eigen::MatrixXd design_, factor_,
      white_;             ///< rows x all columns; Cholesky factor of the weighted covariance; its inverse x weighted design of known_
  Eigen::MatrixXd gain_;  ///< known_ x rows
  Eigen::VectorXd base_;  ///< gain_ x what the columns held at their start explain
  Eigen::VectorXd nominal_errors_, around_, truth_;  ///< the latter at `around`
  Eigen::MatrixXd truth_jacobian_, table_jacobian_;  ///< truth and readings x sources, at `around`
  Eigen::MatrixXd noise_;                            ///< covariance of the readings without the table's errors
  Eigen::MatrixXd error_gain_;                       ///< sources x rows: table errors found, from readings
  Eigen::VectorXd error_base_;                       ///< table errors found at readings of zero
  Eigen::MatrixXd covariance_;              ///< of all columns, forward
  double condition_ = 0;
};

/// The whole density of a triad's readings where it is declared on the calibrated side: N^2 F F^T.
Matrix3d raw_density(double density, const Matrix3d& matrix);

}  // namespace imulab
