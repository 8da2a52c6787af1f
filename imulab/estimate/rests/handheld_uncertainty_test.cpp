// The handheld method's uncertainties for units with nonlinearity or coarse readings, and its findings about parts of a recording.
#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include "tests/calibration_input.hpp"
#include "tests/simulated_session.hpp"
#include <cmath>
#include <numbers>

namespace imulab {
namespace {

TEST(HandheldUncertainty, AQuadraticTermDoesNotBendTheOffsetsBeyondTheirUncertainty) {
  // One size is not significant, the other is: ten sessions of each, with 21 coefficients that every IMU has.
  for (const double size : {20.0, 200.0}) {
    double squares = 0, count = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const auto bend = [&](Truth& t) { t.model.accel.quadratic = Vector3d(1, -1, 1) * size * unit::ug / (unit::g * unit::g); };
      const SimulatedSession s = simulate_session(short_hand_held(), seed, bend);
      ImuDeclaration imu;
      imu.term_sigmas.accel_quadratic = size * unit::ug / (unit::g * unit::g);
      const Calibration c = calibrated("handheld", s.recording, s.rests, imu, s.site());
      for (const CoefficientIndex index : select_coefficients("accel.offset")) {
        squares += std::pow((coefficient_value(c.model, index) - coefficient_value(s.truth.model, index)) / *standard_uncertainty(c, index), 2);
        ++count;
      }
    }
    EXPECT_LT(squares / count, 2.0) << size << ": the mean square of 30 is above 2 once in 1300 times";
  }
}

TEST(HandheldUncertainty, ATremblingHandDoesNotShortenTheTurns) {
  // The tremor (2, 3.3 and 5.1 Hz, 0.05 deg RMS about each axis) widens the rest thresholds so much that slow ends of turns count as rest.
  double errors = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SimulatedSession s = simulate_session(short_hand_held(), seed);
    const RandomStream random(seed, "tremor");
    Recording& r = s.recording;
    for (std::size_t i = 0; i < r.size(); ++i) {
      const double t = r.time_s(i);
      Vector3d angle = Vector3d::Zero(), rate = Vector3d::Zero();
      std::uint64_t draw = 0;
      for (const double hz : {2.0, 3.3, 5.1})
        for (Eigen::Index axis = 0; axis < 3; ++axis) {
          const double size = 0.05 * unit::deg * std::sqrt(2.0 / 3), w = 2 * std::numbers::pi * hz,
                       phase = 2 * std::numbers::pi * random.uniform(draw++);
          angle[axis] += size * std::sin(w * t + phase), rate[axis] += size * w * std::cos(w * t + phase);
        }
      const Vector3d turned = rate - angle.cross(reading_at(r.gyro, i)), tilted = -angle.cross(reading_at(r.accel, i));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        r.gyro[axis][i] += turned[static_cast<Eigen::Index>(axis)];
        r.accel[axis][i] += tilted[static_cast<Eigen::Index>(axis)];
      }
    }
    Session found = s.session;
    found.steps.clear();
    const Calibration c = calibrated("handheld", r, rests_of(r, found).ranges, {}, s.site());
    EXPECT_EQ(c.quality.verdict, Verdict::good) << seed;
    for (Eigen::Index j = 0; j < 3; ++j) errors += c.model.gyro.matrix(j, j) - s.truth.model.gyro.matrix(j, j), ++count;
  }
  EXPECT_LT(std::abs(errors / count), 300e-6) << "single ones scatter by 250 ppm; with the slow ends left out the mean is some 1750";
}

TEST(HandheldUncertainty, RoundedReadingsAreNoBetterThanTheirSteps) {
  for (const double step : {0.1, 0.0}) {  // m/s^2; the gyros have steps of 0.005 rad/s
    double squares = 0, count = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      SimulatedSession s = simulate_session(short_hand_held(), seed);
      Columns3& triad = step > 0 ? s.recording.accel : s.recording.gyro;
      for (auto& column : triad)
        for (double& v : column) v = step > 0 ? std::nearbyint(v / step) * step : std::nearbyint(v / 0.005) * 0.005;
      const Calibration c = calibrated("handheld", s.recording, s.rests, {}, s.site());
      for (const CoefficientIndex index : c.estimated) {
        if (is_optional(coefficient(index).term)) continue;
        squares += std::pow((coefficient_value(c.model, index) - coefficient_value(s.truth.model, index)) / *standard_uncertainty(c, index), 2);
        ++count;
      }
    }
    // Of 252 squares, correlated in groups of about three, the mean exceeds 1.35 with p = 0.01 if independent; it is 2 only if rounding is ignored.
    EXPECT_LT(squares / count, 1.6) << step;
  }
}

TEST(HandheldUncertainty, PartsOfTheRecordingAreListedWithTheirResiduals) {
  SimulatedSession s = simulate_session(short_hand_held(), 4);
  const Range bad = s.rests[10];
  for (std::size_t i = bad.begin; i < bad.end; ++i) s.recording.accel[0][i] += 0.2;
  CalibrationOptions options;
  options.effects = false;  // the effects of a MEMS unit would absorb most of the remainder
  const Calibration c = calibrated("handheld", s.recording, s.rests, {}, s.site(), options);
  ASSERT_EQ(c.quality.rests.size(), 24u);
  EXPECT_EQ(c.quality.rotations.size(), 22u) << "two became one";
  double squares = 0;
  for (std::size_t k = 0; k < 24; ++k) {
    const PartResidual& rest = c.quality.rests[k];
    EXPECT_EQ(rest.used, k != 10) << k;
    EXPECT_NEAR(rest.end_s, s.recording.time_s(s.rests[k].end - 1), 1e-9);
    EXPECT_NEAR(rest.begin_s, s.recording.time_s(s.rests[k].begin) - s.recording.interval_s, 1e-9);
    if (rest.used) squares += rest.residual * rest.residual / 23;
    if (!rest.used) {
      EXPECT_GT(rest.residual, 10);
    }
  }
  EXPECT_NEAR(squares, 0.85, 0.4) << "of 92 equations, which some 15 coefficients follow";
}

}  // namespace
}  // namespace imulab
