#include "imulab/model/grade.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

// Xu 2024 table 1.
struct Row {
  const char* name;
  double gyro_bias[2], accel_bias[2], misalignment[2], scale[2];  // deg/h, ug, arcsec, ppm
};

TEST(Grade, NavigationGradesLieInsideThePublishedRanges) {
  for (const Row& row : {Row{"strategic", {1e-4, 0.01}, {1, 50}, {0, 1}, {0, 10}}, Row{"navigation", {0.01, 1}, {50, 100}, {1, 30}, {10, 50}},
                         Row{"tactical", {1, 10}, {100, 1000}, {30, 100}, {50, 500}}}) {
    const Grade& g = grade(row.name);
    const auto inside = [&](double value, const double(&range)[2], double unit) {
      EXPECT_GE(value / unit, range[0] * (1 - 1e-12)) << row.name;  // 0.01 deg/h is the range's end: rounding
      EXPECT_LE(value / unit, range[1] * (1 + 1e-12)) << row.name;
    };
    inside(g.gyro_bias, row.gyro_bias, unit::deg_per_h);
    inside(g.accel_bias, row.accel_bias, unit::ug);
    inside(g.gyro_misalignment, row.misalignment, unit::arcsec);
    inside(g.accel_misalignment, row.misalignment, unit::arcsec);
    inside(g.gyro_scale, row.scale, unit::ppm);
    inside(g.accel_scale, row.scale, unit::ppm);
  }
}

TEST(Grade, AnUnknownOneListsTheKnown) {
  try {
    grade("perfect");
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("strategic, navigation, tactical, mems"));
  }
}

}  // namespace
}  // namespace imulab
