// Whole turntable procedures per second at the level of rest means and turn sums (target: 30,000 on one core): Zhang's procedure with drawn table
// errors, g and noise, its readings, and their calibration to second order.
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/parallel.hpp"
#include "imulab/procedure.hpp"

#include <benchmark/benchmark.h>

namespace {

using namespace imulab;

void turntable_procedure(benchmark::State& state) {
  const ThreadLimit one_core(1);
  const turntable::Plan plan = turntable::plan_of(zhang_24_procedure({}));
  const std::uint64_t runs = 10000;
  std::uint64_t seed = 1;
  for (auto _ : state) benchmark::DoNotOptimize(monte_carlo(plan, runs, seed++));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(runs));
}
BENCHMARK(turntable_procedure)->Unit(benchmark::kMillisecond);

void turntable_prediction(benchmark::State& state) {
  const turntable::Plan plan = turntable::plan_of(zhang_24_procedure({}));
  for (auto _ : state) benchmark::DoNotOptimize(predict(plan));
}
BENCHMARK(turntable_prediction)->Unit(benchmark::kMillisecond);

}  // namespace
