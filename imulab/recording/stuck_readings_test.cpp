#include "imulab/recording/stuck_readings.hpp"

#include "imulab/core/random.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace imulab {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A turn to and fro with noise, in steps.
std::vector<double> turning(double noise, double step) {
  const RandomStream random(3, 1);
  std::vector<double> out;
  for (int i = 0; i < 5000; ++i) {
    const double x = std::sin(0.02 * i) + noise * random.normal(static_cast<std::uint64_t>(i));
    out.push_back(step > 0 ? step * std::round(x / step) : x);
  }
  return out;
}

void hold(std::vector<double>& readings, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin + 1; i < end; ++i) readings[i] = readings[begin];
}

TEST(StuckReadings, AreFoundAmongReadingsThatChange) {
  for (const double step : {0.0, 1e-4}) {
    std::vector<double> readings = turning(1e-3, step);
    EXPECT_THAT(stuck_stretches(readings), IsEmpty()) << step;
    hold(readings, 800, 808), hold(readings, 4100, 4106);
    EXPECT_THAT(stuck_stretches(readings), ElementsAre(Range{800, 808}, Range{4100, 4106})) << step;
    EXPECT_EQ(said_of_stuck(stuck_stretches(readings)), "repeats one reading for up to 8 samples, 2 times, while those before and after change");
  }
}

TEST(StuckReadings, AreNotFoundInCoarseOnesAtALimitOrInAnIdealUnit) {
  EXPECT_THAT(stuck_stretches(turning(0, 0.05)), IsEmpty()) << "a slow turn stays within a step";
  std::vector<double> clipped = turning(1e-3, 0), ideal = turning(0, 0);
  for (double& x : clipped) x = std::min(x, 0.97);
  EXPECT_THAT(stuck_stretches(clipped), IsEmpty());
  hold(ideal, 1000, 1600);
  EXPECT_THAT(stuck_stretches(ideal), IsEmpty()) << "a rest";
  EXPECT_THAT(stuck_stretches({}), IsEmpty());
}

}  // namespace
}  // namespace imulab
