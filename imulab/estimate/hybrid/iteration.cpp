// The problem. The filter (filter.cpp) is linear: it estimates the errors of one model with derivatives at that model. The coarse model is wrong by
// percents, but the result must be accurate to a part in a million. The passes are therefore repeated, each about the model that the previous pass
// corrected. Cheng 2014 sec 2.5 corrects once.
//
// A small example. One level accelerometer x has an offset error b, and the attitude is tilted by phi about north. In a rest of T seconds, the
// computed velocity grows by
//
//     V1 = T (g phi + b)            one observation, two unknowns.
//
// The unit turns by 180 deg about the vertical. The tilt belongs to the navigation frame and does not change; the offset turns with the unit:
//
//     V2 = T (g phi - b),           so b = (V1 - V2) / 2T and phi = (V1 + V2) / (2 T g).
//
// Now the unit turns by 180 deg about the horizontal y axis, whose gyro has a relative scale error s. This adds pi s to the attitude error:
//
//     V3 = T (g (phi + pi s) + ...)  with the offset and the scale of the accelerometer as the last turn left them.
//
// For a coarse s of 1 %, the tilt is 0.03 rad. A linear filter uses 0.03 for its sine (an error of 5e-6, or 5 ug) and g for the gravity along the
// tilted vertical axis (an error of phi^2 / 2 = 5e-4, or 500 ug). A pass about the coarse model therefore leaves an error of about 1e-4 in s. The
// next pass begins with a tilt of 3e-4 rad, whose square is 1e-7; the corrections of the third pass are below a hundredth of their sigmas. Three or
// four passes are usual.
//
// The difficulties:
// - Each pass has the same prior about the coarse solution: `total` keeps the corrections since then. If the posterior of a pass were the prior of
//   the next, the data would count twice (83 % instead of 95 % coverage).
// - Some states are not in the model (Linearity in states.hpp): each pass estimates them anew, and no step changes them.
// - If one rest hardly resolves the Earth's rate, the heading at the start is arbitrary, and an equal g-sensitivity of all axes turns it further.
//   The error equations require small angles: find_heading estimates angle and rate from all rests together.
// - Barely determined directions converge slowly along one line, or oscillate about it: extrapolation shortens the series.
// - The sizes of effects and terms are unknown, and a bump is not an error of the model: infer_sizes and outlying_blocks change priors and data, and
//   the passes continue (kernel::refine).
#include "imulab/estimate/hybrid/iteration.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/hybrid/heading_error.hpp"
#include "imulab/estimate/hybrid/turns.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/fit.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/kernel/terms.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Iterate first_iterate(const Data& data) {
  const States states(data.terms, data.place, data.noise);
  return {states, {data.coarse, data.place}, VectorXd::Zero(states.constants())};
}

Errors determined_errors(const Iterate& iterate) {
  const Index n = iterate.states.constants();
  Errors out{iterate.pass.x.head(n), iterate.pass.covariance.topLeftCorner(n, n), {}, {}, {}, {}};
  kernel::Parameters parameters = iterate.states.parameters(iterate.total);
  out.undetermined = kernel::undetermined(out.covariance, parameters, iterate.states.needed());
  for (const Index i : out.undetermined) parameters.role[static_cast<std::size_t>(i)] = kernel::Role::considered;
  for (const Index i : iterate.states.corrections()) {
    const CoefficientIndex index = iterate.states.corrects(i);
    const bool considered = parameters.role[static_cast<std::size_t>(i)] == kernel::Role::considered;
    if (considered && is_optional(coefficient(index).term)) out.considered.push_back(index);
    (considered && !is_optional(coefficient(index).term) ? out.open : out.coefficients).push_back(index);
  }
  kernel::consider(out.mean, out.covariance, parameters);
  return out;
}

Iterate repeated(const Data& data, Iterate iterate, double curve_interval) {
  iterate.pass = filter_pass(data, iterate.about, iterate.states, iterate.states.parameters(iterate.total), {.curve_interval = curve_interval});
  ++iterate.iterations;
  return iterate;
}

