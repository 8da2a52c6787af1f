#include "imulab/estimate/noise/noise_fit.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/noise/spectrum.hpp"

#include <Eigen/Cholesky>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace imulab {
namespace {

constexpr int terms = 4;  // Q, N, B, K; all squared
using Terms = Eigen::Array<double, terms, 1>;
using Eigen::Index;
constexpr double absent = -1e300;                                               // logarithm of a term that is not there
constexpr int most_halvings = 24;                                               // of an interval that holds a bound
constexpr double precision = 0.01;                                              // of a bound, as a part of its distance from the value
constexpr double two_sided = 3.841458820694124, one_sided = 2.705543454095404;  // chi-square of one degree: 95 % and 90 %

/// A spectrum up to some frequency, with the density of each unit term.
struct Problem {
  std::vector<noise::SpectrumBin> bins;
  Eigen::Array<double, Eigen::Dynamic, terms> unit;
  Eigen::ArrayXd counts, power;
};

Problem problem_of(const noise::Spectrum& spectrum, double highest_hz) {
  Problem problem;
  for (const noise::SpectrumBin& bin : spectrum.bins)
    if (bin.high_hz() <= highest_hz) problem.bins.push_back(bin);
  const auto size = static_cast<Index>(problem.bins.size());
  problem.unit.resize(size, terms);
  problem.counts.resize(size);
  problem.power.resize(size);
  for (std::size_t i = 0; i < problem.bins.size(); ++i) {
    const noise::Densities d = noise::unit_densities(problem.bins[i]);
    problem.unit.row(static_cast<Index>(i)) << d.Q, d.N, d.B, d.K;
    problem.counts[static_cast<Index>(i)] = problem.bins[i].count;
    problem.power[static_cast<Index>(i)] = problem.bins[i].power;
  }
  return problem;
}

/// Logarithms of the squared coefficients, and the ramp beyond the line that was removed.
struct Point {
  Terms log = Terms::Constant(absent);
  double ramp = 0;
  double misfit = std::numeric_limits<double>::infinity();  // -2 ln likelihood
};

/// What is kept fixed while the rest is fitted.
struct Fixed {
  int term = -1;
  std::optional<double> ramp;
};

Eigen::ArrayXd model_of(const Problem& problem, const Terms& log) { return (problem.unit.matrix() * log.exp().matrix()).array(); }

/// Of each ordinate, the ramp's squared amplitude over the noise's power: their sum is the information on the ramp.
Eigen::ArrayXd ramp_information(const Problem& problem, const Eigen::ArrayXd& model) {
  Eigen::ArrayXd information(model.size());
  for (std::size_t i = 0; i < problem.bins.size(); ++i)
    information[static_cast<Index>(i)] = problem.bins[i].ramp * problem.bins[i].ramp / model[static_cast<Index>(i)];
  return information;
}

double best_ramp(const Problem& problem, const Eigen::ArrayXd& model) {
  double sum = 0;
  for (std::size_t i = 0; i < problem.bins.size(); ++i) sum += problem.bins[i].ramp * problem.bins[i].amplitude / model[static_cast<Index>(i)];
  return sum / ramp_information(problem, model).sum();
}

/// Without the ramp, where an ordinate has its amplitude.
Eigen::ArrayXd power_of(const Problem& problem, double ramp) {
  Eigen::ArrayXd power = problem.power;
  for (std::size_t i = 0; i < problem.bins.size() && problem.bins[i].ramp != 0; ++i)
    power[static_cast<Index>(i)] = std::pow(problem.bins[i].amplitude - ramp * problem.bins[i].ramp, 2);
  return power;
}

/// Sets ramp and misfit of a point from its terms. A fitted ramp takes power from the lowest ordinates, which the restricted likelihood allows for.
void judge(Point& point, const Problem& problem, const Fixed& fixed) {
  const Eigen::ArrayXd model = model_of(problem, point.log);
  point.ramp = fixed.ramp ? *fixed.ramp : best_ramp(problem, model);
  point.misfit = (problem.counts * (model.log() + power_of(problem, point.ramp) / model)).sum();
  if (!fixed.ramp) point.misfit += std::log(ramp_information(problem, model).sum());
}

/// Fisher scoring in the logarithms, damped (Levenberg and Marquardt).
Point fitted(Point point, const Problem& problem, const Fixed& fixed) {
  judge(point, problem, fixed);
  double damping = 1e-3;
  for (int iteration = 0; iteration < 200; ++iteration) {
    const Eigen::ArrayXd model = model_of(problem, point.log);
    Eigen::Matrix<double, Eigen::Dynamic, terms> share = problem.unit.matrix() * point.log.exp().matrix().asDiagonal();
    share.array().colwise() /= model;
    if (fixed.term >= 0) share.col(fixed.term).setZero();
    const Eigen::ArrayXd rest = problem.counts * (1 - power_of(problem, point.ramp) / model);
    Eigen::Matrix<double, terms, 1> gradient = share.transpose() * rest.matrix();
    if (!fixed.ramp) {
      const Eigen::ArrayXd ramp = ramp_information(problem, model);
      gradient -= share.transpose() * (ramp / ramp.sum()).matrix();
    }
    const Eigen::Matrix<double, terms, terms> information = share.transpose() * problem.counts.matrix().asDiagonal() * share;
    Point next;
    bool better = false;
    for (; !better && damping < 1e12; damping *= 10) {
      Eigen::Matrix<double, terms, terms> damped = information;
      damped.diagonal() += damping * (information.diagonal().array() + 1e-9).matrix();
      next = point;
      next.log -= damped.ldlt().solve(gradient).array().max(-3.0).min(3.0);
      next.log = next.log.max(absent).min(700.0);
      judge(next, problem, fixed);
      better = std::isfinite(next.misfit) && next.misfit <= point.misfit;
    }
    if (!better) return point;
    const double gain = point.misfit - next.misfit;
    point = next;
    damping = std::max(1e-9, damping * 1e-2);
    if (gain < 1e-5) return point;  // of the 3.84 that a bound rises
  }
  return point;
}

/// Each term as large as the spectrum admits anywhere, over several of them.
Point start_of(const Problem& problem) {
  Point start;
  const Eigen::ArrayXd power = power_of(problem, best_ramp(problem, Eigen::ArrayXd::Ones(static_cast<Index>(problem.bins.size()))));
  for (Index j = 0; j < terms; ++j) {
    std::vector<double> ratios;
    for (Index i = 0; i < power.size(); ++i)
      if (problem.bins[static_cast<std::size_t>(i)].count >= 3) ratios.push_back(power[i] / problem.unit(i, j));
    if (ratios.empty()) ratios.push_back(power.mean() / problem.unit.col(j).mean());
    start.log[j] = std::log(std::max(quantile(ratios, 0.05), 1e-290));
  }
  return start;
}

/// From a term's logarithm outward by `direction` until the misfit has risen by `rise`; NaN where it does not within e^60.
double crossing(const Problem& problem, const Point& best, int term, double direction, double rise) {
  Point at = best;  // each fit starts where the one before ended
  const auto risen = [&](double log) {
    at.log[term] = log;
    at = fitted(at, problem, {term, {}});
    return at.misfit - best.misfit - rise;
  };
  double inside = best.log[term], step = 0.1, outside = inside + direction * step;
  while (risen(outside) < 0) {
    inside = outside;
    outside = inside + direction * (step *= 2);
    if (step > 60) return std::numeric_limits<double>::quiet_NaN();
  }
  for (int i = 0; i < most_halvings && std::abs(outside - inside) > precision * std::abs(outside - best.log[term]); ++i) {
    const double middle = 0.5 * (inside + outside);
    (risen(middle) < 0 ? inside : outside) = middle;
  }
  return 0.5 * (inside + outside);
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// `widening`: how much larger than chance alone a rise of the misfit has to be.
NoiseCoefficient coefficient(const Problem& problem, const Point& best, int term, double widening) {
  Point without = best;
  without.log[term] = absent;
  NoiseCoefficient c;
  c.determined = fitted(without, problem, {term, {}}).misfit - best.misfit > two_sided * widening;
  Point from = best;
  if (!c.determined) {  // from where the term is a thousandth of the spectrum, if it is less
    const Eigen::ArrayXd share = problem.unit.col(term) / model_of(problem, best.log);
    from.log[term] = std::max(from.log[term], std::log(1e-3 / share.maxCoeff()));
  }
  const double upper = crossing(problem, {from.log, from.ramp, best.misfit}, term, 1, (c.determined ? two_sided : one_sided) * widening);
  c.upper = std::exp(0.5 * upper);
  if (!c.determined) return {nan, nan, 0, c.upper, false};
  c.value = std::exp(0.5 * best.log[term]);
  const double lower = crossing(problem, best, term, -1, two_sided * widening);
  c.lower = std::isnan(lower) ? 0 : std::exp(0.5 * lower);
  c.standard_uncertainty = (c.upper - c.lower) / (2 * std::sqrt(two_sided));
  return c;
}

/// On how many degrees of freedom the power rests that a ramp has to stand out of: by the fit's variance of its logarithm, 2 / degrees.
double degrees_below_ramp(const Problem& problem, const Point& best) {
  const Eigen::ArrayXd model = model_of(problem, best.log), ramp = ramp_information(problem, model);
  Eigen::Matrix<double, Eigen::Dynamic, terms> share = problem.unit.matrix() * best.log.exp().matrix().asDiagonal();
  share.array().colwise() /= model;
  Eigen::Matrix<double, terms, terms> information = 0.5 * (share.transpose() * problem.counts.matrix().asDiagonal() * share);
  information.diagonal().array() += 1e-6;  // of a term that is absent: nothing
  const Eigen::Matrix<double, terms, 1> direction = share.transpose() * (ramp / ramp.sum()).matrix();
  return std::max(1.0, 2 / direction.dot(information.ldlt().solve(direction)));
}

/// The ramp has a sign; `slope` was removed before. Bounds as Student's distribution has them for a power known by few degrees of freedom.
NoiseCoefficient ramp_coefficient(const Problem& problem, const Point& best, double slope, double widening) {
  const double degrees = degrees_below_ramp(problem, best), quantile = student_quantile(0.975, degrees);
  const double rise = (degrees + 1) * std::log1p(quantile * quantile / degrees) * widening;
  const Point base = fitted(best, problem, {-1, best.ramp});
  const auto risen = [&](double ramp) { return fitted(base, problem, {-1, ramp}).misfit - base.misfit - rise; };
  const double sigma = 1 / std::sqrt(ramp_information(problem, model_of(problem, best.log)).sum());
  const auto edge = [&](double direction) {
    double inside = best.ramp, step = sigma, outside = inside + direction * step;
    while (risen(outside) < 0 && step < 1e6 * sigma) inside = outside, outside += direction * (step *= 2);
    for (int i = 0; i < most_halvings && std::abs(outside - inside) > precision * std::abs(outside - best.ramp); ++i) {
      const double middle = 0.5 * (inside + outside);
      (risen(middle) < 0 ? inside : outside) = middle;
    }
    return slope + outside;
  };
  NoiseCoefficient c;
  c.lower = edge(-1), c.upper = edge(1);
  c.determined = c.lower > 0 || c.upper < 0;
  if (!c.determined) return {nan, nan, 0, std::max(-c.lower, c.upper), false};
  c.value = slope + best.ramp;
  c.standard_uncertainty = (c.upper - c.lower) / (2 * quantile);
  return c;
}

struct Agreement {
  double chi2_per_dof = 0;
  std::vector<NoiseMisfit> misfits;
};

/// Measured over modeled power in ranges of at least 20 degrees of freedom and a third of an octave.
Agreement agreement(const Problem& problem, const Point& best) {
  const Eigen::ArrayXd ratio = power_of(problem, best.ramp) / model_of(problem, best.log);
  struct Group {
    double low, high, count, sum;
  };
  std::vector<Group> groups;
  for (std::size_t i = 0; i < problem.bins.size(); ++i) {
    const noise::SpectrumBin& bin = problem.bins[i];
    if (groups.empty() || (groups.back().count >= 20 && groups.back().high > 1.25 * groups.back().low)) groups.push_back({bin.low_hz(), 0, 0, 0});
    groups.back().high = bin.high_hz();
    groups.back().count += bin.count;
    groups.back().sum += bin.count * ratio[static_cast<Index>(i)];
  }
  Agreement out;
  const double chance = 0.001 / static_cast<double>(groups.size());
  for (const Group& g : groups) {
    const double tail = chi_square_tail(g.sum, g.count);
    if (std::min(tail, 1 - tail) < 0.5 * chance) out.misfits.push_back({g.low, g.high, g.sum / g.count});
    out.chi2_per_dof += std::pow(g.sum / g.count - 1, 2) * g.count / 2;
  }
  out.chi2_per_dof /= std::max(1.0, static_cast<double>(groups.size()) - 5);
  return out;
}

void check(std::span<const double> rate, double interval_s) {
  if (rate.size() < 64) throw Error(fmt::format("{} readings: too few; expected at least 64", rate.size()));
  if (!(interval_s > 0) || std::isinf(interval_s)) throw Error(fmt::format("interval {:g} s: expected a positive time", interval_s));
  for (std::size_t i = 0; i < rate.size(); ++i)
    if (!std::isfinite(rate[i])) throw Error(fmt::format("reading {}: is not finite; expected numbers", i + 1));
  if (std::all_of(rate.begin(), rate.end(), [&](double r) { return r == rate[0]; }))
    throw Unsupported("all readings are equal: no noise can be seen");
}

}  // namespace

NoiseFit fit_noise(std::span<const double> rate, double interval_s) {
  check(rate, interval_s);
  const noise::Spectrum spectrum = noise::spectrum_of(rate, interval_s);
  const double half_rate = 0.5 / interval_s;
  struct Try {
    double highest;
    Problem problem;
    Point best;
    Agreement agreement;
  };
  std::optional<Try> chosen;
  // A sensor's low-pass and the rounding of counts bend the upper end: it is left out as far as the model then holds, at most to a 32nd.
  for (double highest = 2 * half_rate; highest > half_rate / 32; highest = std::min(highest, half_rate) * 0.8) {
    Problem problem = problem_of(spectrum, highest);
    if (problem.bins.size() < 12) break;
    const Point best = fitted(start_of(problem), problem, {});
    Agreement found = agreement(problem, best);
    const bool holds = found.misfits.empty();
    if (!chosen || holds || found.chi2_per_dof < chosen->agreement.chi2_per_dof) chosen = Try{highest, std::move(problem), best, std::move(found)};
    if (holds) break;
  }
  NoiseFit fit;
  fit.chi2_per_dof = chosen->agreement.chi2_per_dof;
  fit.misfits = chosen->agreement.misfits;
  fit.accepted = fit.misfits.empty();
  fit.cut = chosen->highest < half_rate;
  fit.highest_hz = std::min(chosen->highest, half_rate);
  const double widening = fit.accepted ? 1 : std::max(1.0, fit.chi2_per_dof);
  NoiseCoefficient* const coefficients[] = {&fit.Q, &fit.N, &fit.B, &fit.K};
  for (int j = 0; j < terms; ++j) *coefficients[j] = coefficient(chosen->problem, chosen->best, j, widening);
  fit.R = ramp_coefficient(chosen->problem, chosen->best, spectrum.slope, widening);
  return fit;
}

}  // namespace imulab
