// Predictions of the methods on rests. tests/methods_test.cpp compares them with calibrations.
#include "imulab/estimate/prediction.hpp"

#include "imulab/error.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/grade.hpp"
#include "imulab/procedure.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

namespace imulab::rests {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Returns rests at random attitudes; `grade` sets the declared noise.
Session procedure_of(const char* grade_name, int poses) {
  HandHeldOptions options;
  options.poses = poses, options.first_rest = 10, options.grade = grade_name;
  Session s = hand_held_procedure(options, 1);
  s.imu.accel_noise_density = grade(grade_name).accel_noise.N, s.imu.gyro_noise_density = grade(grade_name).gyro_noise.N;
  return s;
}

TEST(RestsPrediction, GyrosThatDoNotResolveEarthsRateAreNotAmongTheStaticOnes) {
  const Prediction p = predict_static(procedure_of("mems", 25));
  for (const CoefficientIndex index : p.coefficients) EXPECT_EQ(coefficient(index).triad, Triad::accel);
  ASSERT_EQ(p.notes.size(), 1u);
  EXPECT_THAT(p.notes[0], HasSubstr("do not resolve Earth's rate"));
  const std::vector<Shortfall> missed = shortfalls(p, parse_requirements("gyro.matrix.xx <= 1 %"));
  ASSERT_EQ(missed.size(), 1u);
  EXPECT_TRUE(std::isinf(missed[0].sigma));
}

TEST(RestsPrediction, LimitsAreComparedAsThoseOfACalibration) {
  Calibration c;
  c.estimated = select_coefficients("gyro.offset"), c.frame = BodyFrame::rig;
  c.covariance = 1e-12 * Eigen::MatrixXd::Identity(3, 3);
  for (const int degrees : {1, 4, 50})
    for (const char* limit : {"gyro.offset <= 1 deg/s", "gyro.offset <= 0.25 deg/h"}) {
      c.quality.degrees_of_freedom = degrees;
      const std::vector<Requirement> required = parse_requirements(limit);
      const Prediction p = prediction_of(c);
      EXPECT_EQ(assess(p, required).front(), assess(c, required.front())) << degrees << limit;
      EXPECT_EQ(shortfalls(p, required).empty(), assess(c, required.front()).met) << degrees << limit;
    }
}

TEST(RestsPrediction, TooFewPosesDetermineLess) {
  const Prediction p = predict_handheld(procedure_of("mems", 3));
  EXPECT_TRUE(contains(p.undetermined, coefficient_index("accel.offset.x")));
  EXPECT_THAT(predict_handheld(procedure_of("mems", 12)).undetermined, IsEmpty());
}

/// The prior of a scale over temperature is 250 ppm/K, that of c1 1000 ug/K (docs/theory/effects.md). A warm-up of 20 min determines them to less
/// than a third, one of 2 min hardly.
TEST(RestsPrediction, OfAWarmUpHasTheTermsOverTemperature) {
  const auto sigma = [](const Prediction& p, const char* name) {
    const auto at = std::ranges::find(p.coefficients, coefficient_index(name));
    return at == p.coefficients.end() ? HUGE_VAL : p.sigma[at - p.coefficients.begin()];
  };
  const Prediction p = predict_handheld(warm_up_procedure({}, 1));
  for (const char* name : {"accel.matrix_thermal1.xx", "gyro.matrix_thermal1.zz"}) EXPECT_LT(sigma(p, name), 80 * unit::ppm) << name;
  EXPECT_LT(sigma(p, "accel.thermal.y1"), 100 * unit::ug);
  EXPECT_GT(sigma(predict_handheld(warm_up_procedure({.minutes = 2}, 1)), "accel.matrix_thermal1.xx"), 120 * unit::ppm);
}

TEST(RestsPrediction, SaysWhatAProcedureLacks) {
  const auto error_of = [](const Session& s) {
    try {
      predict_handheld(s);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  Session s = procedure_of("mems", 5);
  s.recordings.push_back(s.recordings.front());
  EXPECT_THAT(error_of(s), HasSubstr("2 recordings"));
  s = procedure_of("mems", 5);
  s.imu.grade.reset(), s.imu.gyro_noise_density.reset();
  EXPECT_THAT(error_of(s), HasSubstr("noise is not declared"));
  s = procedure_of("mems", 5);
  for (Step& step : s.steps) step.kind = StepKind::rotate, step.rate = 1, step.angle = 0.1, step.acceleration = 10;
  EXPECT_THAT(error_of(s), HasSubstr("no hold"));
}

}  // namespace
}  // namespace imulab::rests
