// Generalized least squares for a turntable: everything that depends only on the procedure is computed once; an estimate is then one product of a
// matrix and the readings.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/turntable/table_effects.hpp"
#include "imulab/rig/table_motion.hpp"

#include <optional>
#include <vector>

namespace imulab::turntable {

/// Factors by which declared or measured standard deviations are enlarged.
struct Enlargement {
  double accel = 1, gyro = 1;  ///< noise of the sensors
  double table = 1;            ///< errors of the table
};

struct EstimatorOptions {
  std::vector<CoefficientIndex> terms;  ///< matrices whole or diagonal, other terms whole or absent; nonlinearity only with `optional`
  /// Zero-mean priors of optional terms (nonlinearity, g-sensitivity). Absent: g-sensitivity is estimated from the data alone.
  std::optional<kernel::PriorSizes> optional;
  bool all_optional = false;        ///< also estimates optional terms that are not observable
  bool table_errors = true;         ///< false: weights from the sensors' noise alone, without effects
  TableEffects effects;             ///< effects of the unit and its mount, estimated jointly with the table's errors
  bool bias_while_turning = false;  ///< true: the gyro bias in turns is a separate unknown, so W0 is the bias at rest, as in Zhang 2010
  Enlargement enlarged;
  std::vector<std::size_t> left_out;  ///< parts (holds, then turns) with zero weight
  Eigen::VectorXd around;             ///< linearization point: errors of table and site; empty: nominal. Others need linearized readings
};

/// Noise covariance of raw readings.
struct RawNoise {
  Matrix3d accel, gyro;       ///< white, raw^2/Hz
  Eigen::MatrixXd slow = {};  ///< colored noise of the holds' means and turns' sums; empty: none
};

class Estimator {
 public:
  /// `nominal` sets the weights (it propagates table errors to raw readings) and is the start of coefficients that are not determined. Throws
  /// Unsupported if the readings determine each coefficient of the model, but not the model as a whole.
  Estimator(const TableMotion& motion, const SensorModel& nominal, const RawNoise& noise, const EstimatorOptions& options);

  /// Returns the model, to first order in the table's errors.
  SensorModel estimate(const Eigen::VectorXd& readings) const;
  /// Returns columns of the forward model, one for each run.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& readings) const;
  /// Returns the most probable errors of table and site, in the order of TableMotion::sources.
  Eigen::VectorXd table_errors(const Eigen::VectorXd& readings) const;
  /// Returns the readings (one column per run) minus the effect of the most probable table errors beyond first order; all other functions accept
  /// both. At 2 arcsec the difference is negligible; at 1 arcmin it is as large as navigation-grade noise.
  Eigen::MatrixXd linearized(const Eigen::MatrixXd& readings) const;

  /// The estimate from the readings and its covariance.
  struct Uncertainty {
    std::vector<CoefficientIndex> stated;        ///< determined and considered coefficients, in the order of the terms
    std::vector<CoefficientIndex> considered;    ///< weakly observable optional terms: zero, with their prior as uncertainty
    std::vector<CoefficientIndex> undetermined;  ///< other coefficients that the readings do not determine
    Eigen::MatrixXd covariance;                  ///< covariance of `stated`
  };
  Uncertainty uncertainty(const SensorModel& at) const;
  /// Returns d coefficient / d reading, one row for each of `coefficients`.
  Eigen::MatrixXd sensitivity(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) const;
  /// Returns the errors of the coefficients if one of `terms` differs from its prior by one sigma, a column for each of `terms`.
  Eigen::MatrixXd by_prior(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients,
                           const std::vector<CoefficientIndex>& terms) const;
  /// Returns the standard deviations of the forward model's columns that have a prior; 0 for others.
  Eigen::VectorXd optional_sigma() const;
  /// Returns the prior sigmas of the optional terms as coefficients of the model.
  Eigen::VectorXd prior_sigma(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) const;

  /// The remainder of `linearized` readings beyond first order: products of unobservable table errors and of the model's errors. They shift an
  /// estimate by `bias` (estimate minus truth) and add `covariance` to the first-order covariance.
  struct SecondOrder {
    Eigen::VectorXd bias;
    Eigen::MatrixXd covariance;
  };
  SecondOrder second_order(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) const;

