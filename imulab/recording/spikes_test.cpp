// Spikes added to noise: all of them go, and nothing else does.
#include "imulab/recording/spikes.hpp"

#include "imulab/core/random.hpp"
#include "imulab/recording.hpp"

#include <gmock/gmock.h>

#include <set>

namespace imulab {
namespace {

constexpr std::size_t log_samples = 20000;

Recording noise_with(const std::set<std::size_t>& spikes, double size, double step_at_middle = 0) {
  std::vector<double> t(log_samples);
  Columns3 gyro, accel;
  for (std::size_t k = 0; k < 6; ++k) {
    std::vector<double> column(log_samples);
    RandomStream(7, k).normals(0, column);
    for (std::size_t i = 0; i < log_samples; ++i) {
      t[i] = 0.01 * static_cast<double>(i + 1);
      if (k == 4 && spikes.contains(i)) column[i] += i % 2 == 0 ? size : -size;
      if (i >= log_samples / 2) column[i] += step_at_middle;
    }
    (k < 3 ? gyro : accel)[k % 3] = column;
  }
  return make_recording(t, gyro, accel, {.interval_s = 0.01});
}

TEST(Spikes, AreRemovedAndLeaveGaps) {
  const std::set<std::size_t> spikes{500, 501, 7000, 12345};
  Recording r = noise_with(spikes, 100);
  const Recording before = r;
  EXPECT_EQ(remove_spikes(r), spikes.size());
  EXPECT_THAT(r.gaps, testing::ElementsAre(500, 6998, 12342));
  std::vector<std::int64_t> kept;
  for (std::size_t i = 0; i < log_samples; ++i)
    if (!spikes.contains(i)) kept.push_back(before.time_ns[i]);
  EXPECT_EQ(r.time_ns, kept);
  for (const Columns3* triad : {&r.gyro, &r.accel})
    for (const auto& column : *triad) EXPECT_EQ(column.size(), kept.size());
  EXPECT_LT(*std::ranges::max_element(r.accel[1]), 10);
}

TEST(Spikes, NoiseAStepAndAKnockAreNone) {
  Recording quiet = noise_with({}, 0), step = noise_with({}, 0, 100), knock = noise_with({300, 301, 302, 303}, 100);
  EXPECT_EQ(remove_spikes(quiet), 0u);
  EXPECT_EQ(remove_spikes(step), 0u);
  EXPECT_EQ(remove_spikes(knock), 0u) << "four samples are no spike";
  std::set<std::size_t> many;
  for (std::size_t i = 100; i < log_samples; i += 100) many.insert(i);
  Recording often = noise_with(many, 100);
  EXPECT_EQ(remove_spikes(often), 0u) << "1 % is the sensor's noise";
}

}  // namespace
}  // namespace imulab
