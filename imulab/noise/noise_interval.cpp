#include "imulab/noise/noise_interval.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::noise {

namespace {

constexpr int most_halvings = 24;   // limit for an interval that contains a bound
constexpr double precision = 0.01;  // error of a bound relative to its distance from the value
/// 95 % of chi-square with one degree of freedom, also used for the bound of an undetermined coefficient. With less (2.71, 95 % one-sided), the same
/// logs that decide which of the two is stated would make intervals too short as well as too long, and coverage would be 92.5 %.
constexpr double rise_of_95 = 3.841458820694124;
constexpr double profile_precision = 1e-3;  // error of the 3.84 by which the misfit rises
constexpr double farthest = 0.5;            // largest predicted change of another logarithm: insensitive ones would run away
constexpr double widest_log = 60;           // width of an interval in the logarithm of a square
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Returns a parameter as the logarithm of a square, also for Q.
double log_square(const SpectrumLikelihood& problem, const Point& point, int parameter) {
  if (parameter != Terms::Q) return point.at[parameter];
  return point.at[parameter] > 0 ? std::log(point.at[parameter] * problem.Q_scale()) : absent;
}

void set_log_square(const SpectrumLikelihood& problem, Point& point, int parameter, double log) {
  point.at[parameter] = parameter == Terms::Q ? std::exp(log) / problem.Q_scale() : log;
}

/// Derivatives of the other parameters by one near the maximum, and its standard deviation, from the information matrix.
struct Following {
  Parameters slope;
  double sigma = 0;
};

Following following(const SpectrumLikelihood& problem, const Point& best, int parameter) {
  const Eigen::MatrixXd D = problem.sensitivity(best.at, problem.modeled(best.at));
  Eigen::MatrixXd information = 0.5 * (D.transpose() * problem.counts().matrix().asDiagonal() * D);
  information.diagonal().array() += 1e-9;  // an absent term has no information
  const Eigen::VectorXd column = solve_semidefinite(information, Eigen::VectorXd(Eigen::VectorXd::Unit(information.rows(), parameter)));
  return {(column / column[parameter]).array(), std::sqrt(column[parameter])};
}

/// Searches from a parameter outward in `direction` until the misfit has risen by `rise`; returns NaN if it does not within e^60.
double crossing(const SpectrumLikelihood& problem, const Point& best, int parameter, double from, double direction, double rise) {
  const Following others = following(problem, best, parameter);
  Point last = best;
  const auto risen = [&](double log) {
    // Start from the predicted values of the others or, if the model does not permit these, from the end of the previous fit.
    Point start = last;
    set_log_square(problem, start, parameter, log);
    const Parameters step = others.slope * (start.at[parameter] - last.at[parameter]);
    start.at += step.max(-farthest).min(farthest);
    start = problem.revived(start);
    set_log_square(problem, start, parameter, log);
    Point found = problem.fitted(start, {parameter, {}}, profile_precision);
    if (!std::isfinite(found.misfit)) {
      start.at = last.at;
      set_log_square(problem, start, parameter, log);
      found = problem.fitted(start, {parameter, {}}, profile_precision);
    }
    if (!std::isfinite(found.misfit)) return 1.0;  // beyond the permitted range of the model
    last = found;
    return last.misfit - best.misfit - rise;
  };
  // The parameter of Q is the square itself, which converts to relative changes of its logarithm.
  const double sigma = parameter == Terms::Q ? others.sigma / std::max(best.at[parameter], others.sigma) : others.sigma;
  double inside = from, step = std::clamp(sigma, 1e-6, 1.0), outside = inside + direction * step;
  while (risen(outside) < 0) {
    inside = outside;
    outside = inside + direction * (step *= 2);
    if (step > widest_log) return nan;
  }
  for (int i = 0; i < most_halvings && std::abs(outside - inside) > precision * std::abs(outside - from); ++i) {
    const double middle = 0.5 * (inside + outside);
    (risen(middle) < 0 ? inside : outside) = middle;
  }
  return 0.5 * (inside + outside);
}

/// Returns the degrees of freedom of the power below a ramp, from the fit's variance of its logarithm, 2 / degrees.
double degrees_below_ramp(const SpectrumLikelihood& problem, const Point& best) {
  const Modeled modeled = problem.modeled(best.at);
  const Eigen::ArrayXd ramp = problem.ramp_information(modeled.density);
  const Eigen::MatrixXd D = problem.sensitivity(best.at, modeled);
  Eigen::MatrixXd information = 0.5 * (D.transpose() * problem.counts().matrix().asDiagonal() * D);
  information.diagonal().array() += 1e-6;  // an absent term has no information
  const Eigen::VectorXd direction = D.transpose() * (ramp / ramp.sum()).matrix();
  return std::max(1.0, 2 / squared_norm_in(information, direction));
}

/// B^2 and K^2 of a model.
struct SlowSquares {
  double B = 0, K = 0;
  double allan_variance(double tau_s) const { return flicker_floor_squared * B + K * tau_s / 3; }
};

/// Returns the edge of the permitted B^2 for a fixed K^2, between one inside and one outside.
double edge_of_B(const SpectrumLikelihood& problem, const Point& fitted, double inside, double outside, double limit) {
  constexpr int halvings = 9;
  double in = std::log(inside), out = std::log(outside);
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (in + out);
    Point point = fitted;
    point.at[Terms::B] = middle;
    (problem.fitted(point, {Terms::K, {}, Terms::B}, profile_precision).misfit < limit ? in : out) = middle;
  }
  return std::exp(in);
}

