#include "imulab/grade.hpp"

#include "imulab/error.hpp"
#include "imulab/model/published_grades.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

TEST(Grade, NavigationGradesLieInsideThePublishedRanges) {
  for (const PublishedGrade& published : published_grades()) {
    const Grade& g = grade(published.name);
    const auto inside = [&](double value, const std::array<double, 2>& range) {
      EXPECT_GE(value, range[0] * (1 - 1e-12)) << published.name;  // 0.01 deg/h is the end of the range: rounding
      EXPECT_LE(value, range[1] * (1 + 1e-12)) << published.name;
    };
    inside(g.gyro_bias, published.gyro_bias);
    inside(g.accel_bias, published.accel_bias);
    inside(g.gyro_misalignment, published.misalignment);
    inside(g.accel_misalignment, published.misalignment);
    inside(g.gyro_scale, published.scale);
    inside(g.accel_scale, published.scale);
  }
}

TEST(Grade, TheCatalogueIsThatOfThePaper) {
  // Xu 2024 tables 1 and 2 in their own units: nmi/h, deg/h, ug, arcsec, ppm.
  const PublishedGrade& navigation = published_grades()[1];
  EXPECT_DOUBLE_EQ(navigation.position_rate[1] * unit::hour / unit::nmi, 2);
  EXPECT_DOUBLE_EQ(navigation.gyro_bias[1] / unit::deg_per_h, 1);
  EXPECT_DOUBLE_EQ(navigation.accel_bias[0] / unit::ug, 50);
  EXPECT_DOUBLE_EQ(navigation.misalignment[1] / unit::arcsec, 30);
  EXPECT_DOUBLE_EQ(published_grades()[2].scale[1] / unit::ppm, 500);
  EXPECT_DOUBLE_EQ(published_grades()[0].position_rate[1] * unit::hour, 30);
  EXPECT_DOUBLE_EQ(airliner_system("LTN-101").position_rate * unit::hour / unit::nmi, 0.8);
  EXPECT_DOUBLE_EQ(airliner_system("Laseref").gyro_bias / unit::deg_per_h, 0.1);
  EXPECT_THROW(airliner_system("LTN-72"), Error);
}

TEST(Grade, AnUnknownOneListsTheKnown) {
  try {
    grade("perfect");
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("strategic, navigation, tactical, mems, mems-30g"));
  }
}

}  // namespace
}  // namespace imulab
