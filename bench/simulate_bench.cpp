// Samples per second of a simulation, noise included. Targets on one core: 5 million a second with white noise, 2 million with all terms.
#include "imulab/rig/procedure.hpp"
#include "imulab/simulate/simulate.hpp"

#include <benchmark/benchmark.h>
#include <oneapi/tbb/global_control.h>

namespace {

using namespace imulab;

void simulate(benchmark::State& state, const HandHeldOptions& options, NoiseTerms noise = NoiseTerms::white) {
  const oneapi::tbb::global_control one_thread(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  Session session = hand_held_procedure(options, 1);
  session.imu.grade = "tactical";  // all terms: Q as well
  session.imu.noise = noise;
  const Truth truth = draw_truth(session, 1);
  std::size_t samples = 0;
  for (auto _ : state) {
    const Recording recording = simulate_recording(session, session.recordings.front(), truth, 1);
    benchmark::DoNotOptimize(recording.gyro[0].data());
    samples += recording.size();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(samples));
}

void rests(benchmark::State& state) { simulate(state, {.poses = 1, .first_rest = 1000}); }
void moves(benchmark::State& state) { simulate(state, {.poses = 500, .first_rest = 0.01, .rest = 0.01}); }

void rests_full(benchmark::State& state) { simulate(state, {.poses = 1, .first_rest = 1000}, NoiseTerms::full); }
void moves_full(benchmark::State& state) { simulate(state, {.poses = 500, .first_rest = 0.01, .rest = 0.01}, NoiseTerms::full); }

BENCHMARK(rests);
BENCHMARK(moves);
BENCHMARK(rests_full);
BENCHMARK(moves_full);

}  // namespace
