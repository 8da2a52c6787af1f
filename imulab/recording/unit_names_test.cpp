#include "imulab/recording/unit_names.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

TEST(UnitNames, SpellingsOfAUnitHaveItsName) {
  for (const char* text : {"deg/s", "dps", "°/s", "degrees/sec", "DEG/S"}) EXPECT_EQ(unit_name(text, Quantity::gyro, false), "deg/s") << text;
  for (const char* text : {"mdps", "mdeg/s"}) EXPECT_EQ(unit_name(text, Quantity::gyro, false), "mdeg/s") << text;
  for (const char* text : {"m/s²", "m/s^2", "m/s2", "m/s/s"}) EXPECT_EQ(unit_name(text, Quantity::accel, false), "m/s^2") << text;
  EXPECT_EQ(unit_name("µg", Quantity::accel, false), "ug");
  EXPECT_EQ(unit_name("°", Quantity::gyro, true), "deg");
  EXPECT_EQ(unit_name("count", Quantity::gyro, true), "count");
  for (const char* text : {"", "mGal", "deg", "furlong", "m/s"}) EXPECT_EQ(unit_name(text, Quantity::accel, false), "") << text;
  for (const bool increment : {false, true})
    for (const Quantity quantity : {Quantity::gyro, Quantity::accel, Quantity::temperature, Quantity::time})
      for (const std::string_view name : unit_names(quantity, increment)) EXPECT_EQ(unit_name(name, quantity, increment), name);
}

}  // namespace
}  // namespace imulab