namespace {

/// Extrapolates a step that continues the direction of the previous one to the sum of all further steps (Aitken): along barely determined directions,
/// iterations converge slowly or oscillate.
double extrapolation(const VectorXd& step, const VectorXd& before) {
  if (before.size() == 0) return 1;
  const double product = step.dot(before), ratio = product / before.squaredNorm();
  if (std::abs(product) < 0.7 * step.norm() * before.norm() || ratio > 0.99) return 1;
  return std::clamp(1 / (1 - ratio), 0.25, 6.0);
}

/// Recomputes the totals of optional terms from the model because their priors are narrow: long first steps about a coarse model do not add up.
void set_optional_totals(Iterate& c) {
  const SensorModel& model = c.about.model;
  for (const Index s : c.states.corrections()) {
    const Coefficient& k = coefficient(c.states.corrects(s));
    if (k.term == Term::quadratic) c.total[s] = -model.accel.quadratic[k.row] / std::pow(model.accel.matrix(k.row, k.row), 2);
    if (k.term == Term::g_sensitivity) c.total[s] = -model.g_sensitivity(k.row, k.column);
    if (k.term == Term::lever_arm) c.total[s] = model.lever_arm(k.row, k.column);
  }
}

/// Detects stalled iterations: several successive passes that hardly reduce a large scatter.
class Stuck {
 public:
  bool after(double scatter) {
    constexpr double nearer = 0.7;
    constexpr int patience = 6;
    if (scatter < nearer * least_) least_ = scatter, passes_ = 0;
    return ++passes_ > patience && scatter > other_data;
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  int passes_ = 0;
};

/// Replaces the step's change of heading and heading rate by estimates from the rests: the error equations are invalid far from the solution.
void find_heading(VectorXd& step, Vector3d& start, const Data& data, const Iterate& c) {
  constexpr double sigmas = 3;
  const Index first = c.states.first(Group::g_sensitivity);
  const double gravity = data.place.gravity, most = first < 0 ? 0 : sigmas * c.states.prior[first] * gravity;
  const auto error = heading_error(c.pass.rates, most);
  if (!error) return;
  start.z() = -error->start;
  if (first < 0) return;
  const double equal = (step[first] + step[first + 4] + step[first + 8]) / 3;
  for (Index i = 0; i < 9; i += 4) step[first + i] += error->rate / gravity - equal;
}

/// The correction from a pass: of the constants, and of the attitude at the start.
struct Correction {
  VectorXd step, sigma;
  Vector3d start;
};
Correction correction_of(const Iterate& c) {
  const Errors errors = determined_errors(c);
  Correction out{errors.mean, errors.covariance.diagonal().cwiseSqrt(), errors.mean.segment<3>(c.states.first(Group::start))};
  for (const Group group : c.states.groups())  // the model does not contain them: each pass estimates them anew
    if (linearity(group) != Linearity::corrected) out.step.segment(c.states.first(group), c.states.size(group)).setZero();
  if (const Index delay = c.states.first(Group::delay); delay >= 0) out.step[delay] = errors.mean[delay] - c.about.delay;
  return out;
}

/// Returns the divisor of a step that keeps the equations nearly linear. Optional terms follow the start and act linearly: their steps may be long.
double shortening(const VectorXd& step, const States& states) {
  constexpr double longest_of_latitude = 10 * unit::deg;  // its sine and cosine are nearly linear
  const Index n = states.first(Group::start);
  double longest = std::max(1.0, step.head(n).cwiseAbs().cwiseQuotient(3 * states.prior.head(n).cwiseMax(1e-30)).maxCoeff());
  if (const Index at = states.first(Group::latitude); at >= 0) longest = std::max(longest, std::abs(step[at]) / longest_of_latitude);
  return longest;
}

/// Moves the point of linearization.
void correct(Iterate& c, const VectorXd& step, const Vector3d& start, const Data& data) {
  constexpr double most_north = 89.99 * unit::deg;
  c.about.model = corrected(c.about.model, step, c.states);
  c.total += step;
  if (const Index at = c.states.first(Group::latitude); at >= 0) {  // keeps it between the poles for any data
    double& latitude = c.about.place.latitude;
    latitude = std::clamp(latitude - step[at], -most_north, most_north);
    c.total[at] = data.place.latitude - latitude;
  }
  if (const Index delay = c.states.first(Group::delay); delay >= 0) c.about.delay += step[delay], c.total[delay] = 0;
  set_optional_totals(c);
  c.about.start = rotation_exp(start) * c.pass.start;
}

/// Repeats passes until the correction is below a hundredth of its sigma.
Iterate converged(const Data& data, Iterate c, int most_iterations = 30) {
  constexpr int before_heading = 3;
  VectorXd before;  // last step in sigmas
  Stuck stuck;
  c.converged = kernel::iterate(most_iterations, [&](int k) {
    const bool with_effects = data.unmodeled.size() > 0 && (c.heading_known || k > 0);  // they take time, and the first step is long
    c.pass = filter_pass(data, c.about, c.states, c.states.parameters(c.total), {.rates = !c.heading_known, .effects = with_effects});
    ++c.iterations;
    Correction found = correction_of(c);
    const bool whole_model = with_effects || data.unmodeled.size() == 0;
    if (whole_model && kernel::is_small(found.step, found.sigma)) return kernel::Progress::converged;
    if (stuck.after(scatter_of(data, c))) return kernel::Progress::stuck;
    if (!c.heading_known && found.sigma[c.states.first(Group::start) + 2] > 1 * unit::deg) find_heading(found.step, found.start, data, c);
    const VectorXd in_sigmas = found.step.cwiseQuotient(found.sigma.cwiseMax(1e-300));
    const double whole = c.heading_known ? extrapolation(in_sigmas, before) : 1, factor = whole / shortening(found.step, c.states);
    before = whole == 1 ? in_sigmas : VectorXd();
    correct(c, factor * found.step, factor * found.start, data);  // Cheng 2014 sec 2.5
    c.heading_known = c.heading_known || k >= before_heading;
    return kernel::Progress::moving;
  });
  return c;
}

/// Returns blocks whose velocity the converged solution cannot explain because the IMU was bumped or shaken; empty if they are so many that the model
/// is doubtful. The prior of this pass is narrow, because the states would vary between the first turns under a wide one. A large knock can also bias
/// the effects far beyond their priors; if nothing fits with them, the pass omits them.
std::vector<std::size_t> outlying_blocks(const Data& data, const Iterate& c) {
  constexpr double unlikely = 40;  // chi-square with three degrees of freedom: probability 1e-8
  const States& states = c.states;
  const VectorXd wide = 30 * c.pass.covariance.diagonal().head(states.constants()).cwiseSqrt();
  kernel::Parameters known = states.parameters(VectorXd::Zero(states.constants()));
  known.sigma = states.prior.cwiseMin(wide);
  known.sigma.segment<3>(states.first(Group::start)) = wide.segment<3>(states.first(Group::start));
  for (const Group group : states.groups())
    if (linearity(group) == Linearity::whole) known.offset[states.first(group)] = c.pass.x[states.first(group)];
  const auto found_with = [&](const VectorXd& effects) {
    Linearization about = c.about;
    about.effects = effects;
    const Pass look = filter_pass(data, about, states, known, {.outlier = unlikely, .effects = false});
    std::vector<kernel::Suspect> suspects;
    for (const double chi2 : look.chi2) suspects.push_back({{}, log_chi_square_tail(chi2, 3)});
    for (const SeenHeading& h : look.headings) {
      double& of_block = suspects[h.last].log_probability;
      of_block = std::min(of_block, log_chi_square_tail(h.whitened * h.whitened, 1));
    }
    return kernel::improbable(suspects, chi_square_tail(unlikely, 3));
  };
  const auto too_many = [&](const std::vector<std::size_t>& found) { return 20 * found.size() > data.blocks.size(); };
  std::vector<std::size_t> found = found_with(c.pass.effects.value);
  if (too_many(found) && c.pass.effects.value.size() > 0) found = found_with({});
  // A larger number is not a disturbance but a wrong model, which the residuals indicate.
  return too_many(found) ? std::vector<std::size_t>{} : found;
}

/// Tests each optional group by Wald's test on the data alone, unless the user named the terms.
std::vector<TermTest> tests_of_terms(const Data& data, const Iterate& iterate, double significance) {
  std::vector<TermTest> tests;
  if (!data.terms.wanted.empty()) return tests;
  const States& states = iterate.states;
  const Index n = states.constants();
  const VectorXd mean = iterate.total + iterate.pass.x.head(n);
  MatrixXd covariance = iterate.pass.covariance.topLeftCorner(n, n);
  // Integration from samples is accurate to a thousandth of their interval; in a turn's ramp of four samples, the error resembles a fifth of that.
  if (const Index at = states.first(Group::delay); at >= 0) covariance(at, at) += std::pow(5e-4 * data.recording.interval_s, 2);
  for (const Group group : data.terms.optional) {
    const Index first = states.first(group), size = states.size(group);
    tests.push_back(kernel::wald_without_prior(std::string(name(group)), mean.segment(first, size), covariance.block(first, first, size, size),
                                               states.prior.segment(first, size), significance));
  }
  return tests;
}

/// Coefficients and effects of a pass, about its values.
struct Joint {
  std::vector<Index> at;  ///< states of the coefficients
  std::vector<CoefficientIndex> coefficients;
  kernel::Parameters parameters;
  kernel::Solution solution;

