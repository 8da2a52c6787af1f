// Filters with the noise of `imulab noise --bound`: whether they state at least their errors, and how much more. Units are drawn over three decades;
// each filter is aided for a minute with a position every second, then coasts. Errors follow by covariance from the true noise, without draws.
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/noise.hpp"
#include "imulab/noise/bound.hpp"

#include <Eigen/Core>
#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include "tests/flicker_log.hpp"
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace imulab::acceptance {

namespace {

using Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;

constexpr double reading_s = 0.1, step = 1, aided_s = 60;
constexpr std::array coasts{10.0, 60.0, 600.0};

/// The noise of an accelerometer as states of a filter: white density, processes and a walk.
struct Noise {
  double N = 0, K = 0, start = 0;  // start: standard deviation of the walk or constant at first
  std::vector<BoundProcess> markov;
};

/// White noise of 1, and the times at which flicker, walk and two processes exceed it.
struct Unit {
  double B = 0, K = 0, turn_on = 0;
  std::array<BoundProcess, 2> processes;
};

Unit drawn(std::uint64_t seed) {
  const RandomStream draws(seed, "unit of a noise bound");
  const auto decades = [&](std::uint64_t k, double low, double high) { return std::pow(10.0, low + (high - low) * draws.uniform(k)); };
  const double flicker = std::numbers::pi / (2 * std::numbers::ln2);  // B^2 of an Allan variance
  Unit u;
  u.B = std::sqrt(flicker / decades(0, 0, 3));
  u.K = std::sqrt(3 * u.B * u.B / flicker / decades(1, 2, 5));
  for (std::size_t k = 0; k < 2; ++k) {
    u.processes[k].time = decades(2 + 2 * k, 0.5, 3.5);
    u.processes[k].sigma = std::sqrt(decades(3 + 2 * k, -1, 1) / u.processes[k].time);
  }
  u.turn_on = 10 * u.B;
  return u;
}

std::vector<double> log_of(const Unit& u, double length_s, std::uint64_t seed) {
  std::vector<double> rate(static_cast<std::size_t>(length_s / reading_s));
  add_flicker(rate, u.B, reading_s, seed);
  for (std::size_t k = 0; k < 2; ++k)
    add_process(rate, u.processes[k].sigma, u.processes[k].time, reading_s, RandomStream(seed, fmt::format("process {}", k)));
  const RandomStream white(seed, "white"), walk(seed, "walk");
  double bias = 0;
  for (std::size_t i = 0; i < rate.size(); ++i) {
    rate[i] += bias + white.normal(i) / std::sqrt(reading_s);
    bias += u.K * std::sqrt(reading_s) * walk.normal(i);
  }
  return rate;
}

/// The true noise; processes slower than a day are part of what is constant from switch-on, faster ones than the filter's step are white.
Noise truth_of(const Unit& u) {
  Noise out{.N = 1, .K = u.K, .start = u.turn_on, .markov = {}};
  double white = 1;
  const auto add = [&](double sigma, double time) {
    if (time < step)
      white += 2 * sigma * sigma * time;
    else if (time < 1e5)
      out.markov.push_back({sigma, time});
  };
  for (int i = 0; i < 28; ++i) add(u.B * std::sqrt(std::numbers::ln2 / std::numbers::pi), reading_s / 64 * std::pow(2.0, i));
  for (const BoundProcess& p : u.processes) add(p.sigma, p.time);
  out.N = std::sqrt(white);
  return out;
}

/// Transition and driven covariance of position, velocity, the walk and the processes over a step.
struct Model {
  MatrixXd F, Q, P0;
};

Model model_of(const Noise& noise) {
  const auto n = static_cast<Index>(3 + noise.markov.size());
  Model out{MatrixXd::Identity(n, n), MatrixXd::Zero(n, n), MatrixXd::Zero(n, n)};
  out.F(0, 1) = step;
  out.Q(1, 1) = noise.N * noise.N * step, out.Q(0, 1) = out.Q(1, 0) = out.Q(1, 1) * step / 2, out.Q(0, 0) = out.Q(1, 1) * step * step / 3;
  out.Q(2, 2) = noise.K * noise.K * step;
  out.P0(2, 2) = noise.start * noise.start;
  for (Index i = 2; i < n; ++i) {
    out.F(1, i) = step, out.F(0, i) = step * step / 2;
    if (i == 2) continue;
    const BoundProcess& p = noise.markov[static_cast<std::size_t>(i - 3)];
    out.F(i, i) = std::exp(-step / p.time);
    out.Q(i, i) = -p.sigma * p.sigma * std::expm1(-2 * step / p.time);
    out.P0(i, i) = p.sigma * p.sigma;
  }
  return out;
}

/// Stated over true standard deviation of the position: aided, then after each coast.
std::array<double, 4> stated_over_true(const Noise& truth, const Noise& stated) {
  constexpr double fix = 1;
  const Model t = model_of(truth), f = model_of(stated);
  const Index nt = t.F.rows(), nf = f.F.rows();
  MatrixXd F = MatrixXd::Zero(nt + nf, nt + nf), Q = F, joint = F, P = f.P0;  // the true states, then the filter's estimates
  F.topLeftCorner(nt, nt) = t.F, F.bottomRightCorner(nf, nf) = f.F;
  Q.topLeftCorner(nt, nt) = t.Q;
  joint.topLeftCorner(nt, nt) = t.P0;
  P(0, 0) = P(1, 1) = joint(0, 0) = joint(1, 1) = 1;
  std::array<double, 4> out{};
  const auto ratio = [&] { return std::sqrt(P(0, 0) / (joint(0, 0) + joint(nt, nt) - 2 * joint(0, nt))); };
  for (int k = 1; k <= static_cast<int>(aided_s + coasts.back()); ++k) {
    joint = F * joint * F.transpose() + Q;
    P = f.F * P * f.F.transpose() + f.Q;
    if (k <= aided_s) {
      const VectorXd gain = P.col(0) / (P(0, 0) + fix * fix);
      MatrixXd A = MatrixXd::Identity(nt + nf, nt + nf);
      A.block(nt, 0, nf, 1) = gain, A.block(nt, nt, nf, 1) -= gain;
      joint = A * joint * A.transpose();
      joint.bottomRightCorner(nf, nf) += gain * gain.transpose() * fix * fix;
      P -= gain * P.row(0);
    }
    if (k == aided_s) out[0] = ratio();
    for (std::size_t c = 0; c < coasts.size(); ++c)
      if (k == static_cast<int>(aided_s + coasts[c])) out[1 + c] = ratio();
  }
  return out;
}

Noise with_turn_on(const NoiseBound& bound, double turn_on) { return {bound.N, bound.K, std::hypot(bound.start_sigma, turn_on), bound.markov}; }

struct Result {
  std::array<double, 4> filter{}, two_numbers{}, fitted{}, ten{};
  void fields(auto&& visit) {
    for (auto* const part : {&filter, &two_numbers, &fitted, &ten}) visit((*part)[0], (*part)[1], (*part)[2], (*part)[3]);
  }
};

Result result_of(std::uint64_t seed, double length_s) {
  const Unit unit = drawn(seed);
  const NoiseFit fit = fit_noise(log_of(unit, length_s, seed), reading_s, {.bound = BoundOptions{}});
  const Noise truth = truth_of(unit);
  const NoiseBound& bound = *fit.bound;
  const auto size = [](const NoiseCoefficient& c) { return c.determined ? c.value : c.upper; };
  std::vector<UpperDensity> fitted;  // without the confidence
  for (const SpectrumPoint& p : fit.spectrum) fitted.push_back({p.hz, p.model});
  fitted = noise::at_frequencies(fitted, noise::bound_frequencies(reading_s, bound.horizon_s));
  Result out;
  out.filter = stated_over_true(truth, with_turn_on(bound, unit.turn_on));
  out.two_numbers = stated_over_true(truth, with_turn_on(noise::tightest_bound(bound.upper, reading_s, {}, 0), unit.turn_on));
  out.fitted = stated_over_true(truth, with_turn_on(noise::tightest_bound(std::move(fitted), reading_s, {}), unit.turn_on));
  out.ten = stated_over_true(truth, {.N = 10 * size(fit.N), .K = 10 * size(fit.K), .start = unit.turn_on, .markov = {}});
  return out;
}

/// The share of errors within 1.96 stated standard deviations.
double coverage(double stated_over_true) { return std::erf(1.96 * stated_over_true / std::numbers::sqrt2); }

}  // namespace

std::vector<Check> noise_bounds(int units) {
  std::vector<Check> checks;
  const double least = binomial_quantile(0.001, units, 0.95) / units;
  for (const double hours : {1.0, 12.0}) {
    by_part([&] {
      const auto results =
          runs_of<Result>(fmt::format("noise-bounds {:g} h", hours), units, [&](std::size_t i) { return result_of(1 + i, 3600 * hours); });
      const auto judged = [&](const char* name, std::array<double, 4> Result::*part, bool required) {
        for (std::size_t c = 0; c < 4; ++c) {
          std::vector<double> ratios;
          double held = 0;
          for (const Result& r : results) ratios.push_back((r.*part)[c]), held += coverage((r.*part)[c]);
          const std::string where = c == 0 ? "aided" : fmt::format("coast of {:g} s", coasts[c - 1]);
          const std::string row = fmt::format("{:g} h, {}, {}: ", hours, name, where);
          checks.push_back({row + "within 1.96 sigmas", held / units, required ? least : 0, 1});
          checks.push_back({row + "stated over true, median", median(ratios), 0,
                            !required                                               ? 100
                            : c == 3 && (hours < 2 || part == &Result::two_numbers) ? 2
                                                                                    : 1.3});
        }
      };
      judged("bound", &Result::filter, true);
      judged("bound of N and K", &Result::two_numbers, true);
      judged("best fit", &Result::fitted, false);
      judged("ten times", &Result::ten, false);
    });
  }
  return checks;
}

}  // namespace imulab::acceptance
