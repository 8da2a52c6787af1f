// Strapdown integration. Target: 5 million single-sample updates/s on one core, at the accuracy of the test (an hour of flight ends within 1 mm).
#include <benchmark/benchmark.h>

#include "tests/closed_form_flight.hpp"

namespace {

using namespace imulab;
using namespace imulab::motion;

void strapdown_single_sample(benchmark::State& state) {
  const Trajectory flight = closed_form_flight(600);
  const std::vector<Increment> increments = ideal_increments(flight, 0.01);
  for (auto _ : state) {
    Strapdown strapdown(navigation_state(flight.at(0)));
    for (const Increment& sample : increments) strapdown.step(sample, 0.01);
    benchmark::DoNotOptimize(strapdown.state());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(increments.size()));
}
BENCHMARK(strapdown_single_sample)->Unit(benchmark::kMillisecond);

void ideal_imu(benchmark::State& state) {
  const Trajectory flight = closed_form_flight(60);
  for (auto _ : state) benchmark::DoNotOptimize(ideal_increments(flight, 0.01));
  state.SetItemsProcessed(state.iterations() * 6000);
}
BENCHMARK(ideal_imu)->Unit(benchmark::kMillisecond);

}  // namespace
