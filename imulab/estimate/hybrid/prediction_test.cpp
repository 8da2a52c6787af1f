#include "imulab/estimate/hybrid/prediction.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hybrid_session.hpp"
#include <algorithm>
#include <cmath>

namespace imulab::hybrid {
namespace {

double sigma_of(const FilterPrediction& p, const char* name) {
  const auto found = std::find(p.coefficients.begin(), p.coefficients.end(), coefficient_index(name));
  return found == p.coefficients.end() ? INFINITY : p.sigma[found - p.coefficients.begin()];
}

TEST(HybridPrediction, IsWhatCalibrateStates) {
  const HybridSession s = hybrid_session(1);
  const Calibration c = calibrated(s, base_terms()).calibration;
  const FilterPrediction p = predict(plan_of(s.session, base_terms().terms));
  ASSERT_EQ(p.coefficients, c.estimated);
  for (std::size_t i = 0; i < p.coefficients.size(); ++i)  // the IMU's errors of 5e-4 and the table's of 1 arcmin change them by little more
    EXPECT_NEAR(*standard_uncertainty(c, p.coefficients[i]), p.sigma[static_cast<Eigen::Index>(i)], 0.01 * p.sigma[static_cast<Eigen::Index>(i)])
        << coefficient(p.coefficients[i]).name;
}

TEST(HybridPrediction, IsWhatCalibrateStatesOfAUnitTurnedByHand) {
  const HybridSession s = hybrid_session(2, [](Session& session) { session.rigs.front() = {}; });
  const Calibration c = calibrated(s, base_terms()).calibration;
  const FilterPrediction p = predict(plan_of(s.session, base_terms().terms));
  ASSERT_EQ(p.coefficients, c.estimated);
  for (std::size_t i = 0; i < p.coefficients.size(); ++i)
    EXPECT_NEAR(*standard_uncertainty(c, p.coefficients[i]), p.sigma[static_cast<Eigen::Index>(i)], 0.01 * p.sigma[static_cast<Eigen::Index>(i)])
        << coefficient(p.coefficients[i]).name;
}

TEST(HybridPrediction, RoundingDecidesNothing) {
  Session session = hybrid_session(3).session;
  session.imu.grade = "navigation";
  const FilterPrediction p = predict(plan_of(session));
  session.site.latitude = *session.site.latitude + 1e-15;
  const FilterPrediction other = predict(plan_of(session));
  ASSERT_EQ(p.coefficients, other.coefficients);
  for (Eigen::Index i = 0; i < p.sigma.size(); ++i)
    EXPECT_NEAR(other.sigma[i] / p.sigma[i], 1, 1e-10) << coefficient(p.coefficients[static_cast<std::size_t>(i)]).name;
}

/// No terms are named: quadratic terms, g-sensitivity, lever arms and delay are estimated under their priors, and the others considered.
TEST(HybridPrediction, HasTheTermsOfCalibrate) {
  for (const bool by_hand : {false, true}) {
    const HybridSession s = hybrid_session(3, [&](Session& session) {
      session.imu.grade = "navigation";  // its priors do not depend on the drawn offsets
      if (by_hand) session.rigs.front() = {};
    });
    CalibrationOptions without;
    without.effects = false;  // neither has the plan
    const Calibration c = calibrated(s, without).calibration;
    const FilterPrediction p = predict(plan_of(s.session));
    ASSERT_EQ(p.coefficients, c.estimated);
    std::vector<std::string> considered;
    for (const CoefficientIndex index : p.considered) considered.emplace_back(coefficient(index).name);
    EXPECT_EQ(considered, c.quality.considered);
    for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
      const Coefficient& term = coefficient(p.coefficients[i]);
      // The ramps of turns, with four samples each, determine the lever arms.
      const double tolerance = term.term == Term::lever_arm ? 0.1 : 0.01;
      EXPECT_NEAR(*standard_uncertainty(c, p.coefficients[i]) / p.sigma[static_cast<Eigen::Index>(i)], 1, tolerance) << term.name;
    }
  }
}

/// From means of rests alone, a scale is as certain as gravity, an offset at least as certain as half the difference of its two faces.
TEST(HybridPrediction, GravityBoundsTheAccelerometersScales) {
  const Session session = hybrid_procedure(60, 100);
  const Plan plan = plan_of(session, base_terms().terms);
  const FilterPrediction p = predict(plan);
  const double relative = plan.place.gravity_sigma / plan.place.gravity;
  for (const char* name : {"accel.matrix.xx", "accel.matrix.yy", "accel.matrix.zz"}) {
    EXPECT_GT(sigma_of(p, name), relative);
    EXPECT_LT(sigma_of(p, name), 1.01 * relative) << "half a part per million of noise beside 31";
  }
  for (const char* name : {"accel.offset.x", "accel.offset.y", "accel.offset.z"}) {
    EXPECT_LT(sigma_of(p, name), plan.noise.accel[0] / std::sqrt(2 * 60.0)) << "one rest of 60 s up and one down";
    EXPECT_GT(sigma_of(p, name), plan.noise.accel[0] / std::sqrt(1700.0)) << "no better than all the session's time";
  }
}

TEST(HybridPrediction, WhatIsNeverTurnedStaysOpen) {
  Session session = hybrid_procedure(30, 100);
  std::vector<Step> kept;  // only the middle axis turns
  for (const Step& step : session.steps) {
    if (kept.size() >= 9) break;
    kept.push_back(step);
  }
  session.steps = kept;
  const FilterPrediction p = predict(plan_of(session));
  EXPECT_THAT(p.undetermined, testing::Contains(coefficient_index("gyro.matrix.zx")));
  EXPECT_GT(sigma_of(p, "gyro.matrix.xx"), 20 * sigma_of(p, "gyro.matrix.yy")) << "by the Earth's rate alone";
  EXPECT_THAT(p.undetermined, testing::Not(testing::Contains(coefficient_index("gyro.matrix.yy"))));
  ASSERT_EQ(p.undetermined.size(), static_cast<std::size_t>(p.remaining.size()));
  EXPECT_GT(p.remaining.minCoeff(), 0);
}

TEST(HybridPrediction, SaysWhatIsMissing) {
  Session session = hybrid_procedure(15, 20);
  session.site.latitude.reset();
  session.site.given_gravity = 9.8;
  EXPECT_THROW(plan_of(session), Error);
  session = hybrid_procedure(15, 20);
  session.imu.gyro_noise_density = 0;
  EXPECT_THROW(plan_of(session), Error);
  session = hybrid_procedure(15, 20);
  session.steps.clear();
  EXPECT_THROW(plan_of(session), Error);
}

}  // namespace
}  // namespace imulab::hybrid
