// Changes that one method may take for something else: a wrong place, a unit that changed on the way, lost samples. Never "good".
// ctest: long
#include <gmock/gmock.h>

#include "tests/hybrid_session.hpp"
#include <algorithm>
#include <cmath>
#include <string>

namespace imulab {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

/// By a method that reads the session's own steps.
Quality quality_of(const HybridSession& s, std::string_view method) {
  return calibrate(method, input_of(s.session, s.recording)).calibration.quality;
}

TEST(QuietChange, AnErrorOfTheLatitudeIsNoGSensitivity) {
  // Up is along the force at every rest, so 2 w_ie sin 45 deg / g is common to all axes: thousands of its sigmas on a table.
  HybridSession s = hybrid_session(4);
  s.session.site.latitude = -*s.session.site.latitude;
  EXPECT_THAT(quality_of(s, "handheld").findings.reasons(), Contains("the latitude seems to be wrong"));
  EXPECT_THAT(quality_of(s, "turntable").findings.reasons(), Contains("the latitude seems to be wrong"));
  s.session.site.latitude = -*s.session.site.latitude;
  EXPECT_THAT(quality_of(s, "handheld").findings.reasons(), testing::Not(Contains("the latitude seems to be wrong")));
}

TEST(QuietChange, AGravityOfAnotherPlaceIsDoubted) {
  HybridSession s = hybrid_session(4);
  const double normal = s.session.site.gravity();
  s.session.site.height = 0;
  s.session.site.given_gravity = 1.003 * normal;  // normal gravity at a known height is true to 5e-4
  EXPECT_THAT(quality_of(s, "turntable").findings.reasons(), Contains(HasSubstr("is not that of the given latitude")));
  s.session.site.given_gravity = normal + 0.004;
  EXPECT_THAT(quality_of(s, "turntable").findings.reasons(), testing::Not(Contains(HasSubstr("is not that of the given latitude"))));
  s.session.site.height.reset();  // at most as large as at sea level, but for its anomalies
  s.session.site.given_gravity = normal + 0.008;
  EXPECT_THAT(quality_of(s, "turntable").findings.reasons(), Contains(HasSubstr("is not that of the given latitude")));
  s.session.site.given_gravity = normal - 0.02;
  EXPECT_THAT(quality_of(s, "turntable").findings.reasons(), testing::Not(Contains(HasSubstr("is not that of the given latitude"))));
}

TEST(QuietChange, AnUncertainLatitudeMakesGravityUncertain) {
  Site site;
  site.latitude = 45 * unit::deg, site.height = 0;
  EXPECT_DOUBLE_EQ(site.gravity_sigma(), 3e-4);
  site.latitude_sigma = 1 * unit::deg;  // g = 9.78 (1 + 0.0053 sin^2 L): 0.0518 sin 2L a radian
  EXPECT_NEAR(site.gravity_sigma(), std::hypot(3e-4, 0.0518 * unit::deg), 5e-6);
  site.latitude_sigma = 90 * unit::deg;  // anywhere: the equator and the poles are 0.026 away
  EXPECT_NEAR(site.gravity_sigma(), 0.0259, 2e-4);
}

TEST(QuietChange, OffsetsThatDriftFromRestToRestAreLessCertain) {
  // By 20 ug and 0.2 deg/h in the session, exponentially: two and a half standard deviations of a second's velocity, where each rest begins.
  for (const double accel : {20 * unit::ug, 0.0}) {
    HybridSession s = hybrid_session(4);
    Recording& r = s.recording;
    const double gyro = accel > 0 ? 0 : 0.2 * unit::deg_per_h, mean = (1 - std::exp(-3.0)) / 3;
    for (std::size_t i = 0; i < r.size(); ++i) {
      const double drift = std::exp(-3.0 * static_cast<double>(i) / static_cast<double>(r.size())) - mean;
      for (std::size_t k = 0; k < 3; ++k) r.accel[k][i] += accel * drift, r.gyro[k][i] += gyro * drift;
    }
    const Calibration c = hybrid::calibrate(input_of(s.session, r, s.rests), {}).calibration;
    const auto drift = std::ranges::find(c.quality.effects, accel > 0 ? "accel.drift" : "gyro.drift", &EffectEstimate::name);
    ASSERT_NE(drift, c.quality.effects.end());
    EXPECT_TRUE(drift->significant);
    EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5);
    CalibrationOptions without;
    without.effects = false;
    const Calibration scattered = hybrid::calibrate(input_of(s.session, r, s.rests), without).calibration;
    EXPECT_THAT(scattered.quality.findings.warnings(),
                Contains(testing::ContainsRegex(accel > 0 ? "the rests' mean forces scatter [0-9.]+ times as much"
                                                          : "the headings within the rests scatter [0-9.]+ times as much")));
  }
}

