// The hybrid method's terms beyond Cheng's 21 are found if present, and left out if absent.
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/hybrid/hybrid.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/model/sensor_noise.hpp"

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hybrid_session.hpp"
#include <numeric>

namespace imulab::hybrid {
namespace {

using testing::Contains;
using testing::HasSubstr;

const TermTest& term_test(const Calibration& c, const std::string& name) {
  for (const TermTest& test : c.quality.term_tests)
    if (test.term == name) return test;
  throw std::logic_error(name);
}

/// Returns a session at 100 Hz, where the ramp of a turn has twenty samples.
HybridSession session_of(std::uint64_t seed, const SensorModel& unit) {
  return hybrid_session(
      seed, [](Session& session) { session = hybrid_procedure(6, 100); }, unit);
}

TEST(HybridTerms, LeverArmsAreFoundToAMillimetreAndHarmNothing) {
  const SensorModel unit = hybrid_unit(1, 0.03);
  const HybridSession s = session_of(1, unit);
  const Calibration c = calibrated(s).calibration;
  EXPECT_TRUE(term_test(c, "accel.lever_arm").kept);
  EXPECT_LT((c.model.lever_arm - unit.lever_arm).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT(*standard_uncertainty(c, coefficient_index("accel.lever_arm.xx")), 3e-4);
  EXPECT_LT(*standard_uncertainty(calibrated(s, {.effects = false}).calibration, coefficient_index("accel.lever_arm.xx")), 2.5e-4);
  EXPECT_LT(largest_sigmas(c, unit), 4.5) << "30 coefficients: once in 5000 sessions";
}

TEST(HybridTerms, QuadraticAccelerometersAreFound) {
  SensorModel unit = hybrid_unit(2);
  unit.accel.quadratic = Vector3d(2e-6, -1e-6, 1e-6);  // 20 ug/g^2 and half of it
  const HybridSession s = session_of(2, unit);
  const Calibration c = calibrated(s, {.effects = false}).calibration;  // an asymmetry within its prior would explain it
  EXPECT_TRUE(term_test(c, "accel.quadratic").kept);
  EXPECT_FALSE(term_test(c, "accel.lever_arm").kept);
  EXPECT_LT(largest_sigmas(c, unit), 4.5);
}

TEST(HybridTerms, OffsetsHoldWhereQuadraticTermsHardlyShow) {  // ctest: long
  double squares = 0;
  constexpr int sessions = 10;
  for (std::uint64_t seed = 1; seed <= sessions; ++seed) {
    SensorModel imu = hybrid_unit(seed);
    imu.accel.quadratic = Vector3d(10, 20, 30) * unit::ug / (unit::g * unit::g);
    const HybridSession s = hybrid_session(
        seed,
        [](Session& session) {
          session = hybrid_procedure(6, 20);
          session.imu.grade.reset();
          session.imu.gyro_noise_density = 0.01 * unit::deg_per_sqrt_h;
          session.imu.accel_noise_density = 100 * unit::ug_per_sqrt_hz;
        },
        imu);
    const Calibration c = calibrated(s).calibration;
    Eigen::Vector3d error;
    std::vector<Eigen::Index> at;
    for (std::size_t i = 0; i < c.estimated.size(); ++i)
      if (const Coefficient& k = coefficient(c.estimated[i]); k.triad == Triad::accel && k.term == Term::offset) {
        error[k.row] = c.model.accel.offset[k.row] - imu.accel.offset[k.row];
        at.push_back(static_cast<Eigen::Index>(i));
      }
    ASSERT_EQ(at.size(), 3u);
    squares += error.dot(Eigen::MatrixXd(c.covariance(at, at)).ldlt().solve(error));
  }
  EXPECT_LT(squares, chi_square_quantile(0.999, 3 * sessions));
}

TEST(HybridTerms, GSensitivityIsFound) {
  SensorModel unit = hybrid_unit(3);
  unit.g_sensitivity << 1e-7, -2e-7, 0, 0, 1e-7, 3e-7, -1e-7, 0, 2e-7;  // up to 0.6 deg/h/g
  const HybridSession s = session_of(3, unit);
  const Calibration c = calibrated(s).calibration;
  EXPECT_TRUE(term_test(c, "gyro.g_sensitivity").kept);
  EXPECT_FALSE(term_test(c, "accel.quadratic").kept);
  EXPECT_LT(largest_sigmas(c, unit), 4.5);
}

TEST(HybridTerms, ADelayIsFoundAndHarmsNothing) {
  HybridSession s = session_of(4, hybrid_unit(4, 0.03));  // includes lever arms, whose effect on the motion is also delayed
  // The accelerometers are 2 ms late: a fifth of each sample is the previous one, which is equivalent for means of a slow turn.
  for (std::vector<double>& axis : s.recording.accel)
    for (std::size_t i = axis.size(); --i > 0;) axis[i] += 0.2 * (axis[i - 1] - axis[i]);
  const Calibration c = calibrated(s).calibration;
  EXPECT_TRUE(term_test(c, "delay of the accelerometers").kept);
  EXPECT_THAT(c.quality.findings.notes(), Contains(HasSubstr("the accelerometers' output is 2 ms (u = 0.0")));
  EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5);
}

/// Equations that are linear in the delay cannot correct three samples.
TEST(HybridTerms, ALongDelayIsDoubted) {
  HybridSession s = session_of(4, hybrid_unit(4));
  for (std::vector<double>& axis : s.recording.accel)
    for (std::size_t i = axis.size(); --i > 2;) axis[i] = axis[i - 3];
  EXPECT_THAT(calibrated(s).calibration.quality.findings.reasons(), Contains(HasSubstr("more than what the method corrects")));
}

TEST(HybridTerms, WhatIsNotThereIsSeldomKept) {  // ctest: long
  int kept = 0;
  constexpr int sessions = 6;
  for (std::uint64_t seed = 1; seed <= sessions; ++seed) {
    const HybridSession s = hybrid_session(
        seed, [](Session& session) { session = hybrid_procedure(6, 50); }, hybrid_unit(seed));
    const Calibration c = calibrated(s).calibration;
    ASSERT_EQ(c.quality.term_tests.size(), 4u);
    for (const TermTest& test : c.quality.term_tests) kept += test.kept;
  }
  // Of 24 tests at 1 %, more than 2 are significant by chance with p = 0.001.
  EXPECT_LE(kept, binomial_quantile(0.999, 4 * sessions, 0.01));
}

TEST(HybridTerms, OffsetsThatWanderAreTheirMean) {
  double sum = 0;
  constexpr int sessions = 4;
  for (std::uint64_t seed = 1; seed <= sessions; ++seed) {
    const HybridSession s = hybrid_session(seed, [](Session& session) {
      session.imu.gyro_noise.emplace().K = 0.1 * unit::deg_per_h / 60;  // of an hour: 0.1 deg/h
      session.imu.accel_noise.emplace().K = 50 * unit::ug / 60;
      session.imu.accel_noise->Q = 1e-5;  // quantized velocities
    });
    SensorModel mean = s.truth.model;
    for (int axis = 0; axis < 3; ++axis)
      for (const Triad triad : {Triad::accel, Triad::gyro}) {
        std::vector<double> walk(s.recording.size(), 0.0);
        const std::string name = std::string(to_string(triad)) + "." + "xyz"[axis];
        AxisNoise(triad == Triad::accel ? s.truth.accel_noise : s.truth.gyro_noise, s.recording.interval_s, seed, name + " noise of recording.csv")
            .add_slow(walk);
        (triad == Triad::accel ? mean.accel : mean.gyro).offset[axis] -=
            std::accumulate(walk.begin(), walk.end(), 0.0) / static_cast<double>(walk.size());
      }
    const Calibration c = calibrated(s, base_terms()).calibration;
    Eigen::VectorXd e(21);
    for (std::size_t i = 0; i < 21; ++i)
      e[static_cast<Eigen::Index>(i)] = coefficient_value(c.model, c.estimated[i]) - coefficient_value(mean, c.estimated[i]);
    sum += e.dot(c.covariance.ldlt().solve(e));
  }
  EXPECT_GT(sum, chi_square_quantile(0.0005, sessions * 21));
  EXPECT_LT(sum, chi_square_quantile(0.9995, sessions * 21));
}

}  // namespace
}  // namespace imulab::hybrid
