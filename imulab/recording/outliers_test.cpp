// Spikes added to noise are replaced in the readings that have them; noise, a step and a pulse are not. The filter itself has tests of its own.
#include "imulab/recording/outliers.hpp"

#include "imulab/core/random.hpp"

#include <gmock/gmock.h>

#include <set>

namespace imulab {
namespace {

constexpr std::size_t log_samples = 20000;

Recording noise_with(const std::set<std::size_t>& spikes, double size, double step_at_middle = 0) {
  std::vector<double> t(log_samples);
  std::array<Columns3, 2> triads;
  for (std::size_t k = 0; k < 6; ++k) {
    std::vector<double> column(log_samples);
    RandomStream(7, k).normals(0, column);
    for (std::size_t i = 0; i < log_samples; ++i) {
      t[i] = 0.01 * static_cast<double>(i + 1);
      if (k == 4 && spikes.contains(i)) column[i] += size;
      if (i >= log_samples / 2) column[i] += step_at_middle;
    }
    triads[k / 3][k % 3] = column;
  }
  return make_recording(t, triads[0], triads[1], {.interval_s = 0.01});
}

TEST(Outliers, AreThePlacesOfTheSpikes) {
  const std::set<std::size_t> spikes{500, 501, 7000, 12345};
  const std::vector<ReplacedReading> found = outliers_of(noise_with(spikes, 100));
  EXPECT_THAT(samples_of(found), testing::ElementsAreArray(spikes));
  for (const ReplacedReading& r : found) {
    EXPECT_EQ(r.column, 4u);
    EXPECT_LT(std::abs(r.value), 5) << "between its neighbors";
  }
}

TEST(Outliers, NoiseAStepAPulseAndFrequentSpikesAreNone) {
  EXPECT_TRUE(outliers_of(noise_with({}, 0)).empty());
  EXPECT_TRUE(outliers_of(noise_with({}, 0, 100)).empty());
  EXPECT_TRUE(outliers_of(noise_with({300, 301, 302, 303}, 100)).empty());
  std::set<std::size_t> many;
  for (std::size_t i = 100; i < log_samples; i += 100) many.insert(i);
  EXPECT_TRUE(outliers_of(noise_with(many, 100)).empty()) << "1 % is the sensor's noise";
}

TEST(Outliers, ATriadMayBeAbsent) {
  Recording r = noise_with({500}, 100);
  for (std::vector<double>& column : r.gyro) column.clear();
  EXPECT_THAT(samples_of(outliers_of(r)), testing::ElementsAre(500));
}

}  // namespace
}  // namespace imulab
