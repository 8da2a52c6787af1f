#include "imulab/results/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

NoiseCoefficient known_to(double percent) { return {1, 0.01 * percent, 0.9, 1.1, true}; }

NoiseAxis axis_of(const char* name, const NoiseCoefficient& N, const NoiseCoefficient& B) {
  NoiseAxis axis;
  axis.name = name, axis.unit = "count";
  axis.fit.emplace();
  axis.fit->N = N, axis.fit->B = B, axis.fit->K = undetermined_below(1);
  return axis;
}

TEST(NoiseHeadline, SaysWhatIsKnownAndWhatIsOnlyBounded) {
  const NoiseCoefficient open = undetermined_below(1);
  NoiseAnalysis analysis;
  analysis.axes = {axis_of("gyro.x", known_to(0.1), open), axis_of("gyro.y", known_to(0.2), open), axis_of("gyro.z", known_to(0.1), open)};
  EXPECT_EQ(noise_headline(analysis), "gyro u(N) 0.2 %, B and K only bounded");
  analysis.axes[1].fit->B = known_to(12);
  EXPECT_EQ(noise_headline(analysis), "gyro u(N) 0.2 %, u(B) of y 12 %, K only bounded");
  analysis.axes.push_back(axis_of("accel.x", open, open));
  EXPECT_EQ(noise_headline(analysis), "gyro u(N) 0.2 %, u(B) of y 12 %, K only bounded; accelerometer N, B and K only bounded");
  analysis.axes = {axis_of("gyro.x", known_to(0.1), known_to(3)),
                   NoiseAxis{.name = "gyro.y", .unit = "rad/s", .deviation = {}, .fit = {}, .problem = ""}};
  analysis.axes[0].fit->K = known_to(8.5);
  EXPECT_EQ(noise_headline(analysis), "gyro u(N) 0.1 %, u(B) 3 %, u(K) 8.5 %; no noise on gyro.y");
  analysis.axes.erase(analysis.axes.begin());
  EXPECT_EQ(noise_headline(analysis), "no noise on any axis");
  EXPECT_EQ(noise_headline(NoiseAnalysis{}), "no noise on any axis");
}

}  // namespace
}  // namespace imulab
