// The hybrid method on 25 min at 100 Hz (149,800 samples). Targets on one core: one pass of the filter at least 1 million samples/s; the session read
// from its CSV file and calibrated with all iterations and tests of terms within 1 s.
#include "imulab/estimate/hybrid/filter.hpp"
#include "imulab/estimate/hybrid/hybrid.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/parallel.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/simulate.hpp"

#include <benchmark/benchmark.h>

#include <filesystem>
#include <random>

namespace {

using namespace imulab;

struct Example {
  Session session;
  Recording recording;
  std::vector<Range> rests;
};

const Example& example() {
  static const Example e = [] {
    Example made;
    made.session = cheng_path_procedure({});
    const RecordingSource& source = made.session.recordings.front();
    made.recording = simulate_recording(made.session, source, draw_truth(made.session, 1), 1, draw_rig_errors(made.session, source, 1));
    made.rests = rests_of(made.recording, made.session).ranges;
    return made;
  }();
  return e;
}

void hybrid_one_pass(benchmark::State& state) {
  const Example& e = example();
  const hybrid::Data data{e.recording,
                          in_place::cut_into_blocks(e.recording, e.rests, true).blocks,
                          hybrid::place_of(e.session.site),
                          {Vector3d::Constant(2.9e-7), Vector3d::Constant(5e-5)},
                          {}};
  const hybrid::States states({}, data.place);
  const kernel::Parameters known = states.parameters(Eigen::VectorXd::Zero(states.constants()));
  for (auto _ : state) benchmark::DoNotOptimize(hybrid::filter_pass(data, {data.coarse, data.place}, states, known));
  state.counters["samples"] = benchmark::Counter(static_cast<double>(e.recording.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(hybrid_one_pass)->Unit(benchmark::kMillisecond);

void hybrid_from_file(benchmark::State& state) {
  const ThreadLimit one_core(1);
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("imulab-bench-" + std::to_string(std::random_device{}()));
  std::filesystem::create_directories(folder);
  write_recording(folder / "recording.csv", example().recording);
  Session session = example().session;
  session.file = (folder / "session.toml").string();
  for (auto _ : state) {
    const Recording recording = read_recording(session, session.recordings.front()).recording;
    benchmark::DoNotOptimize(hybrid::calibrate({session, {&recording, 1}}));
  }
  std::filesystem::remove_all(folder);
}
BENCHMARK(hybrid_from_file)->Unit(benchmark::kMillisecond);

}  // namespace
