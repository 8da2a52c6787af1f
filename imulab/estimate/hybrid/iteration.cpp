#include "imulab/estimate/hybrid/iteration.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/kernel/optional_terms.hpp"
#include "imulab/estimate/kernel/suspects.hpp"
#include "imulab/estimate/kernel/terms.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
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

/// The heading's error at the start [rad], and its rate [rad/s]: an equal g-sensitivity on all axes turns the heading.
struct HeadingError {
  double start, rate;
};

/// From any heading, and one that turns: of gyros that hardly resolve the Earth's rate in one rest, that error of the heading with which the rates of
/// all rests add up to most. Nothing where that is not five times what their noise adds up to.
std::optional<HeadingError> heading_error(const std::vector<RestRate>& rates, double most_rate) {
  constexpr std::size_t enough = 2000;  // parts of a long recording
  std::vector<std::pair<double, std::complex<double>>> parts;
  const std::size_t in_part = rates.size() / enough + 1;
  double power = 0;
  for (std::size_t k = 0; k < rates.size(); ++k) {
    if (k % in_part == 0) parts.emplace_back(rates[std::min(k + in_part / 2, rates.size() - 1)].time, 0);
    const std::complex<double> rate = rates[k].duration * std::complex<double>(rates[k].rate_n.x(), rates[k].rate_n.y());
    parts.back().second += rate;
    power += std::norm(rate);
  }
  if (parts.empty()) return {};
  const auto sum_at = [&](double rate) {
    std::complex<double> sum = 0;
    for (const auto& [time, part] : parts) sum += std::polar(1.0, -rate * time) * part;
    return sum;
  };
  const double step = 0.5 / std::max(rates.back().time - rates.front().time, 1.0);
  const int steps = std::min(2000, static_cast<int>(most_rate / step));
  std::complex<double> most = 0;
  double best = 0;
  for (int k = -steps; k <= steps; ++k)
    if (const std::complex<double> sum = sum_at(k * step); std::norm(sum) > std::norm(most)) most = sum, best = k * step;
  if (std::norm(most) < 25 * power) return {};
  return HeadingError{std::arg(most) - std::numbers::pi / 2, best};  // north is up in the plane of east and north
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

/// The step's turn of the heading, and of its rate, as the rests show them: far from the solution the error equations do not.
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

/// Passes until the correction is below a hundredth of its sigma.
Iterate converged(const Data& data, Iterate c) {
  constexpr int most_iterations = 30, before_heading = 3, usual = 4;
  constexpr double most_north = 89.99 * unit::deg, longest_of_latitude = 10 * unit::deg;  // as far as its sine and cosine are nearly linear
  const States& states = c.states;
  const Index start_at = states.first(Group::start);
  VectorXd before;  // the last step, in sigmas
  c.converged = false;
  Stuck stuck;
  for (int k = 0; k < most_iterations; ++k) {
    c.pass = filter_pass(data, c.about, states, states.parameters(c.total), {.rates = !c.heading_known});
    ++c.iterations;
    if (data.progress) data.progress(std::min(1.0, static_cast<double>(k + 1) / usual));
    const Errors errors = determined_errors(c);
    const VectorXd sigma = errors.covariance.diagonal().cwiseSqrt();
    VectorXd step = errors.mean;
    Vector3d start = step.segment<3>(start_at);
    for (const Group linear :
         {Group::start, Group::gravity, Group::smear, Group::flicker, Group::mean})  // the model has none of them: estimated anew in each pass
      if (states.has(linear)) step.segment(states.first(linear), states.size(linear)).setZero();
    const Index delay = states.first(Group::delay);
    if (delay >= 0) step[delay] -= c.about.delay;
    c.converged = (step.cwiseAbs() - 0.01 * sigma).maxCoeff() <= 0;
    if (c.converged || stuck.after(scatter_of(data, c))) break;
    if (!c.heading_known && sigma[start_at + 2] > 1 * unit::deg) find_heading(step, start, data, c);
    const VectorXd in_sigmas = step.cwiseQuotient(sigma.cwiseMax(1e-300));
    // The optional terms, which follow the start, act linearly: their steps may be long.
    double longest = std::max(1.0, step.head(start_at).cwiseAbs().cwiseQuotient(3 * states.prior.head(start_at).cwiseMax(1e-30)).maxCoeff());
    if (const Index at = states.first(Group::latitude); at >= 0)
      longest = std::max(longest, std::abs(step[at]) / std::min(3 * states.prior[at], longest_of_latitude));
    const double whole = c.heading_known ? extrapolation(in_sigmas, before) : 1, factor = whole / longest;
    before = whole == 1 ? in_sigmas : VectorXd();
    c.about.model = corrected(c.about.model, factor * step, states);
    c.total += factor * step;
    if (const Index at = states.first(Group::latitude); at >= 0) {  // between the poles, whatever poor data say
      double& latitude = c.about.place.latitude;
      latitude = std::clamp(latitude - factor * step[at], -most_north, most_north);
      c.total[at] = data.place.latitude - latitude;
    }
    if (delay >= 0) c.about.delay += factor * step[delay], c.total[delay] = 0;
    set_optional_totals(c);
    c.about.start = rotation_exp(factor * start) * c.pass.start;
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

/// Wald's test of each optional group on the data alone, where the user did not name them.
std::vector<TermTest> tests_of_terms(const Data& data, const Iterate& iterate, double significance) {
  std::vector<TermTest> tests;
  if (!data.terms.wanted.empty()) return tests;
  const States& states = iterate.states;
  const Index n = states.constants();
  const VectorXd mean = iterate.total + iterate.pass.x.head(n);
  MatrixXd covariance = iterate.pass.covariance.topLeftCorner(n, n);
  // Integration from samples is good to less than a thousandth of their interval: in a turn's ramp of four samples it looks like a fifth of that.
  if (const Index at = states.first(Group::delay); at >= 0) covariance(at, at) += std::pow(5e-4 * data.recording.interval_s, 2);
  for (const Group group : data.terms.optional) {
    const Index first = states.first(group), size = states.size(group);
    tests.push_back(kernel::wald_without_prior(std::string(name(group)), mean.segment(first, size), covariance.block(first, first, size, size),
                                               states.prior.segment(first, size), significance));
  }
  return tests;
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

/// Neither converged nor anywhere near the data: no other prior, axis or choice of velocities makes it so.
bool is_hopeless(const Data& data, const Iterate& c) {
  constexpr double far = 5;  // as from there on a result is doubtful
  return !c.converged && scatter_of(data, c) > far;
}

}  // namespace

double scatter_of(const Data& data, const Iterate& c) {
  return std::sqrt(c.pass.total_chi2() / (3.0 * static_cast<double>(std::max<std::ptrdiff_t>(data.observed(), 1))));
}

Converged converge(Data& data, double significance) {
  Converged out{converged(data, first_iterate(data)), {}, {}, {}};
  for (int round = 0; round < 10 && !is_hopeless(data, out.last); ++round) {
    out.tests = tests_of_terms(data, out.last, significance);
    if (scatter_of(data, out.last) > other_data) break;
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
