#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/finding_code.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/recording/rest_means.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calibration_input.hpp"
#include "tests/simulated_session.hpp"
#include <algorithm>

namespace imulab {
namespace {

using testing::HasSubstr;

TEST(Handheld, WithoutNoiseTheTruthComesBack) {
  const SimulatedSession s = simulate_session(short_hand_held(), 1, [](Truth& t) { t.accel_noise.N = t.gyro_noise.N = 1e-10; });
  Site site = s.site();
  site.given_gravity = s.truth.gravity;
  ImuDeclaration imu;
  imu.accel_noise_density = imu.gyro_noise_density = 1e-10;
  Session holds = s.session;
  CalibrationOptions options;
  options.outlier_level = 0;
  options.effects = false;  // the effects' priors are 1e8 times this noise
  const Calibration c = calibrated("handheld", s.recording, rests_of(s.recording, holds).ranges, imu, site, options);
  for (const CoefficientIndex index : c.estimated) {
    const Coefficient& row = coefficient(index);
    // The accelerometers measure only gravity and have the remaining noise. The gyros keep about 1e-6 from coning within single samples at 100 Hz.
    const double tolerance = row.triad == Triad::accel ? 1e-9 : 1e-5;
    EXPECT_NEAR(coefficient_value(c.model, index), coefficient_value(s.truth.model, index), tolerance) << row.name;
  }
}

TEST(Handheld, KnocksBeyondTheAccelerometersRangeLeaveTheTurns) {
  SimulatedSession s = simulate_session(short_hand_held(), 5);
  for (const Range& rest : s.rests)  // the unit is put down half a second before it rests
    if (const std::size_t knock = rest.begin - std::min<std::size_t>(rest.begin, 50); knock > 0)
      s.recording.accel[2][knock] = 39.2, s.recording.saturated.push_back(knock);
  const Calibration c = calibrated("handheld", s.recording, s.rests, {}, s.site());
  EXPECT_EQ(c.quality.verdict, Verdict::good) << verdict_text(c.quality);
  EXPECT_LT(largest_sigmas(c, s.truth.model), 4);
  for (const std::size_t i : s.recording.saturated) s.recording.gyro[0][i] = 40;
  EXPECT_EQ(calibrated("handheld", s.recording, s.rests, {}, s.site()).quality.unobservable.size(), 9U) << "of a gyro that clips in every turn";
}

TEST(Handheld, WhereHalfOfTheRestsAreOfAnotherUnitTheResultIsDoubtful) {
  SimulatedSession s = simulate_session(short_hand_held(), 7);
  for (std::size_t i = s.rests[14].begin; i < s.recording.size(); ++i)
    for (auto& column : s.recording.gyro) column[i] += 0.05;
  for (const char* name : {"static", "handheld"}) {
    Session session;
    session.site = s.site();
    const Quality quality = calibrate(name, input_of(session, s.recording)).calibration.quality;
    EXPECT_THAT(quality.findings.reasons(),
                testing::Contains(testing::ContainsRegex("(9|1[01]) of 2[0-9] stretches that look like rests were rejected")))
        << name;
  }
}

TEST(Handheld, GyrosThatTheirFirmwareSetToZeroAreGood) {
  SimulatedSession s = simulate_session(short_hand_held(), 3);
  const RestMeans first = summarize_rests(s.recording, {s.rests.front()}).front();
  for (std::size_t j = 0; j < 3; ++j)
    for (double& v : s.recording.gyro[j]) v -= first.gyro[static_cast<Eigen::Index>(j)];
  const Calibration c = calibrated("handheld", s.recording, s.rests, {}, s.site());
  EXPECT_EQ(c.quality.verdict, Verdict::good) << verdict_text(c.quality);
}

TEST(Handheld, TheOtherHemisphereIsTriedWhereNothingElseContradictsTheLatitude) {
  const SimulatedSession s = simulate_session(short_hand_held(), 4, [](Truth& t) { t.model.g_sensitivity.setZero(); });
  ImuDeclaration imu;
  imu.grade = "mems";
  imu.term_sigmas.g_sensitivity = 10 * unit::deg_per_h / unit::g;  // an equal part of 20 deg/h/g, due to the wrong sign, is within two sigmas
  Site south = s.site();
  south.latitude = -*south.latitude;
  EXPECT_EQ(calibrated("handheld", s.recording, s.rests, imu, s.site()).quality.verdict, Verdict::good);
  const Calibration c = calibrated("handheld", s.recording, s.rests, imu, south);
  EXPECT_EQ(c.quality.verdict, Verdict::doubtful);
  EXPECT_EQ(c.quality.cause, "site.latitude");
}

TEST(Handheld, CountsGiveTheSameUnitAsSi) {
  SimulatedSession s = simulate_session(short_hand_held(), 2);
  // Counts far from their zero have no nonlinearity of their own, and no offset that indicates the size of the g-sensitivity.
  ImuDeclaration imu;
  imu.grade = "mems";
  CalibrationOptions options;
  options.terms = select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"});
  const Calibration si = calibrated("handheld", s.recording, s.rests, imu, s.site(), options);
  Recording counts = s.recording;
  counts.gyro_unit = counts.accel_unit = "count";
  const double gain = 400, zero = 32768;
  for (std::size_t j = 0; j < 3; ++j) {
    for (double& v : counts.accel[j]) v = zero + gain * v;
    for (double& v : counts.gyro[j]) v = zero + 10 * gain * v;
  }
  const Calibration c = calibrated("handheld", counts, s.rests, imu, s.site(), options);
  // Least squares agree in other units: both converge to a hundredth of a sigma.
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k <= r; ++k)
      EXPECT_NEAR(gain * c.model.accel.matrix(r, k), si.model.accel.matrix(r, k),
                  0.03 * *standard_uncertainty(si, coefficient_index(Triad::accel, Term::matrix, r, k)));
  for (int r = 0; r < 3; ++r) {
    EXPECT_NEAR(c.model.accel.offset[r] + zero * c.model.accel.matrix.row(r).sum(), si.model.accel.offset[r],
                0.03 * *standard_uncertainty(si, coefficient_index(Triad::accel, Term::offset, r, r)));
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(10 * gain * c.model.gyro.matrix(r, k), si.model.gyro.matrix(r, k),
                  0.03 * *standard_uncertainty(si, coefficient_index(Triad::gyro, Term::matrix, r, k)));
  }
  EXPECT_EQ(c.quality.verdict, Verdict::good);
  const Calibration all = calibrated("handheld", counts, s.rests, imu, s.site());
  EXPECT_EQ(verdict_text(all.quality), "good");
  EXPECT_FALSE(standard_uncertainty(all, coefficient_index("accel.quadratic.x")));
  EXPECT_THAT(all.quality.considered, testing::Contains("accel.quadratic.x"));
}

const TermTest& test_of(const Calibration& c, const std::string& term) {
  return *std::find_if(c.quality.term_tests.begin(), c.quality.term_tests.end(), [&](const TermTest& test) { return test.term == term; });
}

TEST(Handheld, GSensitivityIsSeenWhereThereIsAndCountsEverywhere) {
  const SimulatedSession with = simulate_session(short_hand_held(), 3);
  const Calibration seen = calibrated("handheld", with.recording, with.rests, {}, with.site());
  ASSERT_EQ(seen.quality.term_tests.size(), 5u);
  EXPECT_TRUE(test_of(seen, "gyro.g_sensitivity").kept);
  EXPECT_LT(test_of(seen, "gyro.g_sensitivity").p_value, 1e-6);

  // Without the term, the test is significant in 1 % of the sessions: in at most 3 of 30 (99.97 %). The term is stated anyway.
  int wrongly_seen = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const SimulatedSession without = simulate_session(short_hand_held(), seed, [](Truth& t) { t.model.g_sensitivity.setZero(); });
    const Calibration c = calibrated("handheld", without.recording, without.rests, {}, without.site());
    wrongly_seen += test_of(c, "gyro.g_sensitivity").kept;
    EXPECT_GT(standard_uncertainty(c, coefficient_index("gyro.g_sensitivity.xx")).value_or(0), 0);
  }
  EXPECT_LE(wrongly_seen, 3);
}

