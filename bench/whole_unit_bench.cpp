// The whole-unit method on Dai's procedure: 303 points, 151,500 samples. Target on one core: three recordings read from CSV and calibrated, with the
// choice of terms, within 0.5 s.
#include "imulab/estimate/whole_unit/whole_unit.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/parallel.hpp"
#include "imulab/procedure.hpp"
#include "imulab/simulate.hpp"

#include <benchmark/benchmark.h>

#include <filesystem>
#include <random>

namespace {

using namespace imulab;

struct Example {
  Session session;
  std::vector<Recording> recordings;
};

const Example& example() {
  static const Example e = [] {
    Example made;
    made.session = dai_unit_procedure({});
    const Truth truth = draw_truth(made.session, 1);
    for (const RecordingSource& source : made.session.recordings)
      made.recordings.push_back(simulate_recording(made.session, source, truth, 1, draw_rig_errors(made.session, source, 1)));
    return made;
  }();
  return e;
}

void whole_unit_estimate(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(whole_unit::calibrate({example().session, example().recordings}));
}
BENCHMARK(whole_unit_estimate)->Unit(benchmark::kMillisecond);

void whole_unit_from_files(benchmark::State& state) {
  const ThreadLimit one_core(1);
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("imulab-bench-" + std::to_string(std::random_device{}()));
  std::filesystem::create_directories(folder);
  for (const Recording& recording : example().recordings) write_recording(folder / recording.name, recording);
  Session session = example().session;
  session.file = (folder / "session.toml").string();
  for (auto _ : state) {
    std::vector<Recording> recordings;
    for (const RecordingSource& source : session.recordings) recordings.push_back(read_recording(session, source).recording);
    benchmark::DoNotOptimize(whole_unit::calibrate({session, recordings}));
  }
  std::filesystem::remove_all(folder);
}
BENCHMARK(whole_unit_from_files)->Unit(benchmark::kMillisecond);

}  // namespace
