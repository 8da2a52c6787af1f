// The grammar of columns' names: words, axis, unit and index, with brackets of both kinds.
#include "imulab/inspection/names.hpp"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <string_view>
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

/// Headers as recorders write them: of each column t (time), n (number of the sample), T, g or a, with its axis; . for all else.
TEST(Names, OfTheHeadersOfRecorders) {
  struct Header {
    const char *columns, *right;
  };
  for (const Header& header : std::vector<Header>{
           {"Time (s);X (m/s^2);Y (m/s^2);Z (rad/s)", "t .x .y .z"},
           {"cts;date;Accelerometer (z) [m/s2];Accelerometer (x) [m/s2];Gyroscope (y) [rad/s]", ". . az ax gy"},
           {"#timestamp [ns];w_RS_S_x [rad s^-1];w_RS_S_z [rad s^-1];a_RS_S_x [m s^-2];a_RS_S_y [m s^-2]", "t gx gz ax ay"},
           {"%time;field.header.seq;field.header.stamp;field.angular_velocity.x;field.linear_acceleration.z", "t n t gx az"},
           {"ACCELEROMETER X (m/s\u00b2);GRAVITY Y (m/s\u00b2);GYROSCOPE Z (rad/s);Time since start in ms", "ax .y gz t"},
           {"Shimmer_B4_Timestamp_Unix_CAL;Shimmer_B4_Accel_LN_X_CAL;Shimmer_B4_Gyro_Z_CAL", "t ax gz"},
           {"Time;Static/Acceleration/X;Static/Angular Velocity/Y", "t ax gy"},
           {"sensor;timestamp_ns;x;y;z", ". t .x .y .z"},
           {"t;gravity.x;rotationRate.y;userAcceleration.z", "t .x gy az"},
           {"t;gx;gy;gz;ax;ay;az;temperature", "t gx gy gz ax ay az T"},
           {"t_s;gx_dps;gy_dps;gz_dps;ax_mps2;ay_mps2;az_mps2", "t gx gy gz ax ay az"},
           {"time;acce.x;acce.y;gyro.x;gyro_uncalib.z", "t ax ay gx gz"},
           {"time;linear_acceleration.x [m s^-2];angular_velocity.z [rad s^-1]", "t ax gz"},
           {"time;seconds_elapsed;z;y;x", "t t .z .y .x"},
           {"t_ms;timestamp;ax;gz", "t t ax gz"},
       }) {
    std::string found;
    std::istringstream names(header.columns);
    for (std::string name; std::getline(names, name, ';');) {
      const NameHint hint = hint_of(name);
      constexpr std::string_view letters = ".ttngaT.";  // by Role
      found += found.empty() ? "" : " ";
      found += letters[static_cast<std::size_t>(hint.role)];
      if (hint.axis >= 0) found += "xyz"[hint.axis];
    }
    EXPECT_EQ(found, header.right) << header.columns;
  }
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