  Joint(const kernel::Effects& effects, const Iterate& c) : at(c.states.corrections()) {
    const States& states = c.states;
    for (const Index s : at) coefficients.push_back(states.corrects(s));
    const Index n = std::ssize(at), m = c.pass.effects.value.size();
    parameters = kernel::Parameters(n + m);
    parameters.offset << -(c.total + c.pass.x.head(states.constants()))(at), -c.pass.effects.value;
    parameters.sigma << states.prior(at), effects.sigma();
    solution = {.x = VectorXd::Zero(n + m), .covariance = MatrixXd(n + m, n + m)};
    MatrixXd& covariance = solution.covariance;
    covariance.topLeftCorner(n, n) = c.pass.covariance(at, at);
    if (m == 0) return;
    covariance.topRightCorner(n, m) = c.pass.across(at, Eigen::all);
    covariance.bottomLeftCorner(m, n) = covariance.topRightCorner(n, m).transpose();
    covariance.bottomRightCorner(m, m) = c.pass.effects.covariance;
  }
};

/// Infers sizes of effects and optional terms, like Effects::infer. Without effects, terms keep their expected sizes unless the data contradict it.
bool infer_sizes(Data& data, Iterate& c) {
  kernel::Effects effects = data.unmodeled.effects;
  const Index m = c.pass.effects.value.size();
  if (m != effects.size()) return false;
  const Joint joint(effects, c);
  const bool changed = effects.infer(joint.parameters, joint.solution, joint.coefficients);
  if (m == 0 && effects.contradicting().empty()) return false;
  data.unmodeled.effects = std::move(effects);
  data.terms.priors.sizes = data.unmodeled.effects.terms();
  c.states = States(data.terms, data.place, data.noise);
  return changed;
}

/// Returns true if the fit did not converge and is far from the data: no other prior, axis or choice of velocities can change that.
bool is_hopeless(const Data& data, const Iterate& c) {
  constexpr double far = 5;  // the limit beyond which a result is doubtful
  return !c.converged && scatter_of(data, c) > far;
}

/// Removes the turn with the largest misfit of gravity if the velocities fit much better without it.
bool lose_turn(Data& data, Converged& result) {
  constexpr double fits = 1.5, much = 0.5;                      // as for a late axis
  constexpr double least_rotation = 1e-3, beyond_the_rest = 3;  // [rad]; multiple of the median, to which coarse scales and delays contribute
  constexpr int most_passes = 12;
  const double before = scatter_of(data, result.last);
  const std::vector<Range> motions = motions_of(data.blocks);
  if (before < fits || motions.size() < 3) return false;
  const std::vector<double> misfits = misfits_of_gravity(data.recording, data.coarse, data.blocks, motions);
  const auto worst = std::max_element(misfits.begin(), misfits.end());
  if (*worst < std::max(least_rotation, beyond_the_rest * median(misfits))) return false;
  const Range motion = motions[static_cast<std::size_t>(worst - misfits.begin())];
  Data trial = data;
  trial.blocks = without(std::move(trial.blocks), motion);
  Iterate without_it = converged(trial, first_iterate(trial), most_passes);
  if (!(scatter_of(trial, without_it) < much * before)) return false;
  result.lost.push_back(in_words(data.recording, data.blocks, motion));
  result.left_out = without(std::move(result.left_out), motion);
  data.blocks = std::move(trial.blocks);
  result.last = std::move(without_it);
  return true;
}

}  // namespace

double scatter_of(const Data& data, const Iterate& c) {
  return std::sqrt(c.pass.total_chi2() / (3.0 * static_cast<double>(std::max<std::ptrdiff_t>(data.observed(), 1))));
}

Converged converge(Data& data, double significance) {
  constexpr int most_rounds = 10;
  Converged out{first_iterate(data)};
  const auto infer = [&] {
    if (is_hopeless(data, out.last)) return false;
    out.tests = tests_of_terms(data, out.last, significance);
    return out.last.converged && !(scatter_of(data, out.last) > other_data) && infer_sizes(data, out.last);
  };
  const auto drop = [&] {
    if (!out.last.converged || scatter_of(data, out.last) > other_data) return false;
    const std::vector<std::size_t> outlying = outlying_blocks(data, out.last);
    for (const std::size_t k : outlying) data.blocks[k].observed = false;
    out.left_out.insert(out.left_out.end(), outlying.begin(), outlying.end());
    return !outlying.empty();
  };
  const auto lose = [&] { return lose_turn(data, out); };
  const auto widen = [&] {
    if (!out.last.converged || scatter_of(data, out.last) > other_data) return false;
    const std::vector<SeenHeading>& seen = out.last.pass.headings;
    const double excess = kernel::excess(out.last.pass.chi2_of_headings(), static_cast<double>(seen.size()));
    if (excess > 1) data.noise.angle = noise_of_angle(seen, data.noise.angle), out.headings *= excess;
    return excess > 1;
  };
  kernel::refine(
      most_rounds, [&] { out.last = converged(data, std::move(out.last)); }, lose, infer, drop, widen);
  return out;
}

MatrixXd constant_part(const Data& data, const Iterate& last) {
  const Index n = last.states.constants();
  const kernel::Effects& effects = data.unmodeled.effects;
  if (last.pass.effects.value.size() != effects.size()) return {};
  const Joint joint(effects, last);
  const MatrixXd part = effects.constant_part(joint.parameters, joint.solution.covariance, joint.coefficients);
  if (part.size() == 0) return {};
  MatrixXd out = MatrixXd::Zero(n, n);
  out(joint.at, joint.at) = part;
  return out;
}

}  // namespace imulab::hybrid
