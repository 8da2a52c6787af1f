// The grammar of columns' names: words, axis, unit and index, with brackets of both kinds.
#include "imulab/inspection/names.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace imulab::inspection {
namespace {

struct Named {
  const char* name;
  Role role;
  int axis;
  const char* unit;
};

TEST(Names, AreParsedByOneGrammar) {
  for (const Named& right : std::vector<Named>{
           {"Accelerometer (z) [m/s2]", Role::accel, 2, "m/s^2"},
           {"Accelerometer (y, m/s2)", Role::accel, 1, "m/s^2"},
           {"Gyroscope [x (rad/s)]", Role::gyro, 0, "rad/s"},
           {"Gyroscope (z)", Role::gyro, 2, ""},
           {"Acceleration x (m/(s^2))", Role::accel, 0, "m/s^2"},
           {"Accel_X m/(s^2)", Role::accel, 0, "m/s^2"},
           {"Gyro y (deg/s", Role::gyro, 1, "deg/s"},
           {"x (gyroscope)", Role::gyro, 0, ""},
           {"acc_x [m/s^2]", Role::accel, 0, "m/s^2"},
           {"GyroY(dps)", Role::gyro, 1, "deg/s"},
           {"ax_g", Role::accel, 0, "g"},
           {"acc_z_mg", Role::accel, 2, "mg"},
           {"x_g", Role::gyro, 0, ""},
           {"gx_dps", Role::gyro, 0, "deg/s"},
           {"gyro_rad[2]", Role::gyro, 2, ""},
           {"gyro.3", Role::gyro, 2, ""},
           {"rate_x_deg_per_s", Role::gyro, 0, "deg/s"},
           {"/synced/acce.2", Role::accel, 1, ""},
           {"timestamp_us", Role::time, -1, "us"},
           {"Temps (s)", Role::time, -1, "s"},
           {"mag (x) [uT]", Role::other, 0, ""},
       }) {
    const NameHint hint = hint_of(right.name);
    EXPECT_EQ(hint.role, right.role) << right.name;
    EXPECT_EQ(hint.axis, right.axis) << right.name;
    EXPECT_EQ(hint.unit, right.unit) << right.name;
  }
  EXPECT_EQ(hint_of("Temperature (F)").unknown, "F");
  EXPECT_EQ(hint_of("acc x (uncalibrated) [g]").unknown, "");
}

TEST(Names, TellSensorsApart) {
  const auto sensor = [](const char* name) { return hint_of(name).sensor; };
  EXPECT_EQ(sensor("gyro (x) [rad/s]"), sensor("gyro (z) [rad/s]"));
  EXPECT_EQ(sensor("gx_dps"), sensor("gz_dps"));
  EXPECT_EQ(sensor("gyro.1"), sensor("gyro.3"));
  EXPECT_NE(sensor("gyro_uncalib.x"), sensor("gyro.x"));
  EXPECT_NE(sensor("gyro x (uncalibrated)"), sensor("gyro x (calibrated)"));
  EXPECT_NE(sensor("x1"), sensor("x2"));
}

TEST(Names, AnyTextIsAName) {
  for (const char* name : {"", "(", ")", "[[[", "])", "()", "(x", "a)(b]", "m/(", "((((x))))", "x,y", "[,;]", "\xff(\xfe"}) (void)hint_of(name);
  EXPECT_EQ(hint_of("((((x))))").axis, 0);
}

}  // namespace
}  // namespace imulab::inspection
