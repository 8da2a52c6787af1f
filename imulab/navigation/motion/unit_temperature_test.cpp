#include "imulab/navigation/motion/mission.hpp"

#include <gtest/gtest.h>

namespace imulab::motion {
namespace {

TEST(UnitTemperature, RunsStraightBetweenItsPoints) {
  const UnitTemperature unit{{10, 20, 60}, {20, 30, -10}, {}, {}};
  EXPECT_DOUBLE_EQ(unit.at(0), 20);
  EXPECT_DOUBLE_EQ(unit.at(10), 20);
  EXPECT_DOUBLE_EQ(unit.at(15), 25);
  EXPECT_DOUBLE_EQ(unit.at(20), 30);
  EXPECT_DOUBLE_EQ(unit.at(50), 0);
  EXPECT_DOUBLE_EQ(unit.at(60), -10);
  EXPECT_DOUBLE_EQ(unit.at(100), -10);
  EXPECT_DOUBLE_EQ((UnitTemperature{{3}, {40}, {}, {}}.at(2)), 40);
}

}  // namespace
}  // namespace imulab::motion
