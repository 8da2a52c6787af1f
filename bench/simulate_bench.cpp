// Samples per second of a simulation, noise included. Targets on one core: 5 million per second with white noise, 2 million with all terms.
#include "imulab/parallel.hpp"
#include "imulab/procedure.hpp"
#include "imulab/simulate.hpp"

#include <benchmark/benchmark.h>

namespace {

using namespace imulab;

void simulate(benchmark::State& state, Session session, NoiseTerms noise) {
  const ThreadLimit one_thread(1);
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

Session at_rest() { return hand_held_procedure({.poses = 1, .first_rest = 1000}, 1); }
Session moving() { return hand_held_procedure({.poses = 500, .first_rest = 0.01, .rest = 0.01}, 1); }
Session on_a_table() { return zhang_24_procedure({}); }

BENCHMARK_CAPTURE(simulate, rests, at_rest(), NoiseTerms::white);
BENCHMARK_CAPTURE(simulate, moves, moving(), NoiseTerms::white);
BENCHMARK_CAPTURE(simulate, turntable, on_a_table(), NoiseTerms::white);
BENCHMARK_CAPTURE(simulate, rests_full, at_rest(), NoiseTerms::full);
BENCHMARK_CAPTURE(simulate, moves_full, moving(), NoiseTerms::full);
BENCHMARK_CAPTURE(simulate, turntable_full, on_a_table(), NoiseTerms::full);

}  // namespace
