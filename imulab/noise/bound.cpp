#include "imulab/noise/bound.hpp"

#include "imulab/error.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace imulab::noise {

namespace {

using Eigen::ArrayXd, Eigen::ArrayXXd, Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd, std::numbers::pi;

constexpr double points_in_a_decade = 10, times_in_a_decade = 4;
constexpr double lowest_over_horizon = 0.1;  // coasts and filters of this length see frequencies well below 1 / horizon
constexpr double worth_a_process = 0.01;     // of the tightness

double walk_density(double hz, double T) { return std::pow(T / (2 * std::sin(pi * hz * T)), 2); }

double process_density(double hz, double T, double time_s) {
  const double a = std::exp(-T / time_s);
  return -T * std::expm1(-2 * T / time_s) / (1 - 2 * a * std::cos(2 * pi * hz * T) + a * a);
}

/// Minimizes the sum of x for A x >= 1, x >= 0, by the simplex method on the dual problem: sum of y, A^T y <= 1, y >= 0. A: positive, few columns.
VectorXd least_sum_above_one(const MatrixXd& A) {
  const Index m = A.cols(), n = A.rows();
  MatrixXd table(m + 1, n + m + 1);  // columns y, slacks, right side; the last row are the reduced costs
  table << A.transpose(), MatrixXd::Identity(m, m), VectorXd::Ones(m), -Eigen::RowVectorXd::Ones(n), Eigen::RowVectorXd::Zero(m + 1);
  constexpr double rounding = 1e-11;
  constexpr int most_pivots = 1000;  // usually a dozen; rounding could let it go in a circle
  for (int pivots = 0; pivots < most_pivots; ++pivots) {
    Index column = 0, row = -1;
    if (table.row(m).head(n + m).minCoeff(&column) > -rounding) return table.row(m).segment(n, m).transpose();
    for (Index i = 0; i < m; ++i)
      if (table(i, column) > rounding && (row < 0 || table(i, n + m) / table(i, column) < table(row, n + m) / table(row, column))) row = i;
    if (row < 0) break;
    const Eigen::RowVectorXd pivot = table.row(row) / table(row, column);
    table.row(row) = pivot;
    for (Index i = 0; i <= m; ++i)
      if (const double factor = table(i, column); i != row) table.row(i) -= factor * pivot;
  }
  throw Error("noise bound: no model is above the spectrum; expected densities of a log at rest");
}

/// A model above the spectrum with processes of given times.
struct Candidate {
  std::vector<double> times;
  VectorXd squares;  // N^2, sigma^2 of each process, K^2
  double mean = std::numeric_limits<double>::infinity();
};

class Programs {
 public:
  Programs(const std::vector<UpperDensity>& upper, double interval_s) : T_(interval_s) {
    for (const UpperDensity& u : upper) hz_.push_back(u.hz), over_.push_back(1 / u.density);
  }

  Candidate with(std::vector<double> times, bool walk = true) const {
    const auto n = static_cast<Index>(hz_.size()), m = static_cast<Index>(times.size()) + (walk ? 2 : 1);
    MatrixXd A(n, m);
    for (Index j = 0; j < n; ++j) {
      const double f = hz_[static_cast<std::size_t>(j)], over = over_[static_cast<std::size_t>(j)];
      A(j, 0) = over;
      for (std::size_t k = 0; k < times.size(); ++k) A(j, static_cast<Index>(1 + k)) = over * process_density(f, T_, times[k]);
      if (walk) A(j, m - 1) = over * walk_density(f, T_);
    }
    const VectorXd means = A.colwise().mean();
    const VectorXd shares = least_sum_above_one(A * means.cwiseInverse().asDiagonal());
    return {std::move(times), shares.cwiseQuotient(means), shares.sum()};
  }

 private:
  double T_;
  std::vector<double> hz_, over_;
};

/// Returns the best with this number of processes at any of the times.
Candidate best_with(const Programs& programs, int processes, const std::vector<double>& times) {
  if (processes == 0) return programs.with({});
  Candidate best;
  for (std::size_t i = 0; i < times.size(); ++i)
    for (std::size_t j = processes == 2 ? i + 1 : i; j < (processes == 2 ? times.size() : i + 1); ++j) {
      Candidate c = programs.with(processes == 2 ? std::vector{times[j], times[i]} : std::vector{times[i]});
      if (c.mean < best.mean) best = std::move(c);
    }
  return best;
}

/// Returns round times: 1, 1.8, 3.2, 5.6, 10 ...
std::vector<double> times_between(double shortest, double longest) {
  std::vector<double> out;
  for (int k = static_cast<int>(std::ceil(times_in_a_decade * std::log10(shortest))); std::pow(10, k / times_in_a_decade) <= longest; ++k)
    out.push_back(std::pow(10, k / times_in_a_decade));
  return out;
}

}  // namespace

