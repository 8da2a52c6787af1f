#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

using ::testing::Contains;

Recording any_recording(std::size_t n) {
  Recording r;
  r.name = "recording.csv";
  r.interval_s = 0.01;
  r.gyro_increment = true;
  for (std::size_t i = 0; i < n; ++i) {
    r.time_ns.push_back(static_cast<std::int64_t>(i) * 10'000'000);
    for (std::size_t k = 0; k < 3; ++k) {
      r.gyro[k].push_back(RandomStream(2, k).normal(i) + (i % 50 == 20 + k ? 100 : 0));
      r.accel[k].push_back(RandomStream(2, 3 + k).normal(i));
      r.gyro_temperature[k].push_back(i % 40 == 7 ? 80 : 20 + 0.1 * static_cast<double>(i));
    }
    if (i % 30 == 11) r.saturated.push_back(i);
  }
  return r;
}

Recording part(const Recording& whole, std::size_t begin, std::size_t end) {
  Recording r = whole;
  const auto cut = [=](auto& column) {
    if (!column.empty()) column.assign(column.begin() + static_cast<std::ptrdiff_t>(begin), column.begin() + static_cast<std::ptrdiff_t>(end));
  };
  cut(r.time_ns);
  for (auto* triad : {&r.gyro, &r.accel, &r.gyro_temperature})
    for (auto& column : *triad) cut(column);
  r.saturated.clear();
  for (const std::size_t i : whole.saturated)
    if (i >= begin && i < end) r.saturated.push_back(i - begin);
  return r;
}

TEST(Compensator, PiecesGiveWhatTheWholeGives) {
  SensorModel model;
  model.gyro.matrix << 1.1, 0.02, 0.03, -0.01, 0.9, 0.02, 0.01, 0.03, 1.2;
  model.gyro.temperature = ThermalReading{"degC", 25, {0, 70}};
  model.gyro.thermal(1, 1) = 0.01;
  model.accel.cubic << 1e-3, 2e-3, 3e-3;
  model.gyro.raw_unit = "rad/s";
  Recording recording = any_recording(400);
  recording.gyro_unit = "rad/s";
  for (const Outliers outliers : {Outliers::keep, Outliers::reject}) {
    const CompensatedRecording whole = compensate(model, recording, outliers);
    if (outliers == Outliers::reject) {
      EXPECT_THAT(whole.replaced, Contains(320));  // a spike after the noise is known
    }
    for (const std::size_t size : {1, 2, 3, 7, 400}) {
      Compensator compensator(model, outliers);
      std::size_t at = 0;
      const auto expect_next = [&](const CompensatedRecording& out) {
        const std::size_t end = at + out.recording.size();
        const Recording expected = part(whole.recording, at, end);
        EXPECT_EQ(out.recording.time_ns, expected.time_ns);
        EXPECT_EQ(out.recording.gyro, expected.gyro);
        EXPECT_EQ(out.recording.accel, expected.accel);
        EXPECT_EQ(out.recording.saturated, expected.saturated);
        for (std::size_t i = at; i < end; ++i) {
          const auto marked = [](const std::vector<std::size_t>& list, std::size_t k) { return std::count(list.begin(), list.end(), k); };
          EXPECT_EQ(marked(out.replaced, i - at), marked(whole.replaced, i));
          EXPECT_EQ(marked(out.out_of_range, i - at), marked(whole.out_of_range, i));
        }
        at = end;
      };
      for (std::size_t i = 0; i < 400; i += size) {
        expect_next(compensator.next(part(recording, i, std::min<std::size_t>(i + size, 400))));
        const std::size_t taken = std::min<std::size_t>(i + size, 400);
        EXPECT_EQ(at, outliers == Outliers::keep ? taken : taken - std::min<std::size_t>(taken, 2));
      }
      expect_next(compensator.rest());
      EXPECT_EQ(at, 400u);
    }
  }
}

TEST(Compensator, NothingTakenNothingGiven) {
  SensorModel model;
  model.gyro.raw_unit = "rad/s";
  EXPECT_EQ(Compensator(model, Outliers::reject).rest().recording.size(), 0u);
}

}  // namespace
}  // namespace imulab
