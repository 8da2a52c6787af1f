#include "imulab/estimate/hybrid/iteration.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/kernel/optional_terms.hpp"
#include "imulab/estimate/kernel/suspects.hpp"
#include "imulab/estimate/kernel/terms.hpp"

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

/// On from where `before` is, with a latitude to be estimated as the open data declare it.
Iterate with_open_latitude(const Data& open, const Iterate& before) {
  Iterate out = first_iterate(open);
  out.iterations = before.iterations;
  out.heading_known = before.heading_known;
  out.about = {before.about.model, before.states.has(Group::latitude) ? before.about.place : open.place, before.about.start, before.about.delay};
  for (const Group group : before.states.groups())
    out.total.segment(out.states.first(group), out.states.size(group)) = before.total.segment(before.states.first(group), before.states.size(group));
  return out;
}

/// Gyros that hardly resolve the Earth's rate start from any heading, possibly too far off to converge: of eight headings, the one that fits best.
Matrix3d best_heading(const Data& data, const Iterate& iterate) {
  Matrix3d best = *iterate.about.start;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 8; ++k) {
    Iterate turned = iterate;
    turned.about.start = rotation_about(Vector3d::UnitZ(), k * 45 * unit::deg) * *iterate.about.start;
    turned = repeated(data, std::move(turned));
    if (const double chi2 = turned.pass.total_chi2(); chi2 < least) {
      least = chi2;
      best = *turned.about.start;
    }
  }
  return best;
}

/// Where a step follows the direction of the one before, what their ratio says that all further ones would add up to (Aitken): in barely determined
/// directions the iterations converge slowly along one, and oscillate about another.
double extrapolation(const VectorXd& step, const VectorXd& before) {
  if (before.size() == 0) return 1;
  const double product = step.dot(before), ratio = product / before.squaredNorm();
  if (std::abs(product) < 0.7 * step.norm() * before.norm() || ratio > 0.99) return 1;
  return std::clamp(1 / (1 - ratio), 0.25, 6.0);
}

/// The optional terms' priors are narrow: what was corrected of them is taken from the model, where long first steps about a coarse model do not add
/// up.
void set_optional_totals(Iterate& c) {
  const SensorModel& model = c.about.model;
  for (const Index s : c.states.corrections()) {
    const Coefficient& k = coefficient(c.states.corrects(s));
    if (k.term == Term::quadratic) c.total[s] = -model.accel.quadratic[k.row] / std::pow(model.accel.matrix(k.row, k.row), 2);
    if (k.term == Term::g_sensitivity) c.total[s] = -model.g_sensitivity(k.row, k.column);
    if (k.term == Term::lever_arm) c.total[s] = model.lever_arm(k.row, k.column);
  }
}

/// Passes that come no nearer to data far away.
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

/// Passes until the correction is below a hundredth of its sigma.
Iterate converged(const Data& data, Iterate c) {
  constexpr int most_iterations = 30, before_heading = 3, usual = 5;  // with the pass of the review
  const States& states = c.states;
  const Index start_at = states.first(Group::start);
  VectorXd before;  // the last step, in sigmas
  c.converged = false;
  Stuck stuck;
  for (int k = 0; k < most_iterations; ++k) {
    c = repeated(data, std::move(c));
    if (data.progress) data.progress(std::min(1.0, static_cast<double>(k + 1) / usual));
    const Errors errors = determined_errors(c);
    const VectorXd sigma = errors.covariance.diagonal().cwiseSqrt();
    VectorXd step = errors.mean;
    const Vector3d start = step.segment<3>(start_at);
    for (const Group linear :
         {Group::start, Group::gravity, Group::smear, Group::flicker, Group::mean})  // the model has none of them: estimated anew in each pass
      if (states.has(linear)) step.segment(states.first(linear), states.size(linear)).setZero();
    const Index delay = states.first(Group::delay);
    if (delay >= 0) step[delay] -= c.about.delay;
    c.converged = (step.cwiseAbs() - 0.01 * sigma).maxCoeff() <= 0;
    if (c.converged || stuck.after(scatter_of(data, c))) break;
    const VectorXd in_sigmas = step.cwiseQuotient(sigma.cwiseMax(1e-300));
    // The optional terms, which follow the start, act linearly: their steps may be long.
    const double longest = std::max(1.0, step.head(start_at).cwiseAbs().cwiseQuotient(3 * states.prior.head(start_at).cwiseMax(1e-30)).maxCoeff());
    const double whole = extrapolation(in_sigmas, before), factor = whole / longest;
    before = whole == 1 ? in_sigmas : VectorXd();
    c.about.model = corrected(c.about.model, factor * step, states);
    if (states.has(Group::latitude)) {  // between the poles, whatever poor data say
      double& latitude = c.about.place.latitude;
      latitude = std::clamp(latitude - factor * step[states.first(Group::latitude)], -89 * unit::deg, 89 * unit::deg);
    }
    c.total += factor * step;
    if (delay >= 0) c.about.delay += factor * step[delay], c.total[delay] = 0;
    set_optional_totals(c);
    c.about.start = rotation_exp(factor * start) * c.pass.start;
    if (k >= before_heading && !c.heading_known && sigma[start_at + 2] > 3 * unit::deg) c.about.start = best_heading(data, c);
    c.heading_known = c.heading_known || k >= before_heading;
  }
  return c;
}

