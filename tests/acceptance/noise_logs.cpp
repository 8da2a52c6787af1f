// Noise coefficients of simulated logs of 3 h at 200 Hz: do the intervals hold, and are the errors as small as the spectrum allows?
#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/noise.hpp"
#include "imulab/noise/likelihood.hpp"

#include <Eigen/Cholesky>
#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include "tests/flicker_log.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace imulab::acceptance {

namespace {

constexpr double interval = 0.005;
constexpr std::size_t samples = 3 * 3600 * 200;

/// The parts of a log; N is 1.
struct NoiseTruth {
  NoiseModel model{};
  double sigma = 0, time = 0;  ///< of a Markov process; 0: none
  double cutoff = 0;           ///< of a second-order low-pass [Hz]; 0: none
  bool digital = false;        ///< at the readings' rate; else analog, before sampling
  double step = 0;             ///< of the readings
  double value(std::size_t j) const { return std::array{model.Q, model.N, model.B, model.K}[j]; }
};

double drawn(const RandomStream& draws, std::uint64_t k, double from_log10, double to_log10) {
  return std::pow(10, from_log10 + (to_log10 - from_log10) * draws.uniform(k));
}

/// Each term over three decades, from what no log of this length shows to what dominates it.
NoiseTruth drawn_noise(std::uint64_t seed) {
  const RandomStream draws(seed, "truth of a log");
  NoiseTruth t;
  t.model = {.Q = drawn(draws, 0, -4, -1), .N = 1, .B = drawn(draws, 1, -2.5, 0.5), .K = drawn(draws, 2, -4, -1)};
  if (draws.uniform(3) < 0.5) t.sigma = drawn(draws, 4, -3, 0), t.time = drawn(draws, 5, -0.5, 2.5);
  if (draws.uniform(6) < 0.5) {
    t.cutoff = 20 + 50 * draws.uniform(7), t.digital = draws.uniform(8) < 0.5;
    // A tenth of the readings' scatter, to all of it: of coarser steps the error is no noise of its own.
    t.step = drawn(draws, 9, -1, 0) * std::sqrt(2 * 1.1 * t.cutoff);
  }
  return t;
}

/// Second-order Butterworth by the bilinear transform.
class LowPassFilter {
 public:
  LowPassFilter(double cutoff_hz, double interval_s) {
    const double c = 1 / std::tan(std::numbers::pi * cutoff_hz * interval_s), root = std::numbers::sqrt2;
    b_ = 1 / (1 + root * c + c * c), a1_ = 2 * b_ * (1 - c * c), a2_ = b_ * (1 - root * c + c * c);
  }
  double operator()(double x) {
    const double y = b_ * (x + 2 * x1_ + x2_) - a1_ * y1_ - a2_ * y2_;
    x2_ = x1_, x1_ = x, y2_ = y1_, y1_ = y;
    return y;
  }