std::vector<double> bound_frequencies(double interval_s, double horizon_s) {
  const double lowest = lowest_over_horizon / horizon_s, highest = 0.5 / interval_s;
  const auto steps = static_cast<std::size_t>(std::ceil(points_in_a_decade * std::log10(highest / lowest)));
  std::vector<double> out;
  for (std::size_t i = 0; i <= steps; ++i) out.push_back(lowest * std::pow(highest / lowest, static_cast<double>(i) / static_cast<double>(steps)));
  return out;
}

std::vector<UpperDensity> at_frequencies(const std::vector<UpperDensity>& upper, const std::vector<double>& hz) {
  std::vector<UpperDensity> out;
  for (const double f : hz) {
    const auto after = std::ranges::find_if(upper, [&](const UpperDensity& u) { return u.hz >= f; });
    if (after == upper.begin())
      out.push_back({f, upper.front().density * std::pow(upper.front().hz / f, 2)});
    else if (after == upper.end())
      out.push_back({f, upper.back().density});
    else {
      const UpperDensity &a = *(after - 1), &b = *after;
      const double part = std::log(f / a.hz) / std::log(b.hz / a.hz);
      out.push_back({f, std::exp((1 - part) * std::log(a.density) + part * std::log(b.density))});
    }
  }
  return out;
}

std::optional<CommonProcess> bounds_with_common_process(const std::vector<std::vector<UpperDensity>>& upper, double interval_s) {
  if (upper.empty()) return {};
  std::vector<Programs> programs;
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& axis : upper) programs.emplace_back(axis, interval_s), lowest = std::min(lowest, axis.front().hz);
  CommonProcess best;
  double least = std::numeric_limits<double>::infinity();
  for (const double time : times_between(2 * interval_s, 10 / (2 * pi * lowest))) {  // ten times the longest that shows: a walk
    CommonProcess now{.time = time};
    double mean = 0;
    for (const Programs& axis : programs) {
      const Candidate c = axis.with({time}, false);
      now.N.push_back(std::sqrt(c.squares[0])), now.sigma.push_back(std::sqrt(c.squares[1])), mean += c.mean;
    }
    if (mean < least) least = mean, best = std::move(now);
  }
  return best;
}

NoiseBound tightest_bound(std::vector<UpperDensity> upper, double interval_s, const BoundOptions& options, int most_processes) {
  if (!(interval_s > 0)) throw Error("noise bound: no sampling interval; expected that of the log");
  for (const UpperDensity& u : upper)
    if (!(std::isfinite(u.density) && u.density > 0))
      throw Error(fmt::format("noise bound: density {:g} at {:g} Hz: expected a positive number", u.density, u.hz));
  const Programs programs(upper, interval_s);
  const std::vector<double> times = times_between(2 * interval_s, 1 / (2 * pi * upper.front().hz));
  Candidate best = best_with(programs, 0, times);
  for (int processes = 1; processes <= most_processes; ++processes)
    if (Candidate more = best_with(programs, processes, times); more.mean < best.mean * (1 - worth_a_process)) best = std::move(more);
  NoiseBound out;
  out.confidence = options.confidence, out.horizon_s = options.horizon_s, out.tightness = best.mean;
  out.N = std::sqrt(best.squares[0]);
  for (std::size_t k = 0; k < best.times.size(); ++k)
    if (const double square = best.squares[static_cast<Index>(1 + k)]; square > 0) out.markov.push_back({std::sqrt(square), best.times[k]});
  out.K = std::sqrt(std::max(0.0, best.squares[best.squares.size() - 1]));
  out.start_sigma = std::sqrt(2 * upper.front().hz * upper.front().density);
  out.upper = std::move(upper);
  return out;
}

double density(const NoiseBound& bound, double hz, double interval_s) {
  double sum = bound.N * bound.N + bound.K * bound.K * walk_density(hz, interval_s);
  for (const BoundProcess& p : bound.markov) sum += p.sigma * p.sigma * process_density(hz, interval_s, p.time);
  return sum;
}

void set_coasts(NoiseBound& bound, const NoiseCoefficients& fitted) {
  const auto known = [](double value) { return NoiseCoefficient{value, 0, value, value, true}; };
  NoiseCoefficients model;
  model.N = known(bound.N), model.K = known(bound.K);
  for (const BoundProcess& p : bound.markov) model.markov.push_back({known(p.sigma), known(p.time)});
  NoiseCoefficients accumulating = fitted;
  accumulating.Q = {};
  std::vector<double> coasts{10, 60, bound.horizon_s};
  std::ranges::sort(coasts);
  coasts.erase(std::unique(coasts.begin(), coasts.end()), coasts.end());
  bound.coast.clear();
  for (const double time : coasts)
    if (time <= bound.horizon_s)
      bound.coast.push_back({time, std::sqrt(allan_variance(model, time).sum() / allan_variance(accumulating, time).sum())});
}

}  // namespace imulab::noise
