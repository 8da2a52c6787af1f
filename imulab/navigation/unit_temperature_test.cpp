#include "imulab/navigation/unit_temperature.hpp"

#include "imulab/core/error.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

TEST(UnitTemperature, RunsStraightBetweenItsPoints) {
  const TemperatureCourse course{{10, 20, 60}, {20, 30, -10}};
  EXPECT_DOUBLE_EQ(course.at(0), 20);
  EXPECT_DOUBLE_EQ(course.at(10), 20);
  EXPECT_DOUBLE_EQ(course.at(15), 25);
  EXPECT_DOUBLE_EQ(course.at(20), 30);
  EXPECT_DOUBLE_EQ(course.at(50), 0);
  EXPECT_DOUBLE_EQ(course.at(60), -10);
  EXPECT_DOUBLE_EQ(course.at(100), -10);
  EXPECT_DOUBLE_EQ((TemperatureCourse{{3}, {40}}.at(2)), 40);
}

TEST(UnitTemperature, IsReadInTheSensorsUnit) {
  ThermalSource source;
  EXPECT_DOUBLE_EQ(thermal_reading(source, 31), 31);
  source.unit = "K";
  EXPECT_DOUBLE_EQ(thermal_reading(source, 31), 304.15);
  source.unit = "raw";
  EXPECT_THROW(thermal_reading(source, 31), Error);
  source.at_25_degC = 5000, source.per_K = -0.5;  // a resonance
  EXPECT_DOUBLE_EQ(thermal_reading(source, 31), 4997);
}

}  // namespace
}  // namespace imulab
