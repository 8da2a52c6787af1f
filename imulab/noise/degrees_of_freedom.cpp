#include "imulab/noise/degrees_of_freedom.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace imulab::noise {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double longest_sum = 100;  // largest number of terms of an exact sum: SP 1065's Jmax

/// Returns the generalized autocovariance of the phase.
double sw(double t, int alpha) {
  t = std::abs(t);
  if (t == 0) return 0;
  switch (alpha) {
    case 2:
      return -t;
    case 1:
      return t * t * std::log(t);
    case 0:
      return t * t * t;
    case -1:
      return -std::pow(t, 4) * std::log(t);
    case -2:
      return -std::pow(t, 5);
    case -3:
      return std::pow(t, 6) * std::log(t);
    default:
      return std::pow(t, 7);
  }
}

/// Returns the autocovariance of the phase averaged with filter factor F.
double sx(double t, double F, int alpha) {
  if (std::isinf(F)) return sw(t, alpha + 2);
  return F * F * (2 * sw(t, alpha) - sw(t - 1 / F, alpha) - sw(t + 1 / F, alpha));
}

/// Returns the autocovariance of the differences of that phase.
double sz(double t, double F, int alpha, int order) {
  if (order == 2) return 6 * sx(t, F, alpha) - 4 * (sx(t - 1, F, alpha) + sx(t + 1, F, alpha)) + sx(t - 2, F, alpha) + sx(t + 2, F, alpha);
  return 20 * sx(t, F, alpha) - 15 * (sx(t - 1, F, alpha) + sx(t + 1, F, alpha)) + 6 * (sx(t - 2, F, alpha) + sx(t + 2, F, alpha)) -
         sx(t - 3, F, alpha) - sx(t + 3, F, alpha);
}

double basic_sum(double J, double M, double S, double F, int alpha, int order) {
  const auto square = [&](double t) { return std::pow(sz(t, F, alpha, order), 2); };
  double sum = square(0) + (1 - J / M) * square(J / S);
  for (double j = 1; j < J; ++j) sum += 2 * (1 - j / M) * square(j / S);
  return sum;
}

struct Pair {
  double a0, a1;
};

/// Coefficients of 1 / edf = (a0 - a1 / r) / r for long records: alpha from 2 down; order 2, then 3.
constexpr std::array<std::array<Pair, 2>, 7> of_modified{{{{{7.0 / 9, 1.0 / 2}, {22.0 / 25, 2.0 / 3}}},
                                                          {{{0.997, 0.616}, {1.141, 0.843}}},
                                                          {{{1.033, 0.607}, {1.184, 0.848}}},
                                                          {{{1.048, 0.534}, {1.180, 0.816}}},
                                                          {{{1.302, 0.535}, {1.175, 0.777}}},
                                                          {{{0, 0}, {1.194, 0.703}}},
                                                          {{{0, 0}, {1.489, 0.702}}}}};
constexpr std::array<std::array<Pair, 2>, 7> of_unmodified{{{{{35.0 / 18, 1}, {231.0 / 100, 3.0 / 2}}},
                                                            {{{790, 410}, {9950, 6520}}},
                                                            {{{2.0 / 3, 1.0 / 3}, {7.0 / 9, 1.0 / 2}}},
                                                            {{{0.852, 0.375}, {0.997, 0.617}}},
                                                            {{{1.079, 0.368}, {1.033, 0.607}}},
                                                            {{{0, 0}, {1.053, 0.553}}},
                                                            {{{0, 0}, {1.302, 0.535}}}}};
constexpr std::array<Pair, 2> of_flicker_phase{{{15.23, 12}, {47.8, 40}}};  // sz(0) = b0 + b1 ln m

Pair at(const std::array<std::array<Pair, 2>, 7>& table, int alpha, int order) {
  return table[static_cast<std::size_t>(2 - alpha)][static_cast<std::size_t>(order - 2)];
}