/// Returns points on the edge of the region of B and K whose misfit is below a limit. `largest`: above all of them.
std::vector<SlowSquares> slow_region(const SpectrumLikelihood& problem, const Point& best, const SlowSquares& largest, double limit) {
  constexpr int steps = 8;
  constexpr double negligible = 1e-4;  // of the largest
  std::vector<SlowSquares> out;
  for (int i = 0; i <= steps; ++i) {
    const double K = largest.K * std::pow(static_cast<double>(i) / steps, 2), least_B = negligible * largest.B;
    Point start = problem.revived(best);
    start.at[Terms::K] = K > 0 ? std::log(K) : absent;
    const Point at = problem.fitted(start, {Terms::K, {}}, profile_precision);
    if (!(at.misfit < limit)) continue;
    Point without = at;
    without.at[Terms::B] = absent;
    const double B = std::max(std::exp(at.at[Terms::B]), least_B);
    const bool may_be_0 = B == least_B || problem.fitted(without, {Terms::K, {}, Terms::B}, profile_precision).misfit < limit;
    out.push_back({edge_of_B(problem, at, B, largest.B, limit), K});
    out.push_back({may_be_0 ? 0 : edge_of_B(problem, at, B, least_B, limit), K});
  }
  return out;
}

}  // namespace

NoiseCoefficient size_of(const SpectrumLikelihood& problem, const Point& best, int parameter, double widening) {
  if (const auto& has = problem.terms().has; static_cast<std::size_t>(parameter) < has.size() && !has[static_cast<std::size_t>(parameter)])
    return undetermined_below(0);
  Point without = problem.revived(best);
  without.at[parameter] = parameter == Terms::Q ? 0 : absent;
  NoiseCoefficient c;
  double from = log_square(problem, best, parameter);
  c.determined = from != absent && problem.fitted(without, {parameter, {}}).misfit - best.misfit > rise_of_95 * widening;
  if (!c.determined) {  // starts at a thousandth of the spectrum if the term is smaller
    Point unit = best;
    set_log_square(problem, unit, parameter, 0);
    const Eigen::ArrayXd density = problem.density(best.at);
    const double share = ((problem.density(unit.at) - problem.density(without.at)) / density).maxCoeff();
    from = std::max(from, std::log(1e-3 / share));
  }
  const double upper = crossing(problem, best, parameter, from, 1, rise_of_95 * widening);
  c.upper = std::exp(0.5 * upper);
  if (!c.determined) return undetermined_below(c.upper);
  c.value = std::exp(0.5 * from);
  const double lower = crossing(problem, best, parameter, from, -1, rise_of_95 * widening);
  c.lower = std::isnan(lower) ? 0 : std::exp(0.5 * lower);
  c.standard_uncertainty = (c.upper - c.lower) / (2 * std::sqrt(rise_of_95));
  return c;
}

NoiseCoefficient scale_of(const SpectrumLikelihood& problem, const Point& best, int parameter, double widening) {
  const double from = best.at[parameter];
  const double lower = crossing(problem, best, parameter, from, -1, rise_of_95 * widening),
               upper = crossing(problem, best, parameter, from, 1, rise_of_95 * widening);
  NoiseCoefficient c{std::exp(from), 0, std::isnan(lower) ? 0 : std::exp(lower), std::exp(upper), true};
  if (std::isnan(upper)) c.upper = std::numeric_limits<double>::infinity();
  c.standard_uncertainty = (c.upper - c.lower) / (2 * std::sqrt(rise_of_95));
  return c;
}

NoiseCoefficient ramp_of(const SpectrumLikelihood& problem, const Point& best, double slope, double widening) {
  const double degrees = degrees_below_ramp(problem, best), quantile = student_quantile(0.975, degrees);
  const double rise = (degrees + 1) * std::log1p(quantile * quantile / degrees) * widening;
  const Point base = problem.fitted(problem.revived(best), {-1, best.ramp});
  const auto risen = [&](double ramp) { return problem.fitted(base, {-1, ramp}).misfit - base.misfit - rise; };
  const double sigma = 1 / std::sqrt(problem.ramp_information(problem.density(best.at)).sum());
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
  if (!c.determined) return undetermined_below(std::max(-c.lower, c.upper));
  c.value = slope + best.ramp;
  c.standard_uncertainty = (c.upper - c.lower) / (2 * quantile);
  return c;
}

std::optional<JointNoise> joint_of(const SpectrumLikelihood& problem, const Point& best, double largest_B, double largest_K, double longest_s,
                                   double widening) {
  const SlowSquares largest{largest_B * largest_B, largest_K * largest_K};
  if (!(largest.B > 0 && largest.K > 0 && std::isfinite(largest.B + largest.K))) return {};
  const std::vector<SlowSquares> region = slow_region(problem, best, largest, best.misfit + rise_of_95 * widening);
  const SlowSquares fitted{std::exp(best.at[Terms::B]), std::exp(best.at[Terms::K])};
  std::optional<JointNoise> out;
  for (double tau = longest_s; tau > longest_s / 1000; tau /= 2) {
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (const SlowSquares& at : region) least = std::min(least, at.allan_variance(tau)), most = std::max(most, at.allan_variance(tau));
    NoiseCoefficient c{std::sqrt(fitted.allan_variance(tau)), 0, std::sqrt(least), std::sqrt(most), true};
    c.standard_uncertainty = (c.upper - c.lower) / (2 * std::sqrt(rise_of_95));
    if (least > 0 && c.lower < c.value && (!out || c.upper / c.lower < out->deviation.upper / out->deviation.lower)) out = {tau, c};
  }
  return out;
}

}  // namespace imulab::noise
