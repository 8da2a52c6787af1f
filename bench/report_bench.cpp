// From a calibration and its recording in memory to the page. Target: a day at 200 Hz in 3 s.
#include "imulab/procedure.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/report/calibration_page.hpp"
#include "imulab/rests.hpp"
#include "imulab/simulate.hpp"

#include <benchmark/benchmark.h>

#include "tests/calibration_input.hpp"

namespace {

using namespace imulab;

/// The samples of a handheld session again and again, for a day.
Recording long_recording(const Recording& part, std::size_t samples) {
  Recording r = part;
  r.interval_s = 0.005;
  r.time_ns.resize(samples);
  for (std::size_t i = 0; i < samples; ++i) r.time_ns[i] = static_cast<std::int64_t>(i) * 5'000'000;
  for (auto* triad : {&r.gyro, &r.accel})
    for (auto& column : *triad) {
      const std::vector<double> once = column;
      column.resize(samples);
      for (std::size_t i = 0; i < samples; ++i) column[i] = once[i % once.size()];
    }
  return r;
}

void calibration_page_of_a_day(benchmark::State& state) {
  const Session session = hand_held_procedure({}, 1);
  const Recording part = simulate_recording(session, session.recordings.front(), draw_truth(session, 1), 1);
  Session without_steps = session;
  without_steps.steps.clear();
  Calibration calibration = calibrated("handheld", part, rests_of(part, without_steps).ranges, {}, session.site);
  const Recording day = long_recording(part, 24 * 3600 * 200);
  calibration.quality.rests.clear();
  for (std::size_t k = 0; k + 1 < 24 * 3600 / 60; ++k)
    calibration.quality.rests.push_back({60.0 * static_cast<double>(k), 60.0 * static_cast<double>(k) + 50, 1, true});
  for (auto _ : state) {
    CalibrationReport report{.result = {.calibration = calibration}, .session = session};
    report.recordings.push_back(evidence_of(calibration, session, day, 1));
    benchmark::DoNotOptimize(calibration_page(report));
  }
}
BENCHMARK(calibration_page_of_a_day)->Unit(benchmark::kMillisecond);

}  // namespace