TEST(Handheld, WhatTheDataSayNothingOfIsConsidered) {
  const SimulatedSession s = simulate_session(short_hand_held(), 3);
  ImuDeclaration imu;
  imu.term_sigmas.gyro_cubic = 1e-15;  // far below the resolution of rotations by hand
  const Calibration c = calibrated("handheld", s.recording, s.rests, imu, s.site());
  for (const CoefficientIndex index : select_coefficients("gyro.cubic")) {
    EXPECT_THAT(c.quality.considered, testing::Contains(std::string(coefficient(index).name)));
    EXPECT_EQ(coefficient_value(c.model, index), 0);
    EXPECT_NEAR(standard_uncertainty(c, index).value(), 1e-15, 1e-17);  // equals the prior; the scale is 1 within a percent
  }
  EXPECT_TRUE(c.quality.unobservable.empty());
  EXPECT_EQ(c.quality.verdict, Verdict::good);
}

TEST(Handheld, ABadRestIsDroppedAndNamed) {
  SimulatedSession s = simulate_session(short_hand_held(), 4);
  const Range bad = s.rests[10];
  for (std::size_t i = bad.begin; i < bad.end; ++i) s.recording.accel[0][i] += 0.2;  // simulates a push of the hand
  const Calibration c = calibrated("handheld", s.recording, s.rests, {}, s.site());
  ASSERT_EQ(c.quality.findings.warnings().size(), 1u);
  EXPECT_THAT(c.quality.findings.warnings()[0], HasSubstr("dropped as an outlier: the rest at"));
  EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5) << "30 coefficients: beyond 4.5 sigma once in 5000 sessions";
  EXPECT_EQ(c.quality.verdict, Verdict::good);
}