/// Number of estimates M, and stride S of `Variance` in points of m.
struct Size {
  double M, S, m;
  double r() const { return M / S; }
};

/// Returns 1 / edf: by an exact sum if that is short, by the asymptotic form for long records, else by a sum of as many terms at wider steps.
/// `filter`: F of the exact sum; `limit`: F of the other sum, absent if it has the steps; `at_zero`: sz(0) for flicker of the phase, else 0.
double inverse_by_size(const Size& n, int alpha, int order, double filter, std::optional<double> limit, double at_zero, Pair a) {
  const double J = std::min(n.M, (order + 1) * n.S);
  if (J <= longest_sum) return basic_sum(J, n.M, n.S, filter, alpha, order) / (std::pow(sz(0, filter, alpha, order), 2) * n.M);
  if (n.r() > order + 1) return (a.a0 - a.a1 / n.r()) / ((at_zero != 0 ? at_zero * at_zero : 1) * n.r());
  const double steps = longest_sum / n.r(), F = limit.value_or(steps);
  const double zero = at_zero != 0 ? at_zero : sz(0, F, alpha, order);
  return basic_sum(longest_sum, longest_sum, steps, F, alpha, order) / (zero * zero * longest_sum);
}

double choose(int n, int k) {
  double c = 1;
  for (int i = 1; i <= k; ++i) c *= static_cast<double>(n - k + i) / i;
  return c;
}

double inverse_for_white_phase(const Size& n, int order) {
  const double middle = choose(2 * order, order), K = std::ceil(n.r());
  if (K > order) return (choose(4 * order, 2 * order) / (middle * middle) - 0.5 * order / n.r()) / n.M;
  double sum = 0;
  for (int k = 1; k < K; ++k) sum += (1 - k / n.r()) * std::pow(choose(2 * order, order - k), 2);
  return (1 + 2 * sum / (middle * middle)) / n.M;
}

}  // namespace

double degrees_of_freedom(const Variance& v, int alpha) {
  const auto m = static_cast<double>(v.m), points = static_cast<double>(v.points);
  const double S = v.overlapping ? m : 1, L = (v.modified ? m : 1) + m * v.order;
  const Size n{1 + std::floor(S * (points - L) / m), S, m};
  double inverse = 0;
  if (v.modified) {
    inverse = inverse_by_size(n, alpha, v.order, 1, 1, 0, at(of_modified, alpha, v.order));
  } else if (alpha == 2) {
    inverse = inverse_for_white_phase(n, v.order);
  } else if (alpha == 1) {
    const Pair b = of_flicker_phase[static_cast<std::size_t>(v.order - 2)];
    // Beyond m = 1e5, rounding degrades the exact sum, which then depends only on ln m.
    inverse = inverse_by_size(n, 1, v.order, std::min(m, 1e5), {}, b.a0 + b.a1 * std::log(m), at(of_unmodified, 1, v.order));
  } else {
    const double filter = m * (v.order + 1) <= longest_sum ? m : infinite;
    inverse = inverse_by_size(n, alpha, v.order, filter, infinite, 0, at(of_unmodified, alpha, v.order));
  }
  return 1 / inverse;
}

double total_degrees_of_freedom(double ratio, int alpha) {
  if (alpha >= 0) return 1.5 * ratio;
  return alpha == -1 ? 1.17 * ratio - 0.22 : 0.93 * ratio - 0.36;
}

