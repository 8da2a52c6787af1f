// Generalized least squares for a turntable: everything that depends on the procedure alone is computed once, and an estimate is then one product of
// a matrix with the readings.
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

/// By which the declared or measured standard deviations are enlarged.
struct Enlargement {
  double accel = 1, gyro = 1;  ///< the sensors' noise
  double table = 1;            ///< the table's errors
};

struct EstimatorOptions {
  std::vector<CoefficientIndex> terms;  ///< matrices whole or diagonal, the other terms whole or not at all; nonlinearity only with `optional`
  /// The priors of terms that an IMU may not have (nonlinearity, g-sensitivity), about zero. Absent: g-sensitivity is estimated by the data alone.
  std::optional<kernel::PriorSizes> optional;
  bool all_optional = false;        ///< estimate also optional terms that the readings do not show
  bool table_errors = true;         ///< false: weights from the sensors' noise alone, without effects
  TableEffects effects;             ///< of the unit and its mount, estimated beside the table's errors
  bool bias_while_turning = false;  ///< true: the gyros' bias in turns is unknown by itself, so that W0 is that at rest, as Zhang estimates it
  Enlargement enlarged;
  std::vector<std::size_t> left_out;  ///< parts (holds, then turns) without any weight
  Eigen::VectorXd around;             ///< errors of the table and the site to linearize at; empty: the nominal ones. Others need linearized readings
};

/// Covariance of noise in raw readings.
struct RawNoise {
  Matrix3d accel, gyro;       ///< white, raw^2/Hz
  Eigen::MatrixXd slow = {};  ///< of the holds' means and turns' sums, from noise that is not white; empty: none
};

class Estimator {
 public:
  /// `nominal` sets the weights (table errors are propagated to raw readings with it) and is the starting value of coefficients that are not
  /// determined. Throws Unsupported where the readings do not determine the model although they determine each of its coefficients.
  Estimator(const TableMotion& motion, const SensorModel& nominal, const RawNoise& noise, const EstimatorOptions& options);

  /// To first order in the table's errors.
  SensorModel estimate(const Eigen::VectorXd& readings) const;
  /// Columns of the forward model, a run each.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& readings) const;
  /// The most probable errors of the table and the site, as TableMotion::sources.
  Eigen::VectorXd table_errors(const Eigen::VectorXd& readings) const;
  /// The readings (a run each column) less the effect of the most probable table errors beyond first order; every other function takes them as it
  /// takes readings. At 2 arcsec the difference is negligible; at 1 arcmin it is of the size of navigation-grade noise.
  Eigen::MatrixXd linearized(const Eigen::MatrixXd& readings) const;

  /// The estimate from the readings, with its covariance.
  struct Uncertainty {
    std::vector<CoefficientIndex> stated;        ///< the determined and the considered ones, in the order of the terms
    std::vector<CoefficientIndex> considered;    ///< optional terms that the readings hardly show: zero, their prior counts
    std::vector<CoefficientIndex> undetermined;  ///< the others that they do not determine
    Eigen::MatrixXd covariance;                  ///< of `stated`
  };
  Uncertainty uncertainty(const SensorModel& at) const;
  /// d coefficient / d reading, one row for each of `coefficients`.
  Eigen::MatrixXd sensitivity(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) const;
  /// Errors of the coefficients where the truth of one of `terms`, with a prior, is off by one sigma of it: a column for each of `terms`.
  Eigen::MatrixXd by_prior(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients,
                           const std::vector<CoefficientIndex>& terms) const;
  /// Standard deviations of the forward model's columns that have a prior; 0 of the others.
  Eigen::VectorXd optional_sigma() const;
  /// Prior sigmas of the optional terms, of the model's coefficients.
  Eigen::VectorXd prior_sigma(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) const;

  /// The remainder of `linearized` readings beyond first order: products of the table errors that no reading shows and of the model's own errors.
  /// They shift an estimate by `bias` (estimate less truth) and scatter it by `covariance` on top of the first order's.
  struct SecondOrder {
    Eigen::VectorXd bias;
    Eigen::MatrixXd covariance;
  };
  SecondOrder second_order(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) const;