TEST(Handheld, ABadRotationIsDroppedAndTheRestsStay) {
  SimulatedSession s = simulate_session(short_hand_held(), 12);
  for (std::size_t i = s.rests[5].end + 50; i < s.rests[5].end + 60; ++i) s.recording.gyro[1][i] += 3;  // simulates ten clipped samples
  const Calibration c = calibrated("handheld", s.recording, s.rests, {}, s.site());
  ASSERT_EQ(c.quality.findings.warnings().size(), 1u);
  EXPECT_THAT(c.quality.findings.warnings()[0], HasSubstr("dropped as an outlier: the rotation between"));
  EXPECT_THAT(c.quality.findings.notes(), testing::Contains(HasSubstr("24 rests and 22 rotations")));
  EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5);
}

TEST(Handheld, ALostRotationLeavesTheRestOfTheSession) {
  SimulatedSession s = simulate_session(short_hand_held(), 6);
  s.recording.gaps = {s.rests[7].end + 20};
  const Calibration c = calibrated("handheld", s.recording, s.rests, {}, s.site());
  EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5);
  EXPECT_THAT(c.quality.findings.notes(), testing::Contains(HasSubstr("24 rests and 22 rotations")));
}

TEST(Handheld, SpreadBeyondTheSampleNoiseIsCounted) {
  // The accelerometers of each rest have errors of their own of 2 mg: the offsets' uncertainty is that of 24 such rests, not of the samples.
  SimulatedSession s = simulate_session(short_hand_held(), 7);
  const RandomStream draws(7, "spread");
  const double spread = 2e-3 * unit::g;
  for (std::size_t k = 0; k < s.rests.size(); ++k)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t i = s.rests[k].begin; i < s.rests[k].end; ++i) s.recording.accel[j][i] += spread * draws.normal(3 * k + j);
  const Calibration c = calibrated("handheld", s.recording, s.rests, {}, s.site());
  EXPECT_LT(largest_sigmas(c, s.truth.model), 5) << "Student with about 15 degrees of freedom, 30 coefficients";
  EXPECT_GT(*standard_uncertainty(c, coefficient_index("accel.offset.x")), 0.2 * spread);
  EXPECT_GT(c.quality.chi2_per_dof, 3);
  EXPECT_THAT(c.quality.findings.notes(), testing::Contains(HasSubstr("the rests' accelerometer means spread by")));
}

TEST(Handheld, TermsByHand) {
  const SimulatedSession s = simulate_session(short_hand_held(), 8);
  CalibrationOptions options;
  options.terms = select_coefficients("accel.offset");
  const Calibration c = calibrated("handheld", s.recording, s.rests, {}, s.site(), options);
  EXPECT_EQ(c.estimated, options.terms);
  EXPECT_EQ(c.model.gyro.matrix, Matrix3d::Identity()) << "what is not asked for keeps the declared unit";
  options.terms = select_coefficients("accel.lever_arm");
  EXPECT_THROW(calibrated("handheld", s.recording, s.rests, {}, s.site(), options), Error);
}

TEST(Handheld, UncertaintyOfGravityIsCommonToAllScales) {
  const SimulatedSession s = simulate_session(short_hand_held(), 9);
  Site rough = s.site(), exact = s.site();
  rough.given_gravity_sigma = 0.05;
  exact.given_gravity_sigma = 1e-9;
  const Calibration a = calibrated("handheld", s.recording, s.rests, {}, rough), b = calibrated("handheld", s.recording, s.rests, {}, exact);
  const double relative = 0.05 / s.site().gravity();
  for (const char* name : {"accel.matrix.xx", "accel.matrix.yy", "accel.matrix.zz"}) {
    const CoefficientIndex index = coefficient_index(name);
    const double added = std::pow(*standard_uncertainty(a, index), 2) - std::pow(*standard_uncertainty(b, index), 2);
    EXPECT_NEAR(std::sqrt(added), relative * coefficient_value(a.model, index), 1e-6 * relative);
  }
  EXPECT_NEAR(a.quality.sources.at(0).relative, relative, 1e-12);
}