TEST(QuietChange, AUnitThatChangesHasNoOneCalibration) {
  // An accelerometer's offset jumps by 1 mg after seven tenths of the session: the holds after it are outliers of those before.
  HybridSession s = hybrid_session(4);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 7 * s.recording.size() / 10; i < s.recording.size(); ++i) s.recording.accel[axis][i] += 0.01;
  const Quality quality = quality_of(s, "turntable");
  EXPECT_EQ(quality.verdict, Verdict::doubtful) << testing::PrintToString(quality.findings.warnings());
}

TEST(QuietChange, LostSamplesWithoutStampsEndInDoubt) {
  // A hundredth of the samples is missing, and the stamps do not show it: turns are too small, the steps late, and no latitude explains it.
  HybridSession s = hybrid_session(4);
  Recording& r = s.recording;
  const RandomStream draws(1, "lost samples");
  std::size_t kept = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (draws.uniform(i) < 0.01) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) r.gyro[axis][kept] = r.gyro[axis][i], r.accel[axis][kept] = r.accel[axis][i];
    ++kept;
  }
  r.time_ns.resize(kept);
  for (Columns3* triad : {&r.gyro, &r.accel})
    for (auto& column : *triad) column.resize(kept);
  for (Step& step : s.session.steps) step.end = std::min(step.end, r.time_s(kept - 1)), step.start = std::min(step.start, step.end);
  while (s.session.steps.back().end - s.session.steps.back().start < 1) s.session.steps.pop_back();
  EXPECT_EQ(quality_of(s, "hybrid").verdict, Verdict::doubtful);
}

TEST(QuietChange, AClockThatGainsIsStatedWithTheScales) {
  // 200 ppm, to a table whose turns begin and end within 10 ms: the scales are those of the recording's own seconds, and that clock's rate is found.
  constexpr double gain = 2e-4;
  HybridSession s = hybrid_session(4);
  for (const char* method : {"hybrid", "turntable"}) {
    SCOPED_TRACE(method);
    HybridSession fast = s;
    for (std::int64_t& stamp : fast.recording.time_ns) stamp += stamp / 5000;
    const Calibration before = calibrate(method, input_of(s.session, s.recording)).calibration,
                      after = calibrate(method, input_of(fast.session, fast.recording)).calibration;
    ASSERT_TRUE(after.clock.has_value());
    EXPECT_EQ(after.clock->seconds, "own");
    EXPECT_NEAR(after.clock->gain, gain, 4 * after.clock->sigma);
    EXPECT_LT(after.clock->sigma, 3e-5);
    EXPECT_NEAR(before.clock->gain, 0, 4 * before.clock->sigma);
    for (const char* name : {"gyro.matrix.xx", "gyro.matrix.yy", "gyro.matrix.zz"}) {
      const CoefficientIndex index = coefficient_index(name);
      const double ratio = coefficient_value(after.model, index) / coefficient_value(before.model, index);
      EXPECT_NEAR(ratio, 1 / (1 + gain), 0.02 * gain) << name;
    }
    fast.session.imu.clock = "true";
    const Calibration in_true_seconds = calibrate(method, input_of(fast.session, fast.recording)).calibration;
    const CoefficientIndex index = coefficient_index("gyro.matrix.xx");
    EXPECT_NEAR(coefficient_value(in_true_seconds.model, index) / coefficient_value(after.model, index), 1 + after.clock->gain, 1e-12);
    EXPECT_NEAR(*standard_uncertainty(in_true_seconds, index), std::hypot(*standard_uncertainty(after, index), after.clock->sigma),
                1e-2 * after.clock->sigma);
  }
}

TEST(QuietChange, AGyroScaleThatDependsOnTheDirectionIsFound) {
  // 20 ppm between turns to the left and to the right leave residuals that are hardly larger than the noise, and errors of twenty sigmas without
  // effects.
  HybridSession s = hybrid_session(4);
  const auto asymmetry = [&] {
    const std::vector<EffectEstimate> effects = quality_of(s, "hybrid").effects;
    return *std::ranges::find(effects, "gyro.asymmetry", &EffectEstimate::name);
  };
  EXPECT_FALSE(asymmetry().significant);
  for (auto& column : s.recording.gyro)
    for (double& rate : column) rate += 2e-5 * std::abs(rate);
  const EffectEstimate found = asymmetry();
  EXPECT_TRUE(found.significant);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(found.values[axis], 20, 4 * found.sigma[axis]) << axis;
}

TEST(QuietChange, DataThatCountTwiceAreDoubted) {
  HybridSession s = hybrid_session(4);
  Recording& r = s.recording;
  const std::size_t once = r.size();
  for (Columns3* triad : {&r.gyro, &r.accel})
    for (auto& column : *triad) {
      column.reserve(2 * once);
      column.insert(column.end(), column.begin(), column.begin() + static_cast<std::ptrdiff_t>(once));
    }
  for (std::size_t i = 0; i < once; ++i) r.time_ns.push_back(r.time_ns[once - 1] + r.time_ns[i]);
  s.session.steps.clear();
  EXPECT_THAT(quality_of(s, "handheld").findings.reasons(), Contains(HasSubstr("to the last digit")));
}

}  // namespace
}  // namespace imulab
