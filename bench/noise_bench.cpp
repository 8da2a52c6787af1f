// Noise of a log at rest, one axis. Targets on one core: the Allan deviation of 1e7 samples at 92 averaging times, with noise types and bounds, in
// 0.4 s; the coefficients of 3 h at 400 Hz, with their intervals, in 0.25 s.
#include "imulab/core/random.hpp"
#include "imulab/noise.hpp"

#include <benchmark/benchmark.h>

#include <cmath>
#include <span>

namespace {

using namespace imulab;

const std::vector<double>& rate() {
  static const std::vector<double> readings = [] {
    std::vector<double> r(10'000'000);
    RandomStream(1, "rate").normals(0, r);
    return r;
  }();
  return readings;
}

/// 92 factors, evenly spaced by logarithm as far as whole numbers are, up to a third of the record.
std::vector<std::size_t> ninety_two() {
  std::vector<std::size_t> factors;
  const double longest = static_cast<double>(rate().size() / 3);
  for (int steps = 92; factors.size() != 92; ++steps) {
    factors.clear();
    for (int k = 0; k <= steps; ++k)
      if (const auto m = static_cast<std::size_t>(std::llround(std::pow(longest, static_cast<double>(k) / steps)));
          factors.empty() || m > factors.back())
        factors.push_back(m);
  }
  return factors;
}

void deviation_of(benchmark::State& state, DeviationKind kind, const std::vector<std::size_t>& factors) {
  rate();
  for (auto _ : state) benchmark::DoNotOptimize(deviation(rate(), 0.005, factors, kind));
  state.counters["times"] = static_cast<double>(factors.size());
}

void coefficients(benchmark::State& state) {
  const std::span<const double> three_hours = std::span(rate()).first(3 * 3600 * 400);
  for (auto _ : state) benchmark::DoNotOptimize(fit_noise(three_hours, 0.0025));
}
BENCHMARK(coefficients)->Unit(benchmark::kMillisecond);

void coefficients_and_bound(benchmark::State& state) {  // target: 1.2 times the coefficients alone
  const std::span<const double> three_hours = std::span(rate()).first(3 * 3600 * 400);
  for (auto _ : state) benchmark::DoNotOptimize(fit_noise(three_hours, 0.0025, {.bound = BoundOptions{}}));
}
BENCHMARK(coefficients_and_bound)->Unit(benchmark::kMillisecond);

BENCHMARK_CAPTURE(deviation_of, overlapping_allan_92, DeviationKind::overlapping_allan, ninety_two())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(deviation_of, overlapping_allan, DeviationKind::overlapping_allan, averaging_factors(10'000'000))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(deviation_of, overlapping_hadamard, DeviationKind::overlapping_hadamard, averaging_factors(10'000'000))
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(deviation_of, modified_allan, DeviationKind::modified_allan, averaging_factors(10'000'000))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(deviation_of, total, DeviationKind::total, averaging_factors(10'000'000))->Unit(benchmark::kMillisecond);

}  // namespace