TEST(Handheld, WrongUnitsAreNamed) {
  const auto message = [](const Recording& recording, const SimulatedSession& s) {
    try {
      calibrated("handheld", recording, s.rests, {}, s.site());
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  const SimulatedSession s = simulate_session(short_hand_held(), 10);
  Recording in_g = s.recording, times_g = s.recording, in_deg = s.recording, in_rad = s.recording;
  for (std::size_t j = 0; j < 3; ++j) {
    for (double& v : in_g.accel[j]) v /= unit::g;
    for (double& v : times_g.accel[j]) v *= unit::g;
    for (double& v : in_deg.gyro[j]) v /= unit::deg;
    for (double& v : in_rad.gyro[j]) v *= unit::deg;
  }
  EXPECT_THAT(message(in_g, s), HasSubstr("gravity at rest: the accelerometers' scale is"));
  EXPECT_THAT(message(in_g, s), HasSubstr("the readings are in g,"));
  EXPECT_THAT(message(times_g, s), HasSubstr("the readings are in m/s^2,"));
  EXPECT_THAT(message(in_deg, s), HasSubstr("the readings are in deg/s"));
  EXPECT_THAT(message(in_rad, s), HasSubstr("the readings are in rad/s"));
  EXPECT_EQ(message(s.recording, s), "no error");
}

TEST(Handheld, TooLittleDataSayWhatIsMissing) {
  const SimulatedSession s = simulate_session(short_hand_held(), 11);
  EXPECT_THROW(calibrated("handheld", s.recording, {}, {}, s.site()), Unsupported);
  // Three rests: the declared units start the fit, and most coefficients are named as undetermined.
  const Calibration c = calibrated("handheld", s.recording, {s.rests[0], s.rests[1], s.rests[2]}, {}, s.site());
  EXPECT_GT(c.quality.unobservable.size(), 5u);
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("doubtful, because"));
  for (const std::string& name : c.quality.unobservable) {
    const CoefficientIndex index = coefficient_index(name);
    EXPECT_FALSE(standard_uncertainty(c, index)) << name;
  }
  Recording counts = s.recording;
  counts.accel_unit = counts.gyro_unit = "count";
  EXPECT_THROW(calibrated("handheld", counts, {s.rests[0], s.rests[1], s.rests[2]}, {}, s.site()), Unsupported);
}

TEST(Handheld, WhatIsStatedHoldsWithFewOrCardinalRests) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    for (const bool cardinal : {false, true}) {
      HandHeldOptions options = short_hand_held();
      options.poses = cardinal ? 18 : 5 + static_cast<int>(seed);
      SimulatedSession s;
      s.session = hand_held_procedure(options, seed);
      if (cardinal)
        for (Step& step : s.session.steps)
          for (double& angle : step.angles) angle = std::round(angle / (90 * unit::deg)) * 90 * unit::deg;
      s.truth = draw_truth(s.session, seed);
      s.recording = simulate_recording(s.session, s.session.recordings.front(), s.truth, seed);
      const Calibration c = calibrated("handheld", s.recording, rests_of(s.recording, s.session).ranges, {}, s.site());
      EXPECT_LT(largest_sigmas(c, s.truth.model), 5) << "seed " << seed << (cardinal ? ", cardinal" : ", few") << ": 300 coefficients in all";
      for (const std::string& warning : c.quality.findings.warnings()) EXPECT_EQ(warning.find("dropped"), std::string::npos) << warning;
    }
  }
}

TEST(Handheld, NavigationGradeKeepsItsHeadings) {
  // These gyros resolve the Earth's rate: in half an hour, the Earth turns by 8 deg under the headings that the gyros propagate.
  HandHeldOptions options;
  options.poses = 24;
  options.first_rest = options.rest = 30;
  options.move = 40;
  options.grade = "navigation";
  const SimulatedSession s = simulate_session(options, 13);
  const Calibration c = calibrated("handheld", s.recording, rests_of(s.recording, s.session).ranges, {}, s.site());
  EXPECT_LT(largest_sigmas(c, s.truth.model), 5);
  // With 160 degrees of freedom, chi-square per degree of freedom exceeds 1.39 with p = 0.001.
  EXPECT_LT(c.quality.chi2_per_dof, 1.39);
  EXPECT_FALSE(test_of(c, "gyro.g_sensitivity").kept) << "this grade has no g-sensitivity; seen once in a hundred sessions";
}

}  // namespace
}  // namespace imulab
