#include "imulab/estimate/hybrid/hybrid.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <Eigen/Cholesky>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hybrid_session.hpp"

namespace imulab::hybrid {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// e^T P^-1 e over the estimated coefficients, and their number.
struct NormalizedError {
  double sum, count;
};
NormalizedError normalized_error(const Calibration& c, const SensorModel& truth) {
  Eigen::VectorXd e(static_cast<Eigen::Index>(c.estimated.size()));
  for (std::size_t i = 0; i < c.estimated.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    e[k] = coefficient_value(c.model, c.estimated[i]) - coefficient_value(truth, c.estimated[i]);
  }
  return {e.dot(c.covariance.ldlt().solve(e)), static_cast<double>(e.size())};
}

TEST(Hybrid, WithoutNoiseTheTruthComesBack) {
  HybridSession s = hybrid_session(1, [](Session& session) {
    session.imu.accel_noise_density = session.imu.gyro_noise_density = 1e-12;
    session.site.given_gravity = 9.8;
    session.site.given_gravity_sigma = 1e-12;
  });
  const CalibrationResult result = calibrated(s, base_terms());
  ASSERT_EQ(result.calibration.estimated.size(), 21u);
  for (const CoefficientIndex index : result.calibration.estimated) {
    // The remaining error is the integration of mean rates over 50 ms in turns that accelerate at 50 deg/s^2: 0.01 ppm.
    EXPECT_NEAR(coefficient_value(result.calibration.model, index), coefficient_value(s.truth.model, index), 1e-8) << coefficient(index).name;
  }
}

/// The effects of the grade are uncertain compared with such gyros, so corrections for them scatter.
TEST(Hybrid, ACleanSessionIsGoodUnderAGradeWorseThanTheUnit) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u})
    for (const char* grade : {"", "tactical"}) {
      HybridSession s = hybrid_session(seed, [](Session& session) { session.imu.grade.reset(); });
      if (*grade != 0) s.session.imu.grade = grade;
      const Calibration c = calibrated(s).calibration;
      EXPECT_EQ(c.quality.verdict, Verdict::good) << seed << " " << grade << ": " << verdict_text(c.quality);
      const auto [sum, count] = normalized_error(c, s.truth.model);
      EXPECT_LT(sum / count, 2) << seed << " " << grade;  // for about 30: p = 0.001
    }
}

/// Adds a turn about the vertical in the middle of each rest, of four times the integrated gyro noise. No velocity depends on it.
void turn_in_rests(HybridSession& s, std::uint64_t seed) {
  const RandomStream draws(seed, "turns in rests");
  for (std::size_t k = 0; k < s.rests.size(); ++k) {
    const std::size_t middle = (s.rests[k].begin + s.rests[k].end) / 2;
    const Vector3d up = reading_at(s.recording.accel, middle).normalized();
    const double rate = 4e-6 * draws.normal(k) / s.recording.interval_s;
    for (std::size_t axis = 0; axis < 3; ++axis) s.recording.gyro[axis][middle] += rate * up[static_cast<Eigen::Index>(axis)];
  }
}

TEST(Hybrid, RestsThatTurnALittleCountLess) {
  constexpr int sessions = 3;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= sessions; ++seed) {
    HybridSession s = hybrid_session(seed);
    const Calibration still = calibrated(s, base_terms()).calibration;
    EXPECT_THAT(still.quality.findings.warnings(), Not(Contains(HasSubstr("headings"))));
    turn_in_rests(s, seed);
    const Calibration c = calibrated(s, base_terms()).calibration;
    EXPECT_EQ(c.quality.verdict, Verdict::good) << verdict_text(c.quality);
    EXPECT_THAT(c.quality.findings.warnings(), Contains(testing::ContainsRegex("the headings within the rests scatter [2-5]")));
    const CoefficientIndex offset = coefficient_index("gyro.offset.x"), scale = coefficient_index("accel.matrix.xx");
    EXPECT_GT(*standard_uncertainty(c, offset), 1.2 * *standard_uncertainty(still, offset));
    EXPECT_LT(*standard_uncertainty(c, scale), 1.05 * *standard_uncertainty(still, scale));  // does not depend on the heading
    sum += normalized_error(c, s.truth.model).sum;
  }
  EXPECT_LT(sum, chi_square_quantile(0.9995, sessions * 21));
}

/// With a coarse start, the Earth's rate at rest resembles another latitude: a well-known place must not shorten the steps.
TEST(Hybrid, AWellKnownLatitudeDoesNotHoldItUp) {
  for (const std::uint64_t seed : {43u, 48u, 60u}) {
    Session session = method("hybrid").example({.on_table = {.rest = 30, .rate_hz = 50}, .seed = seed});
    session.imu.noise = NoiseTerms::full;
    const Truth truth = draw_truth(session, seed);
    const Recording recording =
        simulate_recording(session, session.recordings.front(), truth, seed, draw_rig_errors(session, session.recordings.front(), seed));
    const CalibrationResult result = calibrate(input_of(session, recording), {});
    EXPECT_EQ(result.calibration.quality.verdict, Verdict::good) << seed << ": " << verdict_text(result.calibration.quality);
    EXPECT_LE(result.iterations, 20) << seed;
  }
}

