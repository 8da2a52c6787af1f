#include "imulab/results/shares.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

TEST(Shares, EverySourceHasAGroupAndTheLargestOfARowItsName) {
  Shares each{{"orthogonality", "gravity", "gyro noise", "accelerometer turn-on", "gyro.cubic", "accel.asymmetry", "undetermined coefficients"},
              Eigen::ArrayXXd(2, 7)};
  each.percent << 0, 97, 1, 1, 0, 1, 0,  // gravity, which a narrow table hid among others
      20, 0, 10, 10, 15, 15, 30;
  EXPECT_EQ(largest_source(each, 0), "gravity");
  const Shares groups = by_group(each);
  EXPECT_EQ(groups.sources.size(), 5u) << "and a name beside them";
  EXPECT_EQ(groups.sources.back(), "others");
  for (Eigen::Index row = 0; row < 2; ++row) EXPECT_NEAR(groups.percent.row(row).sum(), 100, 1e-9);
  EXPECT_EQ(groups_text(each.sources), "rig: orthogonality; site: gravity; noise: gyro noise, accelerometer turn-on; terms: gyro.cubic");
}

}  // namespace
}  // namespace imulab
