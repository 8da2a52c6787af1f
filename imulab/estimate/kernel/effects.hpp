// The effects of the table (model/effects.hpp) as parameters of a fit, beside its coefficients and nuisances: r = X x + E c + n, c ~ (0, S). A method
// supplies the derivatives of its residuals by the output of a triad, and the state there; no method knows an effect.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/information.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/session.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::kernel {

/// The columns of an effect, which have one prior sigma [SI].
struct EffectGroup {
  const Effect* effect;
  Eigen::Index first, size;
  double sigma;
  double widened = 1;  ///< the factor in it
};

/// How large the priors are: as declared, by the grade, or by the accelerometers' offset [m/s^2].
struct EffectSizes {
  EffectSigmas declared;
  std::string grade;
  double accel_offset = 0;
};

/// As a session declares them: by the effect's own key, or elsewhere, a turn-on with the noise and the latitude's sigma with the site. Offsets that
/// are no small ones [m/s^2] tell nothing: those of a MEMS sensor.
EffectSizes effect_sizes(const Session& session, const Vector3d& accel_offset);

/// Parameters that share a prior about zero: an effect's, or those of an optional term.
struct PriorGroup {
  std::string name;
  std::vector<Eigen::Index> at;
};

/// A group whose prior the data contradict.
struct Contradicted {
  std::size_t group = 0;
  double factor = 1;               ///< by which the data ask for a wider one
  double evidence = 0;             ///< that logarithm
  std::vector<std::string> alike;  ///< its name, and those of groups that explain the data as well
};

/// The group for which most speaks: the logarithm of the ratio of the data's probabilities with the wider prior and the present one. `data` are
/// weighted by noise alone: a prior that is wider explains what the noise does not, and leaves residuals that chance explains better by the F
/// distribution.
std::optional<Contradicted> contradicted_prior(const Information& data, const Parameters& parameters, const std::vector<PriorGroup>& groups);

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

  /// The groups as the last size() of so many parameters.
  std::vector<PriorGroup> prior_groups(Eigen::Index parameters) const;
  /// Widens the prior of the effect that contradicts it most, at most to `most_widening`, or else of one that is more likely with the widest; whether
  /// any is. The latter is no cause, as that is no rare event: an honest uncertainty of what it does, not a fault. None for which less speaks than
  /// `for_another` explanation (a logarithm as Deviation::evidence has it). `data` as of `contradicted_prior`.
  bool widen(const Information& data, const Parameters& parameters, double for_another = 0);
  /// That of one more likely with the widest, unless noise of another size than stated explains as much; whether any is.
  bool widen_if_likelier(const Information& data, const Parameters& parameters, double for_another = 0);
  /// What explains the data beyond the priors: effects, and optional terms.
  const std::vector<std::string>& causes() const { return causes_; }
  void add_causes(const std::vector<std::string>& names);
  static constexpr double most_widening = 4;
  /// A wider prior of a group. What speaks for it is the logarithm of the ratio of the data's probabilities, with as wide a prior as the data ask
  /// for.
  struct Wider {
    std::size_t group = 0;
    double factor = 1;  ///< to be applied: 1 where the prior is as wide as it may be
    double evidence = 0;
  };
  /// The groups whose present values contradict their priors, by their covariance (its last size() rows); that for which most speaks first.
  std::vector<Wider> contradicted(const Eigen::MatrixXd& covariance) const;
  void widen(const Wider& wider) { groups_[wider.group].sigma *= wider.factor, groups_[wider.group].widened *= wider.factor; }

  /// Degrees of freedom that the data have in the effects, by their covariance (its last size() rows): as much checks their priors.
  double degrees_of_freedom(const Eigen::MatrixXd& covariance) const;

  /// The part of the triads' outputs that is the effects', at their present values.
  OutputChange output(const EffectState& state) const;
  /// Adds the derivatives of rows that depend on a triad's output without the effects, by those by that output: to the last size() columns.
  void add_derivatives(Eigen::MatrixXd& jacobian, Eigen::Index row, Triad triad, const Eigen::MatrixXd& by_output, const EffectState& state) const;

 private:
  /// For whose widest prior most speaks, of those with the prior expected, if enough does.
  std::optional<Wider> likelier(const Eigen::VectorXd& value, const Eigen::MatrixXd& covariance) const;

  std::vector<EffectGroup> groups_;
  std::vector<EffectColumn> columns_;
  Eigen::VectorXd value_;
  std::vector<std::string> causes_;
};

/// What the data say of an effect by themselves, without its prior.
struct EffectTest {
  const Effect* effect = nullptr;
  int rank = 0;          ///< of its columns: those that the data see
  double statistic = 0;  ///< chi-square of that rank where the effect is absent
  double p_value = 1;
  double log_evidence = 0;       ///< of the effect against its absence: logarithm of the ratio of the likelihoods, with its prior
  Eigen::VectorXd value, sigma;  ///< of its columns, with the prior
};

/// From the joint fit: with P_kk the covariance of effect k and S_k its prior, V_k = P_kk^-1 - S_k^-1 and s_k = P_kk^-1 c_k. Every effect once.
std::vector<EffectTest> test_effects(const Effects& effects, const Eigen::MatrixXd& covariance);

/// Adds the effects to a result: each with value and uncertainty [user units], and whether it is significant among all at `level`; their causes, as
/// doubts where a prior was widened; and which are assumed to be as small as expected: larger ones would not show, though they shift coefficients.
/// The first rows of the covariance are those of `coefficients`, where it has any.
void add_effects(Calibration& calibration, Findings& findings, const Effects& effects, const Eigen::MatrixXd& covariance, double level,
                 const std::vector<CoefficientIndex>& coefficients = {});

}  // namespace imulab::kernel
