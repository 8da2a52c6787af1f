// Effects of the table (model/effects.hpp) as parameters of a fit, in addition to its coefficients and nuisances: r = X x + E c + n, c ~ (0, S). A
// method supplies the derivatives of its residuals with respect to a triad's output, and the state of each observation. No method refers to a
// particular effect.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/information.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/kernel/size_inference.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/session.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::kernel {

/// The columns of an effect, which share one prior sigma.
struct EffectGroup : SizedGroup {
  const Effect* effect;
  double sigma;  ///< current prior sigma [SI]: declared, from the grade, or inferred
};

/// Prior sizes of effects and optional terms: declared or from a grade.
struct EffectSizes {
  EffectSigmas declared;
  std::vector<LikelyGrade> grades;
  ImuDeclaration imu = {};  ///< declaration for the optional terms

  double of(const Effect& effect) const;
};

/// Returns the sizes that a session declares, by the effect's own key or elsewhere: turn-on with the noise, latitude sigma with the site.
EffectSizes effect_sizes(const Session& session, const SeenOfUnit& seen = {});

class Effects {
 public:
  Effects() = default;  ///< constructs a set without effects
  /// Includes every effect that can occur in the setting, unless its declared size is 0.
  Effects(const EffectSizes& sizes, const EffectSetting& setting);

  Eigen::Index size() const { return std::ssize(columns_); }
  const std::vector<EffectGroup>& groups() const { return groups_; }
  const std::vector<EffectColumn>& columns() const { return columns_; }
  const Eigen::VectorXd& value() const { return value_; }
  /// Returns the prior sigmas of the columns.
  Eigen::VectorXd sigma() const;
  /// Sets the last size() parameters.
  void add_to(Parameters& parameters) const;
  /// Adds the last size() elements of a correction to the values.
  void correct(const Eigen::VectorXd& correction) { value_ += correction.tail(size()); }

  /// Returns the current sizes of the optional terms.
  const PriorSizes& terms() const { return terms_; }
  /// Infers the sizes of effects and optional terms among `coefficients` (the first parameters) from a solution under the current sizes, and replaces
  /// these. Returns true if a size changed by more than 5 %, which requires another fit.
  bool infer(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients = {});
  /// Returns the posterior of the sizes; absent before `infer`.
  const std::optional<SizePosterior>& posterior() const { return posterior_; }
  /// Returns the most probable grade; after `infer`, this includes the evidence of the effects.
  const std::string& grade() const { return hypotheses_.at(best_).grade; }
  const std::string& grade(std::size_t hypothesis) const { return hypotheses_.at(hypothesis).grade; }
  const std::optional<std::string>& declared_grade() const { return imu_.grade; }
  /// Returns the grade whose effects are closest to `factor` times the effects of `grade`.
  std::string grade_of_factor(double factor) const;
  /// Returns effects that are far larger than expected and than the IMU's other effects, and effects that explain the data equally well.
  std::vector<std::string> contradicting() const;
  /// Returns the gain in log probability of the data from averaging over all sizes, relative to the sizes in use after the last `infer`.
  double log_gain() const { return log_gain_; }
  /// Returns that gain relative to the sizes before that call. `cost`, of data and priors under those sizes, limits it: the covariance of effects far
  /// beyond their sizes is accurate only to some thousandths.
  double log_gain_over_before(double cost) const;
  /// Returns the increase of the minimum cost of data and priors if the inferred sizes are limited to four times the expected sizes. `solution`
  /// belongs to the sizes in use.
  double cost_of_limits(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients = {}) const;
  /// Returns the p-value of the cost (predictive test). `solution` has `rows` rows, weighted by the known noise only; `dropped` rows were left out.
  double p_value(const Parameters& parameters, const Solution& solution, int rows, std::size_t dropped,
                 const std::vector<CoefficientIndex>& coefficients = {}) const;

  /// Returns the part of the coefficients' covariance that recurs in a similar calibration of the same IMU: the values c of its own effects and
  /// optional terms shift the coefficients by P_xc S^-1 c, with prior S. `covariance` belongs to the parameters. Empty if no sizes are inferred.
  Eigen::MatrixXd constant_part(const Parameters& parameters, const Eigen::MatrixXd& covariance,
                                const std::vector<CoefficientIndex>& coefficients) const;

  /// Returns the degrees of freedom that the data have in the effects, from their covariance (its last size() rows). As many check the priors.
  double degrees_of_freedom(const Eigen::MatrixXd& covariance) const;

  /// Returns the contribution of the effects to the triads' outputs, at their present values.
  OutputChange output(const EffectState& state) const;
  /// Writes derivatives with respect to effects to the last size() columns, for rows with derivatives `by_output` with respect to a triad's output.
  void add_derivatives(Eigen::MatrixXd& jacobian, Eigen::Index row, Triad triad, const Eigen::MatrixXd& by_output, const EffectState& state) const;

 private:
  /// Effects followed by optional terms, and their information without priors. Each column has the unit of its group's size.
  struct Sized {
    std::vector<SizeHypothesis> hypotheses;
    std::vector<std::string> names = {};
    std::vector<SizedGroup> groups = {};
    std::vector<double> in_use = {};
    std::vector<const Coefficient*> terms = {};  ///< one term of each kind, after the effects
    ReducedEffects data = {};
  };
  /// Returns the sizes of a grade's optional terms.
  static PriorSizes terms_of(ImuDeclaration imu, const std::string& grade);
  static Eigen::VectorXd by_column(const Sized& of, const std::vector<double>& sizes);
  Sized sized(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients) const;

  std::vector<EffectGroup> groups_;
  std::vector<EffectColumn> columns_;
  std::vector<SizeHypothesis> hypotheses_;  ///< hypotheses with effect sizes
  std::size_t best_ = 0;                    ///< index of the best hypothesis after inference
  ImuDeclaration imu_;                      ///< declaration for the terms
  PriorSizes terms_;                        ///< sizes in use
  std::optional<SizePosterior> posterior_;
  double log_gain_ = 0, log_gain_over_before_ = 0, cost_gain_ = 0;
  Sized sized_;
  Eigen::VectorXd value_;
};

}  // namespace imulab::kernel