/// Blocks whose velocity the converged solution cannot explain: the IMU was bumped or shaken. None where so many are that the model is in doubt.
/// A wide prior would let the states wander between the first turns, so the look back is by a narrow one.
std::vector<std::size_t> outlying_blocks(const Data& data, const Iterate& c) {
  constexpr double unlikely = 40;  // chi-square with three degrees of freedom: probability 1e-8
  const States& states = c.states;
  const VectorXd wide = 30 * c.pass.covariance.diagonal().head(states.constants()).cwiseSqrt();
  kernel::Parameters known = states.parameters(VectorXd::Zero(states.constants()));
  known.sigma = states.prior.cwiseMin(wide);
  known.sigma.segment<3>(states.first(Group::start)) = wide.segment<3>(states.first(Group::start));
  for (const Group linear : {Group::gravity, Group::delay, Group::smear})
    if (states.has(linear)) known.offset[states.first(linear)] = c.pass.x[states.first(linear)];
  const Pass look = filter_pass(data, c.about, states, known, {.outlier = unlikely});
  std::vector<kernel::Suspect> suspects;
  for (const double chi2 : look.chi2) suspects.push_back({{}, log_chi_square_tail(chi2, 3)});
  const std::vector<std::size_t> found = kernel::improbable(suspects, chi_square_tail(unlikely, 3));
  // More are no disturbance, but a model that does not fit: the residuals will say so.
  return 20 * found.size() > data.blocks.size() ? std::vector<std::size_t>{} : found;
}

/// The solution of the other hemisphere, whose horizontal rate of the Earth is the same, is too far off for a linearization.
Iterate in_other_hemisphere(const Data& open, Iterate trial) {
  double& latitude = trial.about.place.latitude;
  latitude = -latitude;
  trial.total[trial.states.first(Group::latitude)] = open.place.latitude - latitude;
  return trial;
}

Iterate better(Iterate a, Iterate b) { return b.pass.total_chi2() < a.pass.total_chi2() ? std::move(b) : std::move(a); }

/// `scatter`: with the declared latitude.
std::optional<SeenLatitude> contradicting_latitude(const Data& open, Iterate trial, double declared_sigma, double scatter) {
  if (scatter > other_data && scatter_of(open, trial) > 0.99 * scatter) return {};  // nor does a latitude
  const Index at = trial.states.first(Group::latitude);
  const auto contradicts = [&](double enlarged) {
    const double off = trial.total[at] + trial.pass.x[at], sigma = enlarged * std::sqrt(trial.pass.covariance(at, at));
    return std::abs(off) > 5 * sigma && sigma < 3 * unit::deg && std::abs(off) > 3 * declared_sigma;
  };
  if (!contradicts(1)) return {};  // far from the solution the scatter measures how far
  trial = converged(open, std::move(trial));
  trial = better(trial, converged(open, in_other_hemisphere(open, trial)));
  const double enlarged = std::max(1.0, scatter_of(open, trial));
  if (!trial.converged || !contradicts(enlarged)) return {};
  return SeenLatitude{trial.about.place.latitude - trial.pass.x[at], enlarged * std::sqrt(trial.pass.covariance(at, at))};
}

