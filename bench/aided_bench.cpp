// Aided navigation, 50 states, an IMU at 100 Hz and a receiver at 1 Hz: one pass of the filter, one with the smoother. Target: an hour in 1 s a pass.
#include "imulab/navigation/aided/filter.hpp"
#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/aided/start.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/simulate/simulate_aid.hpp"
#include "imulab/units.hpp"

#include <benchmark/benchmark.h>

namespace {

using namespace imulab;

/// Ten minutes in a city.
struct AidedDrive {
  AidedDrive() {
    std::vector<motion::Segment> parts{motion::accelerate(10, 5)};
    for (int k = 0; k < 30; ++k)
      parts.insert(parts.end(),
                   {motion::turn((k % 3 == 0 ? -90 : 90) * unit::deg, 0.25, 1.5), motion::straight(6), motion::accelerate(k % 2 == 0 ? -5 : 5, 4)});
    const motion::Trajectory trajectory = motion::flight({48 * unit::deg, 0.2, 500, 0, 0}, parts, {.banks = false});
    motion = motion::nominal_motion(trajectory, 0.01), recording = aided::ideal_readings(motion);
    aids = {simulate_aid({.position_sigma = 1.5, .velocity_sigma = 0.05, .correlation = 60}, 0, trajectory, 1).aid};
  }
  motion::NominalMotion motion;
  Recording recording;
  std::vector<Aid> aids;
};

void aided_pass(benchmark::State& state, bool smoothed) {
  const AidedDrive drive;
  const aided::Problem problem = aided::make_problem(drive.recording, aided::sensor_priors({}, {}), drive.aids, {});
  const aided::FilterStart start = aided::start_near(problem, drive.motion.states.front());
  for (auto _ : state) {
    aided::FilterPass pass = aided::filter(problem, start, {.keep = smoothed});
    if (smoothed)
      benchmark::DoNotOptimize(aided::smooth(problem, std::move(pass)));
    else
      benchmark::DoNotOptimize(pass);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(drive.recording.size()));
}
BENCHMARK_CAPTURE(aided_pass, filtered, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(aided_pass, smoothed, true)->Unit(benchmark::kMillisecond);

}  // namespace
