// Common to the conditions of both methods on rests: the rests, the coefficients to estimate, and their priors.
#pragma once

#include "imulab/estimate/coarse/rest_start.hpp"
#include "imulab/estimate/rests/conditions.hpp"

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::rests {

/// A rest or a rotation as a whole.
struct SuspectRows {
  std::string name;
  std::vector<Eigen::Index> rows;
  double begin_s = 0, end_s = 0;
  bool rotation = false;
};

/// A rest and the part of its state that does not follow from its means.
struct Rest : RestMeans {
  EffectState observed;
};

/// The states of the rests: their time, the accelerometers' play, the force's variance, the temperature.
std::vector<EffectState> rest_states(const Recording& recording, const coarse::RestStart& start, const kernel::RecordedStates& recorded);

/// The coefficients that the two methods estimate: those observable in gravity at rest, with the gyros at rest; and with the rotations between rests.
std::vector<CoefficientIndex> static_coefficients(bool with_gyros);
std::vector<CoefficientIndex> handheld_coefficients();

/// kernel::chosen_coefficients, once `start.model` has both triads; those of `supplied` that are not chosen are set to their prior. Sets
/// `start.effects` with `start.states`, and `start.named`. Throws TermsError for offsets and scales of counts that are not chosen,
/// too.
std::vector<CoefficientIndex> choose_coefficients(coarse::RestStart& start, const Session& session, const Recording& recording, bool with_effects,
                                                  const std::vector<CoefficientIndex>& wanted, const std::vector<CoefficientIndex>& supplied,
                                                  std::string_view method);

/// A derived problem with unknowns or parts of its own shadows the functions that handle these.
class RestProblem {
 public:
  /// The coefficients, then `nuisances` estimated without a prior, then the effects.
  kernel::Parameters parameters(Eigen::Index nuisances = 0) const;
  /// A correction's elements: up to the prior of those that all IMUs have; the equations are linear in the optional terms, which are small.
  Eigen::VectorXd longest_step(Eigen::Index nuisances = 0) const;
  void correct(const Eigen::VectorXd& correction);
  /// Every rest, with the rows of its own block.
  std::vector<SuspectRows> suspects(const Conditions& conditions) const;
  /// These terms go back to their prior value and stay there: considered.
  void hold(const std::vector<Eigen::Index>& unseen);
  /// Estimates them again: future rests may show them.
  void release();
  /// Does nothing: rests alone have no rotations.
  void leave_out_rotations() {}
  /// The prior of a coefficient of scaled readings: offsets 20 % of g and 1 rad/s, scales 20 %, misalignments 1e-2 (20 % where the row does not point
  /// along its axis: axes swapped), which contain uncalibrated units; optional terms by kernel::optional_priors.
  double prior_sigma(const Coefficient& c) const;
  /// The effects with other sizes.
  void take_sizes(kernel::Effects sized) { effects_ = std::move(sized); }
  /// Nonlinearity of counts whose zero is far outside the readings: about their center it counts in the uncertainties, but a polynomial about zero
  /// would only blur the offset and the scale there.
  bool unstated(std::size_t coefficient) const { return unstated_[coefficient]; }
  /// Optional terms that are estimated although the data do not show them.
  std::vector<Eigen::Index> unseen_terms(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const;
  /// All of the gyros' matrix, and their nonlinearity with it, where one of its scales is not determined and went far from its prior: few
  /// rotations, perhaps wrong ones, do not determine it.
  std::vector<Eigen::Index> runaway_gyro_matrix(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const;

  const std::vector<Rest>& rests() const { return rests_; }
  const kernel::Effects& effects() const { return effects_; }
  const std::vector<CoefficientIndex>& indices() const { return indices_; }
  const SensorModel& model() const { return model_; }  ///< of scaled readings
  const SensorModel& prior() const { return prior_; }
  const Scaling& scaling() const { return scaling_; }
  double relative_gravity_sigma() const { return relative_gravity_sigma_; }

 protected:
  RestProblem(const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices);
  /// Specific force and rate that the model gives at a rest.
  Vector3d force_at(const Rest& rest) const;
  Vector3d rate_at(const Rest& rest) const;
  Matrix3d force_covariance(const Rest& rest, double spread) const;
  Matrix3d rate_covariance(const Rest& rest, double spread) const;
  /// Adds the derivatives of rows by the coefficients of a triad, from those by the force (accelerometers) or the rate (gyros) at a rest.
  void add_derivatives(Conditions& c, Eigen::Index row, Triad triad, const Rest& rest, const Eigen::MatrixXd& by_output) const;

  /// Force and rate of the model, without the effects that the force and the rate have in it.
  EffectState state_at(const Rest& rest) const;

  std::vector<Rest> rests_;
  double first_s_;  ///< stamp of the first sample
  double gravity_, relative_gravity_sigma_;
  std::optional<double> latitude_;
  Scaling scaling_;
  MeanNoise noise_;  ///< scaled
  SensorModel model_, prior_;
  kernel::Effects effects_;
  std::vector<CoefficientIndex> indices_;
  std::vector<kernel::Role> roles_;  ///< of the coefficients
  std::vector<char> unstated_;       ///< considered, but not in the result: nonlinearity of counts
};

/// The gyros' start: Cheng's linear solution where they resolve Earth's rate, else as declared, with a note why. False: they are not calibrated.
bool start_gyros_at_rest(coarse::RestStart& start, const Recording& recording, const Session& session);

/// Each rest gives |f| = g and, with the gyros, the vertical and horizontal parts of Earth's rate:
///   up . w = w_ie sin L          (Cheng 2014 eq 12)
///   |w - up (up . w)| = w_ie cos L
class StaticProblem : public RestProblem {
 public:
  StaticProblem(const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices, bool with_gyros);

  Conditions conditions(const Spreads& spreads) const;
  void drop(std::size_t suspect) { rests_.erase(rests_.begin() + static_cast<std::ptrdiff_t>(suspect)); }

 private:
  void add_rest(Conditions& c, Eigen::Index row, const Rest& rest, const Spreads& spreads) const;
  bool with_gyros_;
};

}  // namespace imulab::rests
