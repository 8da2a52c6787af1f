// The effects of the table (model/effects.hpp) as parameters of a fit, beside its coefficients and nuisances: r = X x + E c + n, c ~ (0, S). A method
// supplies the derivatives of its residuals by the output of a triad, and the state there; no method knows an effect.
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

/// The columns of an effect, which have one prior sigma.
struct EffectGroup : SizedGroup {
  const Effect* effect;
  double sigma;  ///< SI, in use: as declared, of the grade, or as inferred
};

/// How large the priors of effects and optional terms are: as declared, or of a grade.
struct EffectSizes {
  EffectSigmas declared;
  std::vector<LikelyGrade> grades;
  ImuDeclaration imu = {};  ///< for the terms

  double of(const Effect& effect) const;
};

/// As a session declares them: by the effect's own key, or elsewhere, a turn-on with the noise and the latitude's sigma with the site.
EffectSizes effect_sizes(const Session& session, const SeenOfUnit& seen = {});

class Effects {
 public:
  Effects() = default;  ///< none
  /// All that the setting can have, but for those declared to be 0.
  Effects(const EffectSizes& sizes, const EffectSetting& setting);

  Eigen::Index size() const { return std::ssize(columns_); }
  const std::vector<EffectGroup>& groups() const { return groups_; }
  const std::vector<EffectColumn>& columns() const { return columns_; }
  const Eigen::VectorXd& value() const { return value_; }
  /// Prior sigmas of the columns.
  Eigen::VectorXd sigma() const;
  /// Fills the last size() of the parameters.
  void add_to(Parameters& parameters) const;
  /// Adds the last size() elements of a correction.
  void correct(const Eigen::VectorXd& correction) { value_ += correction.tail(size()); }

  /// Sizes in use of the optional terms.
  const PriorSizes& terms() const { return terms_; }
  /// Infers the sizes of effects and of the optional terms among `coefficients`, the first of the parameters, from a solution under
  /// the present ones, and puts them in place of these. Returns true if one changed by more than 5 %: a fit under them is another.
  bool infer(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients = {});
  /// Absent before `infer`.
  const std::optional<SizePosterior>& posterior() const { return posterior_; }
  /// The likeliest, once sizes were inferred by their evidence, too.
  const std::string& grade() const { return hypotheses_.at(best_).grade; }
  const std::string& grade(std::size_t hypothesis) const { return hypotheses_.at(hypothesis).grade; }
  const std::optional<std::string>& declared_grade() const { return imu_.grade; }
  /// The grade whose effects are nearest to `factor` times those of `grade`.
  std::string grade_of_factor(double factor) const;
  /// What is far larger than expected and stands out of its IMU, and what explains the data as well.
  std::vector<std::string> contradicting() const;
  /// What the last `infer` adds to the logarithm of the data's probability under the sizes in use, since it averages over all sizes.
  double log_gain() const { return log_gain_; }
  /// And to that under the sizes before. Of a cost of data and priors under these no more than all is explained: the covariance of effects far beyond
  /// their sizes is known to some thousandths alone.
  double log_gain_over_before(double cost) const;
  /// By how much the cost of data and priors at their minimum is larger where sizes are the expected ones, or up to four times as large where the
  /// data say so, than with those in use, under which the solution is.
  double cost_of_limits(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients = {}) const;
  /// The predictive test: the probability of as large a cost. From a solution of so many rows, weighted by known noise alone; `dropped`: rows that
  /// were left out.
  double p_value(const Parameters& parameters, const Solution& solution, int rows, std::size_t dropped,
                 const std::vector<CoefficientIndex>& coefficients = {}) const;

  /// The part of the coefficients' covariance that the same IMU brings again in a calibration like this one: the values of its own effects and
  /// optional terms c pull the coefficients by P_xc S^-1 c, S their priors. `covariance`: of the parameters. Empty where sizes are not inferred.
  Eigen::MatrixXd constant_part(const Parameters& parameters, const Eigen::MatrixXd& covariance,
                                const std::vector<CoefficientIndex>& coefficients) const;

  /// Degrees of freedom that the data have in the effects, by their covariance (its last size() rows): as much checks their priors.
  double degrees_of_freedom(const Eigen::MatrixXd& covariance) const;

  /// The part of the triads' outputs that is the effects', at their present values.
  OutputChange output(const EffectState& state) const;
  /// Adds the derivatives of rows that depend on a triad's output without the effects, by those by that output: to the last size() columns.
  void add_derivatives(Eigen::MatrixXd& jacobian, Eigen::Index row, Triad triad, const Eigen::MatrixXd& by_output, const EffectState& state) const;

 private:
  /// Effects, then optional terms: what the data say of them without their priors. A column has the unit of its group's size.
  struct Sized {
    std::vector<SizeHypothesis> hypotheses;
    std::vector<std::string> names = {};
    std::vector<SizedGroup> groups = {};
    std::vector<double> in_use = {};
    std::vector<const Coefficient*> terms = {};  ///< one of each, after the effects
    ReducedEffects data = {};
  };
  /// Sizes of the optional terms of a grade.
  static PriorSizes terms_of(ImuDeclaration imu, const std::string& grade);
  static Eigen::VectorXd by_column(const Sized& of, const std::vector<double>& sizes);
  Sized sized(const Parameters& parameters, const Solution& solution, const std::vector<CoefficientIndex>& coefficients) const;

  std::vector<EffectGroup> groups_;
  std::vector<EffectColumn> columns_;
  std::vector<SizeHypothesis> hypotheses_;  ///< with the sizes of the effects
  std::size_t best_ = 0;                    ///< of these, once inferred
  ImuDeclaration imu_;                      ///< for the terms
  PriorSizes terms_;                        ///< in use
  std::optional<SizePosterior> posterior_;
  double log_gain_ = 0, log_gain_over_before_ = 0, cost_gain_ = 0;
  Sized sized_;
  Eigen::VectorXd value_;
};

}  // namespace imulab::kernel
