// The length at which a log shows its random walk beside its flicker: the table of docs/theory/noise.md.
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/noise.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include "tests/flicker_log.hpp"
#include <cmath>
#include <numbers>
#include <string>

namespace imulab::acceptance {

namespace {

constexpr double unit_interval = 1;  // of the readings: all that counts are ratios
constexpr std::size_t readings = 65536;
constexpr double log_s = unit_interval * readings;

constexpr double flicker = 2 * std::numbers::ln2 / std::numbers::pi;  // Allan variance of B = 1

/// B = 1; white noise as large as it at this part of the log; K^2 as `ratio` says, which is T K^2 / B^2.
NoiseModel noise_of(double ratio, double part = 1000) { return {.N = std::sqrt(flicker * log_s / part), .B = 1, .K = std::sqrt(ratio / log_s)}; }

struct Walk {
  NoiseCoefficient fitted = {};
  double read_off = 0;  ///< as if the curve's last point were walk alone
  JointNoise joint = {};
  void fields(auto&& visit) {
    visit(fitted.value, fitted.standard_uncertainty, fitted.lower, fitted.upper, fitted.determined, read_off, joint.tau_s, joint.deviation.lower,
          joint.deviation.upper);
  }
};

Walk walk_of(const NoiseModel& truth, std::uint64_t seed) {
  std::vector<double> rate(readings);
  add_flicker(rate, truth.B, unit_interval, seed);
  const AxisNoise rest({.N = truth.N, .K = truth.K}, unit_interval, seed, "noise of a length");
  rest.add_slow(rate);
  rest.add_fast(0, rate);
  const DeviationPoint last = deviation(rate, unit_interval, {averaging_factors(rate.size()).back()}, DeviationKind::overlapping_allan).back();
  const NoiseFit fit = fit_noise(rate, unit_interval);
  return {fit.K, last.deviation * std::sqrt(3 / last.tau), fit.joint.value_or(JointNoise{})};
}

}  // namespace

std::vector<Check> noise_lengths(int logs) {
  std::vector<Check> checks;
  // 99.9 % of the runs of so many logs, if 95 % of all intervals hold.
  const double least = binomial_quantile(0.001, logs, 0.95) / logs;
  std::uint64_t row = 0;
  for (const double ratio : {1.0, 10.0, 30.0, 100.0, 300.0, 1000.0}) {
    const NoiseModel truth = noise_of(ratio);
    const std::uint64_t first_seed = 1'000'000 * ++row;  // no row shares its logs with another
    by_part([&] {
      const auto walks = runs_of<Walk>(fmt::format("noise-lengths {}", row), logs, [&](std::size_t i) { return walk_of(truth, first_seed + i); });
      double held = 0;
      std::vector<double> stated, over, read_off;
      for (const auto& [K, read, both] : walks) {
        held += K.lower <= truth.K && truth.K <= K.upper;
        read_off.push_back(read / truth.K);
        if (K.determined) stated.push_back(K.standard_uncertainty / K.value), over.push_back(K.value / truth.K);
      }
      const std::string name = fmt::format("T K^2 / B^2 = {:g}: ", ratio);
      checks.push_back({name + "95 % intervals hold", held / logs, least, 1});
      checks.push_back({name + "determined", static_cast<double>(stated.size()) / logs, ratio >= 300 ? 0.95 : 0, 1});
      // 400 logs tell these to some percent; the point that is read has five degrees of freedom or fewer.
      checks.push_back({name + "read off, least 10 %", quantile(read_off, 0.1), 0.2, 1});
      checks.push_back({name + "read off, median", median(read_off), 0.6, ratio <= 1 ? 3 : 1.2});
      checks.push_back({name + "read off, largest 10 %", quantile(read_off, 0.9), 1.3, 5});
      if (stated.empty()) return;
      checks.push_back({name + "stated uncertainty, median", median(stated), 0, 1});
      checks.push_back({name + "K over its truth, median", median(over), 0, ratio >= 100 ? 1.1 : 10});
    });
  }
  // Of noisier logs many determine neither B nor K: the interval of both together, conditional on these.
  const NoiseModel truth = noise_of(10, 20);
  by_part([&] {
    const auto walks = runs_of<Walk>("noise-lengths both", logs, [&](std::size_t i) { return walk_of(truth, 7'000'000 + i); });
    double joint = 0, held = 0;
    for (const Walk& walk : walks) {
      const double deviation = std::sqrt(flicker + truth.K * truth.K * walk.joint.tau_s / 3);
      if (walk.joint.tau_s > 0) ++joint, held += walk.joint.deviation.lower <= deviation && deviation <= walk.joint.deviation.upper;
    }
    checks.push_back({"B and K together: determined, where neither is alone", joint / logs, 0.2, 1});
    checks.push_back({"B and K together: 95 % intervals hold", held / joint, binomial_quantile(0.001, static_cast<int>(joint), 0.95) / joint, 1});
  });
  return checks;
}

}  // namespace imulab::acceptance
