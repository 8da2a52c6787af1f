// The common part of the conditions of both methods on rests: rests, coefficients to estimate, and priors.
#pragma once

#include "imulab/estimate/coarse/rest_start.hpp"
#include "imulab/estimate/rests/conditions.hpp"

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::rests {

/// The rows of a rest or a rotation as a whole.
struct SuspectRows {
  std::string name;
  std::vector<Eigen::Index> rows;
  double begin_s = 0, end_s = 0;
  bool rotation = false;
};

/// A rest, and the part of its state that does not follow from its mean readings.
struct Rest : RestMeans {
  EffectState observed;
};

/// Returns the states of the rests: time, play of the accelerometers, variance of the force, temperature.
std::vector<EffectState> rest_states(const Recording& recording, const coarse::RestStart& start, const kernel::RecordedStates& recorded);

/// Return the coefficients of the two methods: those observable from gravity at rest, and gyros at rest; and those observable with rotations.
std::vector<CoefficientIndex> static_coefficients(bool with_gyros);
std::vector<CoefficientIndex> handheld_coefficients();

/// Returns kernel::chosen_coefficients for a `start.model` with both triads; coefficients of `supplied` that are not chosen are set to their prior.
/// Sets `start.effects` with `start.states`, and `start.named`. Also throws TermsError if offsets and scales of counts are not chosen.
std::vector<CoefficientIndex> choose_coefficients(coarse::RestStart& start, const Session& session, const Recording& recording, bool with_effects,
                                                  const std::vector<CoefficientIndex>& wanted, const std::vector<CoefficientIndex>& supplied,
                                                  std::string_view method);

/// The rests and coefficients. A derived problem with further unknowns or parts shadows the functions that handle these.
class RestProblem {
 public:
  /// Returns the coefficients, then `nuisances` estimated without a prior, then the effects.
  kernel::Parameters parameters(Eigen::Index nuisances = 0) const;
  /// Returns the largest correction of each element: the prior for coefficients that all IMUs have; the equations are linear in the small optional
  /// terms.
  Eigen::VectorXd longest_step(Eigen::Index nuisances = 0) const;
  void correct(const Eigen::VectorXd& correction);
  /// Returns every rest, with the rows of its block.
  std::vector<SuspectRows> suspects(const Conditions& conditions) const;
  /// Returns these terms to their prior value and keeps them there, considered.
  void hold(const std::vector<Eigen::Index>& unseen);
  /// Estimates these terms again because future rests may determine them.
  void release();
  /// Does nothing because rests alone have no rotations.
  void leave_out_rotations() {}
  /// Returns the prior of a coefficient of scaled readings: offsets 20 % of g and 1 rad/s, scales 20 %, misalignments 1e-2 (20 % if the row does not
  /// point along its axis, as for swapped axes), which include uncalibrated units; optional terms from kernel::optional_priors.
  double prior_sigma(const Coefficient& c) const;
  /// Replaces the effects with ones of other sizes.
  void take_sizes(kernel::Effects sized) { effects_ = std::move(sized); }
  /// Returns true for nonlinearity of counts whose zero is far outside the readings. It counts in the uncertainties about the readings' center, but
  /// as a polynomial about zero it would only make offset and scale uncertain.
  bool unstated(std::size_t coefficient) const { return unstated_[coefficient]; }
  /// Returns optional terms that are estimated although the data do not determine them.
  std::vector<Eigen::Index> unseen_terms(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const;
  /// Returns the whole gyro matrix and the gyros' nonlinearity if a gyro scale is not determined and has moved far from its prior because of few or
  /// wrong rotations.
  std::vector<Eigen::Index> runaway_gyro_matrix(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const;

  const std::vector<Rest>& rests() const { return rests_; }
  const kernel::Effects& effects() const { return effects_; }
  const std::vector<CoefficientIndex>& indices() const { return indices_; }
  const SensorModel& model() const { return model_; }  ///< model of scaled readings
  const SensorModel& prior() const { return prior_; }
  const Scaling& scaling() const { return scaling_; }
  double relative_gravity_sigma() const { return relative_gravity_sigma_; }
  /// Returns the sweep of temperature whose thermal terms are among the effects.
  const std::optional<kernel::TemperatureSweep>& sweep() const { return sweep_; }

 protected:
  RestProblem(const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices);
  /// Returns the specific force and the rate of the model at a rest.
  Vector3d force_at(const Rest& rest) const;
  Vector3d rate_at(const Rest& rest) const;
  Matrix3d force_covariance(const Rest& rest, double spread) const;
  Matrix3d rate_covariance(const Rest& rest, double spread) const;
  /// Adds the derivatives of rows with respect to a triad's coefficients, from those with respect to its force or rate at a rest.
  void add_derivatives(Conditions& c, Eigen::Index row, Triad triad, const Rest& rest, const Eigen::MatrixXd& by_output) const;

  /// Returns force and rate of the model, without the effects that depend on them.
  EffectState state_at(const Rest& rest) const;

  std::vector<Rest> rests_;
  double first_s_;  ///< stamp of the first sample
  double gravity_, relative_gravity_sigma_;
  std::optional<double> latitude_;
  Scaling scaling_;
  MeanNoise noise_;  ///< noise of scaled readings
  SensorModel model_, prior_;
  kernel::Effects effects_;
  std::optional<kernel::TemperatureSweep> sweep_;
  std::vector<CoefficientIndex> indices_;
  std::vector<kernel::Role> roles_;  ///< roles of the coefficients
  std::vector<char> unstated_;       ///< considered but not in the result: nonlinearity of counts
};

/// Starts the gyros: with Cheng's linear solution if they resolve the Earth's rate, else as declared with a note. Returns false if not calibrated.
bool start_gyros_at_rest(coarse::RestStart& start, const Recording& recording, const Session& session);

/// The conditions of a rest: |f| = g and, with gyros, the vertical and horizontal parts of the Earth's rate:
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
