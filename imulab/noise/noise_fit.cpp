#include "imulab/noise/noise_fit.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/noise.hpp"
#include "imulab/noise/bound.hpp"
#include "imulab/noise/noise_interval.hpp"
#include "imulab/noise/noise_terms.hpp"
#include "imulab/noise/upper_density.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace imulab {
namespace {

using noise::Terms;

void check(std::span<const double> rate, double interval_s) {
  if (rate.size() < 64) throw Error(fmt::format("{} readings: too few; expected at least 64", rate.size()));
  if (!(interval_s > 0) || std::isinf(interval_s)) throw Error(fmt::format("interval {:g} s: expected a positive time", interval_s));
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (!std::isfinite(rate[i])) throw Error(fmt::format("reading {}: is not finite; expected numbers", i + 1));
  if (std::all_of(rate.begin(), rate.end(), [&](double r) { return r == rate[0]; }))
    throw Unsupported("all readings are equal: no noise can be seen");
}

/// Returns the coefficient as undetermined if a first process with two parameters in place of the term explains the spectrum better (Akaike's
/// criterion), with the larger bound of the two models.
NoiseCoefficient unless_a_process(const NoiseCoefficient& c, const noise::ChosenModel& model, int parameter, double widening) {
  if (!model.wider || model.problem.terms().markov > 0) return c;
  const noise::SpectrumLikelihood& problem = model.wider->problem;
  noise::Point without = problem.revived(model.wider->best);
  without.at[parameter] = noise::absent;
  constexpr double price = 2;  // cost of an additional parameter
  if (c.determined && problem.fitted(without, {parameter, {}}).misfit + price * widening > model.best.misfit) return c;
  const NoiseCoefficient other = noise::size_of(problem, model.wider->best, parameter, widening);
  return undetermined_below(std::max(c.upper, other.upper));
}

void check(const BoundOptions& bound, double interval_s, double record_s) {
  if (!(bound.confidence > 0.5 && bound.confidence < 1)) throw Error(fmt::format("confidence {:g}: expected 0.5 to 1", bound.confidence));
  constexpr double fewest_intervals = 10;  // a tenth of 1 / horizon is then far below half the rate
  if (!(bound.horizon_s >= fewest_intervals * interval_s))
    throw Error(fmt::format("horizon {:g} s: expected {:g} s or more, {:g} sampling intervals", bound.horizon_s, fewest_intervals * interval_s,
                            fewest_intervals));
  if (3 * bound.horizon_s > record_s)
    throw Unsupported(fmt::format("a bound for {:g} s needs {:g} s at rest, and there are {:.4g} s; expected a longer log, or a horizon of {:.4g} s",
                                  bound.horizon_s, 3 * bound.horizon_s, record_s, std::floor(record_s / 3)));
}

void set_bound(NoiseFit& fit, const noise::ChosenModel& model, const noise::Spectrum& spectrum, double interval_s, const BoundOptions& options,
               double widening) {
  std::vector<UpperDensity> upper = noise::upper_densities(model, spectrum, 0.5 / interval_s, options.confidence, widening);
  upper = noise::at_frequencies(upper, noise::bound_frequencies(interval_s, options.horizon_s));
  // A line through the readings was removed before the fit. A walk of its size over the record stands for it.
  if (fit.R.determined)
    for (UpperDensity& u : upper) u.density += spectrum.record_s * std::pow(std::max(-fit.R.lower, fit.R.upper) / (2 * std::numbers::pi * u.hz), 2);
  fit.bound = noise::tightest_bound(std::move(upper), interval_s, options);
  noise::set_coasts(*fit.bound, fit);
}

}  // namespace

double resolution_of(std::span<const double> rate) {
  constexpr std::size_t most = 65536;
  constexpr double near = 0.05, enough = 0.95;  // fraction of a step; fraction of the gaps between values
  std::vector<double> values(rate.begin(), rate.begin() + static_cast<std::ptrdiff_t>(std::min(rate.size(), most)));
  std::sort(values.begin(), values.end());
  const double rounding = 1e-12 * std::max(std::abs(values.front()), std::abs(values.back()));
  std::vector<double> gaps;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (values[i] - values[i - 1] > rounding) gaps.push_back(values[i] - values[i - 1]);
  if (gaps.size() < 2) return gaps.empty() ? 0 : gaps[0];
  const double step = quantile(gaps, 0.5);
  const auto whole = std::count_if(gaps.begin(), gaps.end(), [&](double gap) { return std::abs(gap / step - std::round(gap / step)) < near; });
  return static_cast<double>(whole) >= enough * static_cast<double>(gaps.size()) ? step : 0;
}

NoiseFit fit_noise(std::span<const double> rate, double interval_s, const NoiseFitOptions& options) {
  check(rate, interval_s);
  if (options.bound) check(*options.bound, interval_s, static_cast<double>(rate.size()) * interval_s);
  NoiseFit fit;
  fit.resolution = options.step ? *options.step : resolution_of(rate);
  const double half_rate = 0.5 / interval_s;
  noise::WithoutLines found = noise::without_lines(rate, interval_s);
  const noise::ChosenModel model = noise::choose_terms(found.spectrum, half_rate, fit.resolution, options.model);
  const noise::SpectrumLikelihood& problem = model.problem;
  const noise::Point& best = model.best;
  fit.lines = std::move(found.lines);
  fit.chi2_per_dof = model.agreement.chi2_per_dof;
  fit.misfits = model.agreement.misfits;
  fit.cut = model.highest_hz < half_rate;
  fit.highest_hz = std::min(model.highest_hz, half_rate);
  const double widening = fit.accepted() ? 1 : std::max(1.0, fit.chi2_per_dof);
  NoiseCoefficient* const sizes[] = {&fit.Q, &fit.N, &fit.B, &fit.K};
  for (int j = 0; j < 4; ++j) {
    *sizes[j] = noise::size_of(problem, best, j, widening);
    if (j == Terms::B) *sizes[j] = unless_a_process(*sizes[j], model, j, widening);
  }
  if (!fit.B.determined && !fit.K.determined)
    fit.joint = noise::joint_of(problem, best, fit.B.upper, fit.K.upper, static_cast<double>(rate.size()) * interval_s / 3, widening);
  for (int m = 0; m < problem.terms().markov; ++m)
    fit.markov.push_back({noise::size_of(problem, best, Terms::sigma(m), widening), noise::scale_of(problem, best, Terms::time(m), widening)});
  std::sort(fit.markov.begin(), fit.markov.end(), [](const MarkovTerm& a, const MarkovTerm& b) { return a.time.value > b.time.value; });
  if (const noise::LowPassShape& shape = problem.terms().low_pass; shape.order > 0)
    fit.low_pass = LowPass{shape.order, shape.digital, noise::scale_of(problem, best, problem.terms().cutoff(), widening)};
  const Eigen::ArrayXd density = problem.density(best.at), power = problem.power(best.ramp);
  for (Eigen::Index i = 0; i < density.size(); ++i)
    fit.spectrum.push_back({problem.bins()[static_cast<std::size_t>(i)].middle_hz(), power[i], density[i], problem.counts()[i]});
  fit.R = noise::ramp_of(problem, best, found.spectrum.slope, widening);
  if (options.bound) set_bound(fit, model, found.spectrum, interval_s, *options.bound, widening);
  return fit;
}

}  // namespace imulab