/// One pass with an open latitude: the latitude that contradicts the declared one, and Wald's test of each optional group with the declared one,
/// where the user did not name them.
struct Review {
  std::optional<SeenLatitude> latitude;
  std::vector<TermTest> tests;
};
Review review(const Data& data, const Iterate& iterate, double significance) {
  Data open = data;
  open.place.latitude_sigma = 30 * unit::deg;
  const Iterate trial = repeated(open, with_open_latitude(open, iterate));
  const States& states = trial.states;
  Review out{contradicting_latitude(open, trial, data.place.latitude_sigma, scatter_of(data, iterate)), {}};
  if (!data.terms.wanted.empty()) return out;
  // Errors of the coarse solution, the latitude's having been measured as zero.
  const Index n = states.constants(), latitude = states.first(Group::latitude);
  VectorXd mean = trial.total + trial.pass.x.head(n);
  MatrixXd covariance = trial.pass.covariance.topLeftCorner(n, n);
  const VectorXd column = covariance.col(latitude), gain = column / (column[latitude] + std::pow(data.place.latitude_sigma, 2));
  mean -= gain * mean[latitude];
  covariance -= gain * column.transpose();
  // Integration from samples is good to less than a thousandth of their interval: in a turn's ramp of four samples it looks like a fifth of that.
  if (const Index at = states.first(Group::delay); at >= 0) covariance(at, at) += std::pow(5e-4 * data.recording.interval_s, 2);
  for (const Group group : data.terms.optional) {
    const Index first = states.first(group), size = states.size(group);
    out.tests.push_back(kernel::wald_without_prior(std::string(name(group)), mean.segment(first, size), covariance.block(first, first, size, size),
                                                   states.prior.segment(first, size), significance));
  }
  return out;
}

/// Widens the priors of optional terms that the data contradict; their names.
std::vector<std::string> widen_priors(Data& data, const Iterate& c) {
  const States& states = c.states;
  const std::vector<Index> at = states.corrections();
  std::vector<CoefficientIndex> indices;
  for (const Index s : at) indices.push_back(states.corrects(s));
  const VectorXd value = c.total + c.pass.x.head(states.constants()), sigma = states.prior.cwiseMax(1e-300);
  const MatrixXd& covariance = c.pass.covariance;
  std::vector<std::string> widened = kernel::widen_priors(data.terms.priors.sizes, indices, value(at), sigma(at), covariance(at, at));
  const Index delay = states.first(Group::delay);
  if (const double by = delay < 0 ? 1 : kernel::widening(value.segment<1>(delay), sigma.segment<1>(delay), covariance.block<1, 1>(delay, delay));
      by > 1) {
    data.terms.priors.delay *= by;
    widened.emplace_back(name(Group::delay));
  }
  return widened;
}

/// The latitude of the other hemisphere, where residuals that are too large become smaller with it. Nearer to the declared one a g-sensitivity common
/// to all axes can take its place.
std::optional<SeenLatitude> mirrored_latitude(const Data& data, const Iterate& c) {
  if (chi_square_tail(c.pass.total_chi2(), 3.0 * static_cast<double>(data.observed())) > 1e-3) return {};
  Data mirrored = data;
  mirrored.place.latitude = -data.place.latitude;
  const Iterate other = converged(mirrored, first_iterate(mirrored));
  constexpr double better_by = 50;  // of chi-square: a likelihood of e^25 to one
  const double scatter = std::max(1.0, scatter_of(mirrored, other));
  if (!other.converged || !(other.pass.total_chi2() < c.pass.total_chi2() - better_by * scatter * scatter)) return {};
  return SeenLatitude{mirrored.place.latitude, 0};
}

/// Neither converged nor anywhere near the data: no other latitude, prior, axis or choice of velocities makes it so.
bool is_hopeless(const Data& data, const Iterate& c) {
  constexpr double far = 5;  // as from there on a result is doubtful
  return !c.converged && scatter_of(data, c) > far;
}

}  // namespace

double scatter_of(const Data& data, const Iterate& c) {
  return std::sqrt(c.pass.total_chi2() / (3.0 * static_cast<double>(std::max<std::ptrdiff_t>(data.observed(), 1))));
}

Converged converge(Data& data, double significance) {
  Converged out{converged(data, first_iterate(data)), {}, {}, {}, {}};
  for (int round = 0; round < 10 && !is_hopeless(data, out.last); ++round) {
    Review seen = review(data, out.last, significance);
    out.latitude = seen.latitude;
    if (out.latitude) break;
    out.tests = std::move(seen.tests);
    if (scatter_of(data, out.last) > other_data) break;
    out.latitude = mirrored_latitude(data, out.last);
    if (out.latitude) break;
    if (const auto widened = widen_priors(data, out.last); !widened.empty()) {  // anew: what a narrow prior bent may be far from the solution
      out.widened.insert(out.widened.end(), widened.begin(), widened.end());
      out.last = converged(data, first_iterate(data));
      continue;
    }
    if (!out.last.converged) break;
    const std::vector<std::size_t> outlying = outlying_blocks(data, out.last);
    if (outlying.empty()) break;
    for (const std::size_t k : outlying) data.blocks[k].observed = false;
    out.left_out.insert(out.left_out.end(), outlying.begin(), outlying.end());
    out.last = converged(data, std::move(out.last));
  }
  return out;
}

}  // namespace imulab::hybrid