/// Readings are exact, or rounded by a sensor with noise far below its steps: the noise in the rests is zero.
TEST(Hybrid, WithoutNoiseThatShowsItConverges) {
  const HybridSession exact = hybrid_session(1, [](Session& session) { session.imu.accel_noise_density = session.imu.gyro_noise_density = 0; });
  for (const double step : {0.0, 1e-8, 1e-6, 1e-4}) {
    SCOPED_TRACE(step);
    HybridSession s = exact;
    s.session.imu.accel_noise_density.reset(), s.session.imu.gyro_noise_density.reset();
    if (step > 0)
      for (Columns3* triad : {&s.recording.gyro, &s.recording.accel})
        for (auto& column : *triad)
          for (double& reading : column) reading = step * std::round(reading / step);
    const Calibration c = calibrated(s, base_terms()).calibration;
    EXPECT_TRUE(c.quality.converged);
    EXPECT_THAT(c.quality.unobservable, IsEmpty());
    // The uncertainty of gravity, 3e-4 m/s^2, is 31 ppm; a scatter enlarges it by at most 1.5.
    EXPECT_LT(*standard_uncertainty(c, coefficient_index("accel.matrix.xx")), 50e-6);
    // Residuals of integration and rounding are not white: errors are below twice the stated deviations, for 21 coefficients.
    const auto [sum, count] = normalized_error(c, s.truth.model);
    EXPECT_LT(sum / count, 4);
  }
}

TEST(Hybrid, ErrorsAreAsLargeAsStatedWhateverTheTable) {
  double sum = 0;
  constexpr int sessions = 12;
  for (std::uint64_t seed = 1; seed <= sessions; ++seed) {
    const HybridSession s = hybrid_session(seed);
    const Calibration c = calibrated(s, base_terms()).calibration;
    ASSERT_EQ(c.estimated.size(), 21u);
    EXPECT_EQ(c.quality.verdict, Verdict::good);
    // About 3000 degrees of freedom give a standard deviation of 0.026.
    EXPECT_NEAR(c.quality.chi2_per_dof, 1, 0.1);
    sum += normalized_error(c, s.truth.model).sum;
  }
  // The bounds contain 99.9 % of the chi-square with 12 x 21 degrees of freedom.
  EXPECT_GT(sum, chi_square_quantile(0.0005, sessions * 21));
  EXPECT_LT(sum, chi_square_quantile(0.9995, sessions * 21));
}

TEST(Hybrid, ThePoorTableIsAsGoodAsTheBest) {
  // One unit with one noise is on three tables: the attitudes differ, so the noise acts in other directions, but errors remain within the sigmas, and
  // the sigmas are equal.
  Eigen::VectorXd best;
  for (const double table : {2 * unit::arcsec, 60 * unit::arcsec, 1 * unit::deg}) {
    const HybridSession s = hybrid_session(3, [&](Session& session) {
      RigDeclaration& rig = session.rigs.front();
      rig.angle.value = rig.orthogonality.value = rig.zero.value = table;
    });
    const Calibration c = calibrated(s, base_terms()).calibration;
    EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5) << "21 coefficients: once in 7000 sessions";
    const Eigen::VectorXd sigma = c.covariance.diagonal().cwiseSqrt();
    if (best.size() == 0) best = sigma;
    // A degree turns gravity by 1.7 %: the information of a rest about an axis changes by as much, and small information by several times more.
    EXPECT_LT((sigma.cwiseQuotient(best).array() - 1).abs().maxCoeff(), table < unit::deg ? 0.005 : 0.15);
  }
}

TEST(Hybrid, CountsGiveTheSameUnitAsSi) {
  const HybridSession s = hybrid_session(4);
  const CalibrationOptions options = base_terms();
  const Calibration si = calibrated(s, options).calibration;
  Recording counts = s.recording;
  counts.gyro_unit = counts.accel_unit = "count";
  const double gain = 1e5, zero = 32768;
  for (std::size_t j = 0; j < 3; ++j) {
    for (double& v : counts.accel[j]) v = zero + gain * v;
    for (double& v : counts.gyro[j]) v = zero + 10 * gain * v;
  }
  const Calibration c = hybrid::calibrate(input_of(s.session, counts, s.rests), options).calibration;
  ASSERT_EQ(c.estimated, si.estimated);
  for (const CoefficientIndex index : si.estimated) {
    const Coefficient& row = coefficient(index);
    const double scale = row.triad == Triad::accel ? gain : 10 * gain;
    const TriadModel& triad = row.triad == Triad::accel ? c.model.accel : c.model.gyro;
    const double value =
        row.term == Term::matrix ? scale * triad.matrix(row.row, row.column) : triad.offset[row.row] + zero * triad.matrix.row(row.row).sum();
    // The starts are different coarse solutions; both converge to a hundredth of a sigma per step.
    EXPECT_NEAR(value, coefficient_value(si.model, index), 0.03 * *standard_uncertainty(si, index)) << row.name;
  }
  EXPECT_EQ(c.quality.verdict, Verdict::good);
}