 private:
  double b_, a1_, a2_, x1_ = 0, x2_ = 0, y1_ = 0, y2_ = 0;
};

void low_pass(std::vector<double>& x, double cutoff_hz) {
  LowPassFilter filter(cutoff_hz, interval);
  for (double& value : x) value = filter(value);
}

/// White noise through an analog filter y'' + sqrt(2) w y' + w^2 y = w^2 u, sampled: the exact transition of y and y' / w over an interval. With what
/// sampling folds in, the density at low frequency is N^2.
void add_analog(std::vector<double>& x, const NoiseTruth& truth, const RandomStream& draws) {
  const double w = 2 * std::numbers::pi * truth.cutoff, a = w * interval / std::numbers::sqrt2, e = std::exp(-a), c = e * std::cos(a),
               s = e * std::sin(a);
  Eigen::Matrix2d transition;
  transition << c + s, std::numbers::sqrt2 * s, -std::numbers::sqrt2 * s, c - s;
  double folded = 1;
  for (int fold = 1; fold <= 100; ++fold) folded += 2 / (1 + std::pow(fold / interval / truth.cutoff, 4));
  const double variance = truth.model.N * truth.model.N / folded * w / (2 * std::numbers::sqrt2);  // of y, and of y' / w
  const Eigen::Matrix2d driven = variance * (Eigen::Matrix2d::Identity() - transition * transition.transpose());
  const Eigen::Matrix2d root = driven.llt().matrixL();
  Eigen::Vector2d state = std::sqrt(variance) * Eigen::Vector2d(draws.normal(0), draws.normal(1));
  std::array<double, 1024> z{};
  for (std::size_t begin = 0; begin < x.size(); begin += z.size() / 2) {
    draws.normals(2 + 2 * begin, z);
    for (std::size_t k = 0; k < z.size() / 2 && begin + k < x.size(); ++k) {
      state = transition * state + root * Eigen::Vector2d(z[2 * k], z[2 * k + 1]);
      x[begin + k] += state[0];
    }
  }
}

std::vector<double> noise_log(const NoiseTruth& truth, std::uint64_t seed) {
  std::vector<double> x(samples);
  const bool analog = truth.cutoff > 0 && !truth.digital;
  add_flicker(x, truth.model.B, interval, seed);
  if (truth.sigma > 0) add_process(x, truth.sigma, truth.time, interval, RandomStream(seed, "process of a log"));
  const AxisNoise rest({.N = analog ? 0 : truth.model.N, .K = truth.model.K}, interval, seed, "noise of a log");
  rest.add_slow(x);
  rest.add_fast(0, x);
  if (truth.cutoff > 0) low_pass(x, truth.cutoff);
  if (analog) add_analog(x, truth, RandomStream(seed, "white noise of a log"));
  AxisNoise({.Q = truth.model.Q}, interval, seed, "quantization of a log").add_fast(0, x);
  if (truth.step > 0)
    for (double& value : x) value = truth.step * std::round(value / truth.step);
  return x;
}

/// Cramer-Rao bounds of ln Q^2, ln N^2, ln B^2 and ln K^2: the true model's information, all its terms unknown, and the ramp.
std::array<double, 4> bounds(const NoiseTruth& truth, const noise::Spectrum& spectrum) {
  noise::Terms terms;
  terms.markov = truth.sigma > 0 ? 1 : 0;
  if (truth.cutoff > 0) terms.low_pass = {2, truth.digital};
  const noise::SpectrumLikelihood problem(spectrum, 1 / interval, truth.step, terms);
  noise::Parameters at(terms.count());
  at.head(4) << truth.model.Q * truth.model.Q / problem.Q_scale(), 0, 2 * std::log(truth.model.B), 2 * std::log(truth.model.K);
  if (terms.markov > 0) at[terms.sigma(0)] = 2 * std::log(truth.sigma), at[terms.time(0)] = std::log(truth.time);
  if (truth.cutoff > 0) at[terms.cutoff()] = std::log(truth.cutoff);
  Eigen::MatrixXd D = problem.sensitivity(at, problem.modeled(at));
  D.col(0) *= at[0];
  const Eigen::MatrixXd covariance = inverse_of(0.5 * (D.transpose() * problem.counts().matrix().asDiagonal() * D));
  std::array<double, 4> out;
  for (Eigen::Index j = 0; j < 4; ++j) out[static_cast<std::size_t>(j)] = std::sqrt(covariance(j, j));
  return out;
}

/// The estimates of a coefficient.
struct Fitted {
  bool determined = false;
  double value = 0, lower = 0, upper = 0, truth = 0, bound = 0;
  void fields(auto&& visit) { visit(determined, value, lower, upper, truth, bound); }
};

struct LogResult {
  bool accepted = false, cut = false;
  std::array<Fitted, 4> coefficients;  ///< Q, N, B, K
  void fields(auto&& visit) { visit(accepted, cut, coefficients); }
};

}  // namespace

std::vector<Check> noise_logs(int logs) {
  const auto results = runs_of<LogResult>("noise", logs, [&](std::size_t i) {
    LogResult r;
    const std::uint64_t seed = i + 1;
    const NoiseTruth truth = drawn_noise(seed);
    const std::vector<double> rate = noise_log(truth, seed);
    const NoiseFit fit = fit_noise(rate, interval);
    r.accepted = fit.accepted(), r.cut = fit.cut;
    const std::array<double, 4> bound = bounds(truth, noise::spectrum_of(rate, interval));
    for (std::size_t j = 0; const NoiseCoefficient* c : {&fit.Q, &fit.N, &fit.B, &fit.K}) {
      r.coefficients[j] = {c->determined, c->value, c->lower, c->upper, truth.value(j), 0.5 * truth.value(j) * bound[j]};
      ++j;
    }
    return r;
  });
  std::vector<Check> checks;
  double accepted = 0, cut = 0;
  for (const LogResult& r : results) accepted += r.accepted, cut += r.cut;
  checks.push_back({"model accepted", accepted / logs, 0.98, 1});
  checks.push_back({"high frequencies left out", cut / logs, 0, 0.05});
  for (std::size_t j = 0; j < 4; ++j) {
    const std::string name(1, "QNBK"[j]);
    int visible = 0, stated = 0, invisible = 0, held = 0, silent = 0;
    double squares = 0;
    for (const LogResult& r : results) {
      const Fitted& c = r.coefficients[j];
      held += c.lower <= c.truth && c.truth <= c.upper;
      if (c.bound > c.truth) ++invisible, silent += !c.determined;
      // A tenth of its value: ten sigma, where the bound is that of an estimate which is normal.
      if (c.bound > 0.1 * c.truth) continue;
      ++visible;
      if (c.determined) ++stated, squares += std::pow((c.value - c.truth) / c.bound, 2);
    }
    checks.push_back({name + ": 95 % intervals hold", static_cast<double>(held) / logs, 0.93, 0.97});
    if (invisible > 0)
      checks.push_back({name + ": not determined, of " + std::to_string(invisible), static_cast<double>(silent) / invisible, 0.95, 1});
    if (visible > 0) checks.push_back({name + ": determined, of " + std::to_string(visible), static_cast<double>(stated) / visible, 0.95, 1});
    if (stated > 0) checks.push_back({name + ": RMS error over bound", std::sqrt(squares / stated), 0, 1.1});
  }
  return checks;
}

}  // namespace imulab::acceptance
