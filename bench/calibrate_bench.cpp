// From columns in memory to a calibration. Targets: rest detection 10 million samples/s; each method on a nine-minute session at 100 Hz (like the
// public handheld records) in 40 ms, so that loading, not the estimate, dominates the time of the command.
#include "imulab/procedure.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/simulate.hpp"

#include <benchmark/benchmark.h>

#include "tests/calibration_input.hpp"

namespace {

using namespace imulab;

struct Example {
  Session session;
  Recording recording;
  std::vector<Range> rests;
};

const Example& example() {
  static const Example e = [] {
    HandHeldOptions options;
    options.poses = 40;
    options.first_rest = 50;
    options.rest = 9;
    options.move = 3;
    Example made;
    made.session = hand_held_procedure(options, 1);
    made.recording = simulate_recording(made.session, made.session.recordings.front(), draw_truth(made.session, 1), 1);
    made.session.steps.clear();
    made.rests = rests_of(made.recording, made.session).ranges;
    return made;
  }();
  return e;
}

void rest_detection(benchmark::State& state) {
  const Example& e = example();
  for (auto _ : state) benchmark::DoNotOptimize(detect_rests(e.recording));
  state.counters["samples"] = benchmark::Counter(static_cast<double>(e.recording.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(rest_detection)->Unit(benchmark::kMillisecond);

void handheld(benchmark::State& state) {
  const Example& e = example();
  for (auto _ : state) benchmark::DoNotOptimize(calibrated("handheld", e.recording, e.rests, {}, e.session.site));
}
BENCHMARK(handheld)->Unit(benchmark::kMillisecond);

void static_method(benchmark::State& state) {
  const Example& e = example();
  for (auto _ : state) benchmark::DoNotOptimize(calibrated("static", e.recording, e.rests, {}, e.session.site));
}
BENCHMARK(static_method)->Name("static")->Unit(benchmark::kMillisecond);

}  // namespace