namespace {

using Run = std::vector<double>;
constexpr std::size_t run_length = 1024, most_runs = 8;
constexpr std::size_t fewest_averages = 30;  // required for an autocorrelation

/// Returns averages first, first + 1, ... over m samples (times m).
Run averages(const std::vector<double>& phase, std::size_t m, std::size_t first, std::size_t count) {
  Run run(count);
  for (std::size_t j = 0; j < count; ++j) run[j] = phase[(first + j + 1) * m] - phase[(first + j) * m];
  return run;
}

std::vector<Run> runs_of(const std::vector<double>& phase, std::size_t m) {
  const std::size_t count = (phase.size() - 1) / m;
  if (count <= run_length * most_runs) return {averages(phase, m, 0, count)};
  std::vector<Run> runs;
  for (std::size_t k = 0; k < most_runs; ++k) runs.push_back(averages(phase, m, k * (count - run_length) / (most_runs - 1), run_length));
  return runs;
}

void remove_line(Run& run) {
  const auto n = static_cast<double>(run.size());
  double mean = 0, slope = 0;
  for (const double v : run) mean += v / n;
  for (std::size_t j = 0; j < run.size(); ++j) slope += (static_cast<double>(j) - 0.5 * (n - 1)) * run[j];
  slope *= 12 / (n * (n * n - 1));
  for (std::size_t j = 0; j < run.size(); ++j) run[j] -= mean + slope * (static_cast<double>(j) - 0.5 * (n - 1));
}

/// Returns the lag-1 autocorrelation about the mean of each run; 0 if nothing varies.
double autocorrelation(const std::vector<Run>& runs) {
  double products = 0, squares = 0;
  for (const Run& run : runs) {
    double mean = 0;
    for (const double v : run) mean += v;
    mean /= static_cast<double>(run.size());
    for (const double v : run) squares += (v - mean) * (v - mean);
    for (std::size_t j = 1; j < run.size(); ++j) products += (run[j] - mean) * (run[j - 1] - mean);
  }
  return squares > 0 ? products / squares : 0;
}

int by_autocorrelation(std::vector<Run> runs, int least) {
  for (Run& run : runs) remove_line(run);
  const int most_differences = -least / 2;
  for (int d = 0;; ++d) {
    const double r = autocorrelation(runs), delta = r / (1 + r);
    if (delta < 0.25 || d == most_differences) return std::clamp(static_cast<int>(std::lround(-2 * (delta + d))), least, 2);
    for (Run& run : runs) {
      for (std::size_t j = 0; j + 1 < run.size(); ++j) run[j] = run[j + 1] - run[j];
      run.pop_back();
    }
  }
}

/// Returns B1 of n averages for noise whose Allan variance is proportional to tau^mu.
double barnes_ratio(double n, int mu) {
  if (mu == 0) return n * std::log(n) / (2 * (n - 1) * std::log(2.0));
  return n * (1 - std::pow(n, mu)) / (2 * (n - 1) * (1 - std::pow(2.0, mu)));
}

int by_variance_ratio(const Run& run, int least) {
  const auto n = static_cast<double>(run.size());
  double mean = 0, standard = 0, allan = 0;
  for (const double v : run) mean += v / n;
  for (const double v : run) standard += (v - mean) * (v - mean) / (n - 1);
  for (std::size_t j = 1; j < run.size(); ++j) allan += (run[j] - run[j - 1]) * (run[j] - run[j - 1]) / (2 * (n - 1));
  if (allan == 0) return 0;
  // The boundary between two types is the geometric mean of their ratios. alpha = 2 and 1 have the same ratio.
  int alpha = 2;
  for (int mu = -1; - mu - 1 >= least; ++mu) {
    if (standard / allan < std::sqrt(barnes_ratio(n, mu) * barnes_ratio(n, mu - 1))) break;
    alpha = -mu - 1;
  }
  return alpha;
}

}  // namespace

int noise_type(const std::vector<double>& phase, std::size_t m, int least) {
  const std::size_t samples = phase.size() - 1;
  m = std::min(m, samples / 3);
  if (samples / m >= fewest_averages) return by_autocorrelation(runs_of(phase, m), least);
  const int by_ratio = by_variance_ratio(averages(phase, m, 0, samples / m), least);
  const std::size_t longest = samples / fewest_averages;
  return longest == 0 ? by_ratio : std::min(by_ratio, by_autocorrelation(runs_of(phase, longest), least));
}

}  // namespace imulab::noise
