#include "imulab/calibration.hpp"
#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <utility>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

TEST(Requirement, IsReadInUserUnits) {
  const auto r =
      parse_requirements(" gyro.matrix.off_diagonal <= 5 arcsec,accel.offset<=2.5e1ug , accel.matrix <= 40 ppm, gyro.offset.z <= 1 deg/h ");
  ASSERT_THAT(r, SizeIs(4));
  EXPECT_EQ(r[0].selector, "gyro.matrix.off_diagonal");
  EXPECT_THAT(r[0].coefficients, SizeIs(6));
  EXPECT_DOUBLE_EQ(r[0].limit, 5 * unit::arcsec);
  EXPECT_THAT(r[1].coefficients, SizeIs(3));
  EXPECT_DOUBLE_EQ(r[1].limit, 25e-6 * 9.80665);
  EXPECT_EQ(r[1].unit.name, "ug");
  EXPECT_THAT(r[2].coefficients, SizeIs(9));
  EXPECT_DOUBLE_EQ(r[2].limit, 40e-6);
  EXPECT_EQ(r[3].coefficients, std::vector{coefficient_index("gyro.offset.z")});
}

TEST(Requirement, TakesOtherSpellingsOfUnits) {
  const auto r = parse_requirements("accel.offset <= 5 mGal, gyro.offset <= 2 °/h, gyro.matrix.off_diagonal <= 0.1 mrad, accel.offset.x <= 20 µg");
  EXPECT_DOUBLE_EQ(r[0].limit, 5e-5);
  EXPECT_DOUBLE_EQ(r[1].limit, 2 * unit::deg_per_h);
  EXPECT_EQ(r[1].unit.name, "deg/h");
  EXPECT_DOUBLE_EQ(r[2].limit, 1e-4);
  EXPECT_DOUBLE_EQ(r[3].limit, 20 * unit::ug);
  EXPECT_EQ(to_string(r[3]), "accel.offset.x <= 20 ug");
}

TEST(Requirement, BadTextIsRefused) {
  for (const auto& [text, message] : std::vector<std::pair<const char*, const char*>>{
           {"", "\"\": expected COEFFICIENTS <= NUMBER UNIT, as in \"gyro.matrix.off_diagonal <= 5 arcsec\""},
           {"  ", "\"\": expected COEFFICIENTS <= NUMBER UNIT"},
           {"accel.offset", "\"accel.offset\": expected COEFFICIENTS <= NUMBER UNIT"},
           {"accel.offset < 1 ug", "\"accel.offset < 1 ug\": expected COEFFICIENTS <= NUMBER UNIT"},
           {"accel.offset <= 1 ug,", "\"\": expected COEFFICIENTS <= NUMBER UNIT"},
           {"accel.ofset <= 1 ug", "unknown coefficient \"accel.ofset\"; did you mean accel.offset?"},
           {" <= 1 ug", "unknown coefficient \"\""},
           {"accel.offset <= ", "accel.offset <= : expected a number above 0"},
           {"accel.offset <= ug", "accel.offset <= ug: expected a number above 0"},
           {"accel.offset <= 0 ug", "accel.offset <= 0 ug: expected a number above 0"},
           {"accel.offset <= -1 ug", "accel.offset <= -1 ug: expected a number above 0"},
           {"accel.offset <= nan ug", "accel.offset <= nan ug: expected a number above 0"},
           {"accel.offset <= inf ug", "accel.offset <= inf ug: expected a number above 0"},
           {"accel.offset <= 1e999 ug", "accel.offset <= 1e999 ug: expected a number above 0"},
           {"accel.offset <= 1", "accel.offset <= 1: no unit after the number; expected one of ug, mg, g, m/s^2"},
           {"accel.offset <= 1 arcsec", "accel.offset <= 1 arcsec: \"arcsec\" is no unit of accel.offset; expected one of ug, mg, g, m/s^2"},
           {"gyro.matrix <= 1 mm", "gyro.matrix <= 1 mm: \"mm\" is no unit of gyro.matrix; did you mean ppm?"},
           {"gyro.offset <= 1 deg/h <= 2 deg/h", "\"deg/h <= 2 deg/h\" is no unit of gyro.offset"},
           {"accel.quadratic <= 1 ug", "accel.quadratic: cannot be required; expected coefficients of offset (or bias), matrix or g_sensitivity"},
           {"accel.lever_arm.xx <= 1 mm", "accel.lever_arm.xx: cannot be required"},
           {"gyro.thermal <= 1 deg/h", "gyro.thermal: cannot be required"}}) {
    try {
      parse_requirements(text);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr(message));
    }
  }
}

TEST(Requirement, ADoubtfulResultMeetsNone) {
  Calibration c;
  c.estimated = select_coefficients("accel.offset");
  c.covariance = 1e-12 * Eigen::MatrixXd::Identity(3, 3);
  const Requirement r = parse_requirements("accel.offset <= 1 ug").front();
  c.quality.verdict = Verdict::good, c.quality.degrees_of_freedom = 100;
  EXPECT_TRUE(assess(c, r).met);
  c.quality.verdict = Verdict::doubtful;
  EXPECT_FALSE(assess(c, r).met);
  EXPECT_LT(assess(c, r).reached, r.limit);
  EXPECT_EQ(assess(c, r).note, "the calibration is doubtful");
  c.covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(assess(c, r), Error);
}

TEST(Requirement, APriorAloneMeetsNone) {
  Calibration c;
  c.estimated = select_coefficients("accel.offset");
  c.covariance = 1e-12 * Eigen::MatrixXd::Identity(3, 3);
  c.quality.verdict = Verdict::good, c.quality.degrees_of_freedom = 100;
  c.quality.considered = {"accel.offset.y"};
  const RequirementResult result = assess(c, parse_requirements("accel.offset <= 1 ug").front());
  EXPECT_FALSE(result.met);
  EXPECT_EQ(result.coefficient, "accel.offset.y");
  EXPECT_FALSE(std::isfinite(result.reached));
  EXPECT_TRUE(assess(c, parse_requirements("accel.offset.x <= 1 ug").front()).met);
}

TEST(Requirement, FewDegreesOfFreedomCountWithStudentsT) {
  Calibration c;
  c.estimated = select_coefficients("accel.offset"), c.frame = BodyFrame::rig;
  c.covariance = std::pow(30 * unit::ug, 2) * Eigen::MatrixXd::Identity(3, 3);
  c.quality.verdict = Verdict::good;
  const Requirement r = parse_requirements("accel.offset <= 2 mg").front();
  struct Case {
    int degrees;
    double factor;  // k/2, from JCGM 100, table G.2
    bool met;
    const char* note;
  };
  for (const Case& each : {Case{1, 13.97 / 2, false, "1 degree of freedom, fewer than 3"},
                           {2, 4.53 / 2, false, "2 degrees of freedom, fewer than 3"},
                           {3, 3.31 / 2, true, "U/2 at 3 degrees of freedom"},
                           {4, 2.87 / 2, true, "U/2 at 4 degrees of freedom"},
                           {1000, 1, true, ""}}) {
    c.quality.degrees_of_freedom = each.degrees;
    const RequirementResult result = assess(c, r);
    EXPECT_NEAR(result.reached / (30 * unit::ug), each.factor, 0.01) << each.degrees;
    EXPECT_EQ(result.met, each.met) << each.degrees;
    EXPECT_EQ(result.note, each.note);
    EXPECT_EQ(assess(c, parse_requirements("accel.offset <= 40 ug").front()).met, each.degrees == 1000);
  }
}

}  // namespace
}  // namespace imulab