  /// Returns d reading / d error of the table and the site.
  auto readings_by_table() const { return readings_by_source_.leftCols(table()); }
  /// Returns d reading / d effect.
  auto readings_by_effects() const { return readings_by_source_.rightCols(readings_by_source_.cols() - table()); }
  const std::vector<kernel::EffectGroup>& effect_groups() const { return effect_groups_; }
  Eigen::VectorXd effects_sigma() const { return source_sigma_.tail(source_sigma_.size() - table()); }
  /// Return the most probable effects, and their covariance, which includes that of the coefficients.
  Eigen::VectorXd effects(const Eigen::VectorXd& readings) const;
  Eigen::MatrixXd effects_covariance() const;
  /// Returns the covariance of the readings without the table's errors.
  const Eigen::MatrixXd& noise() const { return noise_; }

  /// Returns the chi-square of the residuals and of the terms with a prior.
  double chi2(const Eigen::VectorXd& readings) const;
  int degrees_of_freedom() const;
  /// Returns the ratio of the variance in the residuals to the assumed variance, for accelerometer noise, gyro noise and table errors (restricted
  /// maximum likelihood: each ratio that is not at its bound is 1 at the solution). NaN if the readings do not determine it.
  Vector3d variance_ratios(const Eigen::VectorXd& readings) const;
  /// Returns the log probability density of the residuals (restricted likelihood), to compare fits of the same terms and rows.
  double log_likelihood(const Eigen::VectorXd& readings) const;
  /// The information of the readings about columns c that the fit lacks: -2 ln p = (c - V^-1 s)^T V (c - V^-1 s) + ...
  struct Score {
    Eigen::VectorXd s;
    Eigen::MatrixXd V;
  };
  /// Returns the score for each of these changes of the truth, which have six rows per part.
  std::vector<Score> scores(const Eigen::VectorXd& readings, const std::vector<Eigen::MatrixXd>& truth_changes) const;
  /// Returns for each part the RMS of its residuals, in standard deviations of noise and table errors.
  std::vector<double> part_residuals(const Eigen::VectorXd& readings) const;
  /// Returns the condition number of the normal equations; 0 if nothing is determined.
  double condition() const { return condition_; }
  /// Returns for each part the natural logarithm of the p-value of the reduction in chi-square if it is left out.
  std::vector<double> log_probabilities(const Eigen::VectorXd& readings) const;

 private:
  Eigen::Index table() const { return nominal_errors_.size(); }
  void set_weights(const EstimatorOptions& options);
  /// The weighted residuals of the readings.
  struct Unexplained {
    Eigen::VectorXd z;           ///< S^-1 residual
    Eigen::MatrixXd covariance;  ///< covariance of z: B = S^-1 - S^-1 X P X^T S^-1
    Eigen::MatrixXd unfitted;    ///< covariance without a fit: S^-1
  };
  Unexplained unexplained(const Eigen::VectorXd& readings) const;
  void set_gains(bool all_optional);
  Eigen::MatrixXd whitened(const Eigen::MatrixXd& readings) const;

  TableMotion motion_;
  std::vector<kernel::EffectGroup> effect_groups_;
  std::vector<CoefficientIndex> terms_;
  std::vector<Eigen::Index> columns_;                ///< requested columns of the forward model
  std::vector<Eigen::Index> optional_;               ///< those with an effective prior
  std::vector<Eigen::Index> known_;                  ///< determined ones of `columns_`
  Eigen::VectorXd start_, prior_;                    ///< values and prior sigmas of all columns
  Eigen::VectorXd source_sigma_;                     ///< errors of table and site, then effects
  Eigen::VectorXd nominal_errors_, around_, truth_;  ///< `truth_` is at `around_`
  Eigen::MatrixXd truth_by_table_;                   ///< at `around_`
  Eigen::MatrixXd readings_by_source_;               ///< at `around_`: by errors of table and site, then by effects
  Eigen::MatrixXd design_;                           ///< rows x all columns
  Eigen::MatrixXd noise_;                            ///< covariance of the readings without the table's errors
  Eigen::VectorXd weight_;                           ///< weight of each row: 1 / noise, 0 if left out
  Cholesky factor_{Eigen::MatrixXd()};               ///< factor of the weighted covariance with all sources
  Eigen::MatrixXd white_, free_covariance_;          ///< whitened design of known_, and the inverse of its normal equations
  Eigen::MatrixXd gain_;                             ///< known_ x rows
  Eigen::MatrixXd error_gain_;                       ///< sources x rows: table errors beyond the nominal ones, effects
  Eigen::VectorXd expected_;                         ///< readings of the start; both gains apply to differences from them
  Eigen::MatrixXd covariance_;                       ///< covariance of all columns
  double condition_ = 0;
};

/// Returns the full density of a triad's readings from a density declared for calibrated output: N^2 F F^T.
Matrix3d raw_density(double density, const Matrix3d& matrix);

}  // namespace imulab::turntable
