// Error budget. Target: an hour at 100 Hz with every coefficient, every noise term, start and barometer in at most 0.5 s on one core.
#include "imulab/coefficient.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/navigation/budget/specification.hpp"

#include <benchmark/benchmark.h>

#include "tests/closed_form_flight.hpp"

namespace {

using namespace imulab;
using namespace imulab::motion;

/// A tactical IMU whose model uses every term, with errors of all coefficients.
ErrorSources every_source() {
  ErrorSpecification specification;
  specification.grade = "tactical";
  ErrorSources s = error_sources(specification);
  s.model.accel.quadratic.setConstant(1e-6);
  s.model.gyro.matrix(0, 1) = 1e-3;
  s.model.g_sensitivity.setConstant(1e-6);
  s.coefficients.clear();
  for (const CoefficientIndex i : coefficient_indices())
    if (coefficient(i).term != Term::lever_arm) s.coefficients.push_back(i);
  const auto n = static_cast<Eigen::Index>(s.coefficients.size());
  s.fixed.setZero(n);
  s.covariance = 1e-10 * Eigen::MatrixXd::Identity(n, n);
  s.start.velocity.fill({0.1});
  s.start.position.fill({10});
  s.start.aligned_over = 300;
  s.barometer = {{3}, 1, 10};
  return s;
}

void error_budget_of_an_hour_target_500ms(benchmark::State& state) {
  const NominalMotion motion = nominal_motion(closed_form_flight(3600), 0.01);
  const ErrorSources sources = every_source();
  for (auto _ : state) benchmark::DoNotOptimize(error_budget(motion, sources, {.strapdown = {.vertical = VerticalChannel::aided}}));
}
BENCHMARK(error_budget_of_an_hour_target_500ms)->Unit(benchmark::kMillisecond);

/// 100 runs of an hour at 10 Hz, on all cores.
void error_monte_carlo_100_hours_at_10_hz(benchmark::State& state) {
  const NominalMotion motion = nominal_motion(closed_form_flight(3600), 0.1);
  const ErrorSources sources = every_source();
  for (auto _ : state) benchmark::DoNotOptimize(error_monte_carlo(motion, sources, {.strapdown = {.vertical = VerticalChannel::aided}, .runs = 100}));
  state.SetItemsProcessed(state.iterations() * 3600000);
}
BENCHMARK(error_monte_carlo_100_hours_at_10_hz)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