TEST(Hybrid, IncrementsAreAsGoodAsRates) {
  const HybridSession s = hybrid_session(5);
  Recording increments = s.recording;  // divided by the nominal interval, as in a file
  increments.gyro_increment = increments.accel_increment = true;
  // Stamps that jitter by a fifth of the interval do not affect the pulse counts.
  const RandomStream jitter(5, "jitter");
  for (std::size_t i = 0; i + 1 < increments.size(); ++i) increments.time_ns[i] += static_cast<std::int64_t>(1e7 * (2 * jitter.uniform(i) - 1));
  const Calibration a = calibrated(s, base_terms()).calibration;
  const Calibration b = hybrid::calibrate(input_of(s.session, increments, s.rests), base_terms()).calibration;
  for (const CoefficientIndex index : a.estimated)
    EXPECT_NEAR(coefficient_value(a.model, index), coefficient_value(b.model, index), 0.02 * *standard_uncertainty(a, index));  // convergence
}

TEST(Hybrid, OneAxisTurnedLeavesTheOthersNamed) {
  const HybridSession s = hybrid_session(6, [](Session& session) {
    // Only the middle axis turns: in 90 deg steps around, so that y stays horizontal.
    std::erase_if(session.steps, [](const Step& step) { return step.kind == StepKind::rotate && step.start > 0 && step.axis != RigAxis::middle; });
    double angle = 0, time = 0;
    for (Step& step : session.steps) {
      const double duration = step.end - step.start;
      step.start = time;
      step.end = time = time + duration;
      step.angles = {0, angle, 0};
      if (step.kind == StepKind::rotate) angle += step.angle;
    }
  });
  const CalibrationResult result = calibrated(s, base_terms());
  const Calibration& c = result.calibration;
  // Gravity is never along y, nothing turns about x or z, and the direction of x about the turn axis is a matter of the frame.
  for (const char* name : {"accel.offset.y", "accel.matrix.yy", "gyro.matrix.xz", "gyro.matrix.zx"})
    EXPECT_THAT(c.quality.unobservable, Contains(name));
  // The Earth's rate at rest determines their scales, with at most its total information.
  const double earth = earth_rate * std::sin(*s.session.site.latitude), seconds = s.session.steps.back().end;
  for (const char* name : {"gyro.matrix.xx", "gyro.matrix.zz"}) {
    EXPECT_GT(*standard_uncertainty(c, coefficient_index(name)), *s.session.imu.gyro_noise_density / (earth * std::sqrt(seconds))) << name;
    EXPECT_LT(*standard_uncertainty(c, coefficient_index(name)), 0.025) << name;  // half of the prior
  }
  for (const char* name : {"accel.matrix.xx", "accel.matrix.zz", "gyro.matrix.yy"}) EXPECT_THAT(c.quality.unobservable, Not(Contains(name)));
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("not determined by the data"));
  for (const std::string& name : c.quality.unobservable) {
    const CoefficientIndex index = coefficient_index(name);
    EXPECT_EQ(coefficient_value(c.model, index), coefficient_value(*result.coarse, index)) << name;
    EXPECT_FALSE(standard_uncertainty(c, index)) << name;
  }
  EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5);
}

TEST(Hybrid, TurnedByHand) {
  // The velocity is known only at rest, and rests are found in the data. One unit is MEMS with errors of 1 % (scales) and 1 deg/s (gyros).
  for (const char* grade : {"navigation", "mems"}) {
    double sum = 0, m = 0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      HandHeldOptions options;
      options.poses = 24;
      options.rate_hz = 100;  // a hand turns fast: at 50 Hz, residual coning and sculling exceed navigation-grade noise
      options.first_rest = options.rest = 10;
      options.move = 3;
      options.grade = grade;
      Session session = hand_held_procedure(options, seed);
      const Truth truth = draw_truth(session, seed);
      const Recording recording = simulate_recording(session, session.recordings.front(), truth, seed);
      session.steps.clear();
      const Calibration c = hybrid::calibrate(input_of(session, recording), base_terms(grade == std::string("mems"))).calibration;
      EXPECT_THAT(c.quality.unobservable, IsEmpty());
      EXPECT_EQ(c.quality.verdict, Verdict::good) << grade << " " << seed;
      const NormalizedError e = normalized_error(c, truth.model);
      sum += e.sum;
      m += e.count;
      EXPECT_THAT(c.quality.findings.warnings(), IsEmpty());
    }
    EXPECT_GT(sum, chi_square_quantile(0.0005, m)) << grade;
    EXPECT_LT(sum, chi_square_quantile(0.9995, m)) << grade;
  }
}