  /// d reading / d error of the table and the site.
  auto readings_by_table() const { return readings_by_source_.leftCols(table()); }
  /// d reading / d effect.
  auto readings_by_effects() const { return readings_by_source_.rightCols(readings_by_source_.cols() - table()); }
  const std::vector<kernel::EffectGroup>& effect_groups() const { return effect_groups_; }
  Eigen::VectorXd effects_sigma() const { return source_sigma_.tail(source_sigma_.size() - table()); }
  /// The most probable effects, and their covariance with that of the coefficients in it.
  Eigen::VectorXd effects(const Eigen::VectorXd& readings) const;
  Eigen::MatrixXd effects_covariance() const;
  /// Covariance of the readings without the table's errors.
  const Eigen::MatrixXd& noise() const { return noise_; }

  /// Chi-square of the residuals, and of the terms with a prior against it.
  double chi2(const Eigen::VectorXd& readings) const;
  int degrees_of_freedom() const;
  /// By accelerometers' noise, gyros' noise and table errors: the variance that the residuals show over the one they were given (restricted maximum
  /// likelihood: at its solution each that is not at its bound is 1). NaN where the readings show nothing of it.
  Vector3d variance_ratios(const Eigen::VectorXd& readings) const;
  /// Of the residuals, the logarithm of their probability density (restricted likelihood), to compare fits of the same terms and rows.
  double log_likelihood(const Eigen::VectorXd& readings) const;
  /// Of columns c that the fit lacks, what the readings say: -2 ln p = (c - V^-1 s)^T V (c - V^-1 s) + ...
  struct Score {
    Eigen::VectorXd s;
    Eigen::MatrixXd V;
  };
  /// For each of these changes of the truth, six rows a part.
  std::vector<Score> scores(const Eigen::VectorXd& readings, const std::vector<Eigen::MatrixXd>& truth_changes) const;
  /// By part, the RMS of its residuals in the standard deviations of noise and table errors.
  std::vector<double> part_residuals(const Eigen::VectorXd& readings) const;
  /// The condition number of the normal equations; 0 where nothing is determined.
  double condition() const { return condition_; }
  /// By part, the natural logarithm of the probability that leaving it out lowers chi-square by as much as it does by chance.
  std::vector<double> log_probabilities(const Eigen::VectorXd& readings) const;

 private:
  Eigen::Index table() const { return nominal_errors_.size(); }
  void set_weights(const EstimatorOptions& options);
  /// The residuals of the readings, weighted.
  struct Unexplained {
    Eigen::VectorXd z;           ///< S^-1 residual
    Eigen::MatrixXd covariance;  ///< of z: B = S^-1 - S^-1 X P X^T S^-1
    Eigen::MatrixXd unfitted;    ///< that without a fit: S^-1
  };
  Unexplained unexplained(const Eigen::VectorXd& readings) const;
  void set_gains(bool all_optional);
  Eigen::MatrixXd whitened(const Eigen::MatrixXd& readings) const;

  TableMotion motion_;
  std::vector<kernel::EffectGroup> effect_groups_;
  std::vector<CoefficientIndex> terms_;
  std::vector<Eigen::Index> columns_;                ///< of the forward model: those asked for
  std::vector<Eigen::Index> optional_;               ///< of these: with a prior that counts
  std::vector<Eigen::Index> known_;                  ///< of `columns_`: determined
  Eigen::VectorXd start_, prior_;                    ///< values and prior sigmas of all columns
  Eigen::VectorXd source_sigma_;                     ///< of the errors of the table and the site, then of the effects
  Eigen::VectorXd nominal_errors_, around_, truth_;  ///< the latter at `around_`
  Eigen::MatrixXd truth_by_table_;                   ///< at `around_`
  Eigen::MatrixXd readings_by_source_;               ///< at `around_`: by the errors of the table and the site, then by the effects
  Eigen::MatrixXd design_;                           ///< rows x all columns
  Eigen::MatrixXd noise_;                            ///< covariance of the readings without the table's errors
  Eigen::VectorXd weight_;                           ///< by row: 1 / noise, 0 where left out
  Cholesky factor_{Eigen::MatrixXd()};               ///< of the weighted covariance with all sources
  Eigen::MatrixXd white_, free_covariance_;          ///< whitened design of known_, and the inverse of its normal equations
  Eigen::MatrixXd gain_;                             ///< known_ x rows
  Eigen::MatrixXd error_gain_;                       ///< sources x rows: table errors found beyond the nominal ones, effects
  Eigen::VectorXd expected_;                         ///< readings of the start; both gains take what readings differ by from them
  Eigen::MatrixXd covariance_;                       ///< of all columns
  double condition_ = 0;
};

/// The whole density of a triad's readings where it is declared on the calibrated side: N^2 F F^T.
Matrix3d raw_density(double density, const Matrix3d& matrix);

}  // namespace imulab::turntable
