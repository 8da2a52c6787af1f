#include "imulab/estimate/kernel/clocks.hpp"

#include "imulab/coefficient.hpp"

#include <gmock/gmock.h>

namespace imulab::kernel {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Returns the quality of a calibration with a gyro scale uncertainty of 10 ppm.
Quality doubted(const ClockGain& gain) {
  Calibration c;
  c.estimated = {coefficient_index("gyro.matrix.xx")};
  c.covariance = 1e-10 * Eigen::MatrixXd::Identity(1, 1);
  doubt_clock(c, gain);
  return c.quality;
}

TEST(DoubtClock, LostSamplesAreDoubtfulAndASlowClockIsNot) {
  for (const bool increments : {false, true}) {
    EXPECT_THAT(doubted({"a.csv", {.rate = -1e-4, .sigma = 1e-6}, increments}).findings.reasons(), IsEmpty());
    const Quality lost = doubted({"a.csv", {.rate = -1e-4, .sigma = 5e-5, .lost_s = 0.3}, increments});
    EXPECT_THAT(lost.findings.reasons(), Contains(HasSubstr("samples are lost without a trace in the stamps: turns come 0.3 s earlier at once")));
    EXPECT_EQ(lost.cause, "lost samples");
    EXPECT_THAT(doubted({"a.csv", {.rate = -1e-4, .sigma = 5e-5, .lost_s = 0.05}, increments}).findings.reasons(),
                IsEmpty());  // as steps are declared
  }
  // Increments are too small by more than any clock is slow; rates refer to the recording's own seconds.
  EXPECT_THAT(doubted({"a.csv", {.rate = -1e-3, .sigma = 1e-6}, true}).findings.reasons(), Contains(HasSubstr("its clock loses 1000 ppm")));
  EXPECT_THAT(doubted({"a.csv", {.rate = -1e-3, .sigma = 1e-6}, false}).findings.reasons(), IsEmpty());
}

}  // namespace
}  // namespace imulab::kernel