/// In an hour by hand, an equal g-sensitivity on all axes turns the unknown heading by radians.
TEST(Hybrid, FindsAHeadingThatTurns) {
  double sum = 0, sessions = 0;
  for (const std::uint64_t seed : {5u, 11u, 13u, 22u, 48u}) {
    HandHeldOptions options;
    options.poses = 150;
    options.rate_hz = 50;
    options.first_rest = options.rest = 20;
    options.move = 3;
    options.grade = "mems";
    Session session = hand_held_procedure(options, seed);
    const Truth truth = draw_truth(session, seed);
    const Recording recording = simulate_recording(session, session.recordings.front(), truth, seed);
    session.steps.clear();
    session.imu.grade.reset();  // any g-sensitivity
    const Calibration c = hybrid::calibrate(input_of(session, recording), base_terms(true)).calibration;
    EXPECT_EQ(c.quality.verdict, Verdict::good) << seed << ": " << verdict_text(c.quality);
    const CoefficientIndex index = coefficient_index("gyro.g_sensitivity.xx");
    sum += std::pow((coefficient_value(c.model, index) - coefficient_value(truth.model, index)) / *standard_uncertainty(c, index), 2), sessions += 1;
  }
  EXPECT_LT(sum, chi_square_quantile(0.9995, sessions));
}

/// The sum of the gyros' noise, 7 mrad per axis, would tilt the solution so much that the vertical force is wrong by 2e-5 on average.
TEST(Hybrid, NoTiltAddsUp) {
  double sum = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const HybridSession s = hybrid_session(seed, [](Session& session) {
      session.imu.gyro_noise_density = 1 * unit::deg_per_sqrt_h;
      session.site.given_gravity = session.site.gravity();
      session.site.given_gravity_sigma = 1e-6 * session.site.gravity();
    });
    const Calibration c = calibrated(s, base_terms()).calibration;
    EXPECT_EQ(c.quality.verdict, Verdict::good) << seed << ": " << verdict_text(c.quality);
    const NormalizedError e = normalized_error(c, s.truth.model);
    sum += e.sum, count += e.count;
  }
  EXPECT_GT(sum, chi_square_quantile(0.0005, count));
  EXPECT_LT(sum, chi_square_quantile(0.9995, count));
}

TEST(Hybrid, TheCurvesEndAtTheResult) {
  const HybridSession s = hybrid_session(7);
  CalibrationOptions options = base_terms();
  options.hybrid.curve_interval = 5;
  const CalibrationResult result = calibrated(s, options);
  ASSERT_EQ(result.curves.size(), 21u);
  ASSERT_GT(result.curve_time.size(), 50u);
  for (const ConvergenceCurve& curve : result.curves) {
    ASSERT_EQ(curve.residual.size(), result.curve_time.size());
    EXPECT_LT(curve.sigma.back(), 0.1 * curve.sigma.front()) << curve.name;
  }
  // This is ba of the first accelerometer at the end: A0 of the coarse solution minus its remainder.
  const SensorModel &coarse = *result.coarse, &model = result.calibration.model;
  const auto at = [&](const char* name) {
    for (const ConvergenceCurve& curve : result.curves)
      if (curve.name == name) return curve.residual.back();
    return 0.0;
  };
  // The tolerance includes convergence to a hundredth of a sigma and the product of two corrections (1e-3 each of 1e-3).
  EXPECT_NEAR(at("gyro.matrix.zz"), 1 - model.gyro.matrix(2, 2) / coarse.gyro.matrix(2, 2), 2e-6);
  EXPECT_NEAR(at("accel.offset.x"), coarse.accel.offset.x() - model.accel.offset.x(), 1e-5);
}

TEST(Hybrid, WhatItNeedsIsSaid) {
  HybridSession s = hybrid_session(8);
  Session nowhere = s.session;
  nowhere.site.latitude.reset();
  nowhere.site.given_gravity = 9.8;
  EXPECT_THROW(hybrid::calibrate(input_of(nowhere, s.recording, s.rests)), Error);
  EXPECT_THROW(hybrid::calibrate(input_of(s.session, s.recording, std::vector<Range>{})), Unsupported);
  CalibrationOptions options;
  options.terms = select_coefficients("accel.cubic");
  EXPECT_THROW(calibrated(s, options), Error);
}

}  // namespace
}  // namespace imulab::hybrid
