// Whole turntable procedures a second at the level of rest means and turn sums (target: 30,000 on one core): Zhang's procedure with drawn table
// errors and noise, its readings, and their calibration with an estimator built once.
#include <benchmark/benchmark.h>

#include "tests/table_session.hpp"

namespace {

using namespace imulab;

void turntable_procedure(benchmark::State& state) {
  const TableObservations plan = planned_observations(zhang_steps(), 0.05);
  const TableMotion motion(plan, table_of(2 * unit::arcsec), table_site());
  const SensorModel truth = drawn_unit(1);
  const RawNoise noise{raw_density(table_accel_noise, truth.accel.matrix), raw_density(table_gyro_noise, truth.gyro.matrix)};
  TurntableSettings settings;
  settings.terms = linear_terms();
  const TurntableEstimator estimator(motion, truth, noise, settings);
  const Eigen::VectorXd nominal = motion.nominal(), sigma = motion.sigma();
  const Eigen::VectorXd noise_sigma = noise_covariance(motion, noise.accel, noise.gyro).diagonal().cwiseSqrt();
  const RandomStream table(1, "table"), white(1, "noise");
  std::uint64_t run = 0;
  const auto drawn = [&](const RandomStream& draws, const Eigen::VectorXd& s) {
    Eigen::VectorXd v(s.size());
    draws.normals(run * static_cast<std::uint64_t>(s.size()), {v.data(), static_cast<std::size_t>(v.size())});
    return Eigen::VectorXd(v.cwiseProduct(s));
  };
  for (auto _ : state) {
    const Eigen::VectorXd seen = readings(motion, truth, motion.truth(nominal + drawn(table, sigma))) + drawn(white, noise_sigma);
    benchmark::DoNotOptimize(estimator.estimate(state.range(0) == 0 ? seen : estimator.linearised(seen)));
    ++run;
  }
  state.SetItemsProcessed(state.iterations());
}

}  // namespace

BENCHMARK(turntable_procedure)->ArgName("second_order")->Arg(0)->Arg(1);
