#include "imulab/estimate/whole_unit/whole_unit.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/units.hpp"

#include <Eigen/Cholesky>
#include <gmock/gmock.h>

#include "tests/whole_unit_session.hpp"
#include <algorithm>

namespace imulab::whole_unit {
namespace {

using Eigen::Index;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

Calibration calibration_of(const WholeUnitSession& s, const CalibrationOptions& options = {}) { return calibrate(s.input(), options).calibration; }
CalibrationOptions full() { return full_whole_unit(); }

double squared_distance(const Calibration& c, const SensorModel& truth) {
  const Eigen::VectorXd e = errors_of(c, truth);
  return e.dot(c.covariance.ldlt().solve(e));
}

/// Ten seeds at 57 coefficients: a mean of chi-squares within its 99.99 % band.
TEST(WholeUnit, ErrorsAreAsLargeAsStated) {  // ctest: long
  double sum = 0, degrees = 0, stepwise_sum = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const WholeUnitSession s = whole_unit_session(seed);
    const Calibration c = calibration_of(s, full());
    ASSERT_EQ(c.estimated.size(), 57u);
    EXPECT_EQ(c.quality.verdict, Verdict::good) << c.quality.findings.warnings().size();
    EXPECT_EQ(c.frame, BodyFrame::rig);
    sum += squared_distance(c, s.truth.model);
    degrees += 57;
    const Calibration steps = calibration_of(s, full_whole_unit(true));
    stepwise_sum += squared_distance(steps, s.truth.model);
    for (Index k = 0; k < 57; ++k)  // least squares with correct weights is never worse; equal ones differ only by the points' weights
      EXPECT_LT(c.covariance(k, k), 1.02 * steps.covariance(k, k)) << coefficient(c.estimated[static_cast<std::size_t>(k)]).name;
  }
  for (const double total : {sum, stepwise_sum}) {
    EXPECT_GT(total, chi_square_quantile(0.5e-4, degrees));
    EXPECT_LT(total, chi_square_quantile(1 - 0.5e-4, degrees));
  }
}

TEST(WholeUnit, WithoutNoiseOrRigErrorsItIsTheTruth) {
  DaiUnitOptions options;
  options.record = 1;
  const WholeUnitSession s = whole_unit_session(3, options, [](Session& session) {
    session.imu.accel_noise_density = session.imu.gyro_noise_density = 1e-9;
    session.site.given_gravity = 9.81, session.site.given_gravity_sigma = 0;
    for (RigDeclaration& rig : session.rigs) rig.zero = rig.mount = rig.rate = rig.radius = {}, rig.time_constant = 0;
    for (RecordingSource& source : session.recordings) source.gyro_temperature->noise = source.accel_temperature->noise = 0;
  });
  const Calibration c = calibration_of(s, full());
  // The remainder is the Earth's horizontal rate, which part of a turn does not average out (5e-5 rad/s in a few of 246 points of up to 7 rad/s), and
  // the upward Coriolis force, 2e-3 m/s^2 in a few of 42 points of up to 300 m/s^2.
  for (std::size_t k = 0; k < c.estimated.size(); ++k) {
    const Coefficient& e = coefficient(c.estimated[k]);
    if (e.term != Term::matrix) continue;
    EXPECT_NEAR(coefficient_value(c.model, c.estimated[k]), coefficient_value(s.truth.model, c.estimated[k]), e.triad == Triad::gyro ? 2e-6 : 1e-6)
        << e.name;
  }
}

TEST(WholeUnit, AbsentTermsAreLeftOut) {
  DaiUnitOptions options;
  options.record = 1;
  WholeUnitSession s = whole_unit_session(4, options, [](Session&) {});
  SensorModel& unit = s.truth.model;
  unit.gyro.cubic.setZero(), unit.accel.quadratic.setZero();
  unit.gyro.thermal.col(2).setZero();
  for (std::size_t k = 0; k < 3; ++k)
    s.recordings[k] = simulate_recording(s.session, s.session.recordings[k], s.truth, 4, draw_rig_errors(s.session, s.session.recordings[k], 4));
  CalibrationOptions without;
  without.effects = false;  // with effects, which may hide a term, all terms stay
  const Calibration c = calibration_of(s, without);
  std::map<std::string, bool> kept;
  for (const TermTest& test : c.quality.term_tests) {
    kept[test.term] = test.kept;
    EXPECT_EQ(test.kept, test.cross_validation_without > 1.005 * test.cross_validation_with || test.p_value < 0.01) << test.term;
  }
  EXPECT_EQ(kept, (std::map<std::string, bool>{{"accel.cubic", true},
                                               {"accel.quadratic", false},
                                               {"accel.thermal second order", true},
                                               {"gyro.cubic", false},
                                               {"gyro.quadratic", true},
                                               {"gyro.thermal second order", false},
                                               {"gyro.g_sensitivity", true}}));
  EXPECT_EQ(c.estimated.size(), 57u);  // includes terms that were left out: they are zero but uncertain
  EXPECT_EQ(c.quality.considered.size(), 9u);
  EXPECT_EQ(std::count(c.quality.considered.begin(), c.quality.considered.end(), "gyro.cubic.x"), 1);
  EXPECT_TRUE(c.quality.converged);
  EXPECT_TRUE(c.model.gyro.cubic.isZero(0));
  EXPECT_LT(squared_distance(c, unit), chi_square_quantile(1 - 1e-4, 57));
}

/// The thermal reading is arbitrary: one sensor for a triad, or the gyros' resonance frequency in hertz.
TEST(WholeUnit, EveryThermalReadingServes) {
  for (const ThermalSensors sensors : {ThermalSensors::three, ThermalSensors::one, ThermalSensors::resonance}) {
    DaiUnitOptions options;
    options.record = 1;
    options.thermal = sensors;
    const WholeUnitSession s = whole_unit_session(5, options, [](Session&) {});
    const Calibration c = calibration_of(s, full());
    ASSERT_EQ(c.estimated.size(), 57u);
    ASSERT_EQ(c.model.gyro.temperature->unit, sensors == ThermalSensors::resonance ? "raw" : "degC");
    ASSERT_EQ(c.model.gyro.temperature->reference, s.truth.model.gyro.temperature->reference);  // the gauge
    EXPECT_LT(squared_distance(c, s.truth.model), chi_square_quantile(1 - 1e-5, 57)) << to_string(sensors);
  }
}

/// Counts about the middle of an unsigned converter give the same calibration in another unit.
TEST(WholeUnit, OffsetBinaryCountsGiveTheSameCalibration) {
  WholeUnitSession s = whole_unit_session(6);
  const Calibration si = calibration_of(s, full());
  constexpr double middle = 32768, counts_per_si[2] = {80, 3500};  // of 16 bits: 400 m/s^2 and 9 rad/s
  for (std::size_t r = 0; r < 3; ++r) {
    s.session.recordings[r].accel.unit = s.session.recordings[r].gyro.unit = "count";
    s.recordings[r].accel_unit = s.recordings[r].gyro_unit = "count";
    for (std::size_t triad = 0; triad < 2; ++triad)
      for (auto& column : triad == 0 ? s.recordings[r].accel : s.recordings[r].gyro)
        for (double& x : column) x = middle + counts_per_si[triad] * x;
  }
  const Calibration counts = calibration_of(s, full());
  ASSERT_EQ(counts.estimated.size(), 57u);
  for (const double f : {-250.0, 0.0, 9.8, 280.0}) {
    const RawSample raw{.gyro = {f / 50, f / 70, -f / 60}, .accel = {f, -0.5 * f, 0.1 * f}};
    RawSample in_counts = raw;
    in_counts.accel = Vector3d::Constant(middle) + counts_per_si[0] * raw.accel;
    in_counts.gyro = Vector3d::Constant(middle) + counts_per_si[1] * raw.gyro;
    // Both iterate to a hundredth of their uncertainty, here below 1e-3 m/s^2 and 1e-4 rad/s.
    EXPECT_LT((compensate(counts.model, in_counts).force - compensate(si.model, raw).force).norm(), 1e-4);
    EXPECT_LT((compensate(counts.model, in_counts).rate - compensate(si.model, raw).rate).norm(), 1e-5);
  }
  for (std::size_t k = 0; k < 57; ++k) {  // the relative uncertainty of scales does not depend on the unit
    const Coefficient& e = coefficient(si.estimated[k]);
    if (e.term != Term::thermal) continue;
    const auto i = static_cast<Index>(k);
    EXPECT_NEAR(std::sqrt(counts.covariance(i, i) / si.covariance(i, i)), counts_per_si[e.triad == Triad::accel ? 0 : 1],
                0.01 * counts_per_si[e.triad == Triad::accel ? 0 : 1]);
  }
}

WholeUnitSession without(WholeUnitSession s, const std::string& rig) {
  for (std::size_t k = s.session.recordings.size(); k-- > 0;) {
    if (s.session.recordings[k].rig != rig) continue;
    std::erase_if(s.session.steps, [&](const Step& step) { return step.recording == s.session.recordings[k].file; });
    s.session.recordings.erase(s.session.recordings.begin() + static_cast<std::ptrdiff_t>(k));
    s.recordings.erase(s.recordings.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return s;
}

TEST(WholeUnit, CoefficientsOfMissingMachinesAreNotDetermined) {
  const WholeUnitSession all = whole_unit_session(7);
  struct Case {
    std::string machine;
    std::vector<std::string> undetermined, still_known;
  };
  for (const Case& c : {Case{"chamber", {"gyro.thermal.x1", "accel.thermal.z2"}, {"gyro.cubic.x", "accel.cubic.x", "gyro.g_sensitivity.xy"}},
                        Case{"rate_table", {}, {"accel.cubic.z", "accel.thermal.x1"}},
                        Case{"centrifuge", {"accel.cubic.x"}, {"gyro.matrix.xy", "gyro.quadratic.z", "accel.matrix.xx", "gyro.thermal.y2"}}}) {
    const WholeUnitSession s = without(all, c.machine);
    const Calibration calibration = calibration_of(s, full());
    for (const std::string& name : c.undetermined) EXPECT_THAT(calibration.quality.unobservable, Contains(name)) << "without " << c.machine;
    for (const std::string& name : c.still_known) EXPECT_THAT(calibration.quality.unobservable, Not(Contains(name))) << "without " << c.machine;
    for (const std::string& name : calibration.quality.unobservable) {  // starting value without uncertainty
      const CoefficientIndex index = coefficient_index(name);
      EXPECT_EQ(coefficient_value(calibration.model, index), coefficient_value(SensorModel{}, index)) << name;
      EXPECT_FALSE(standard_uncertainty(calibration, index)) << name;
    }
    // The stated uncertainties are correct although some coefficients are undetermined, because their prior counts.
    const Eigen::VectorXd e = errors_of(calibration, s.truth.model);
    for (Index k = 0; k < e.size(); ++k)
      EXPECT_LT(std::abs(e[k]), 5 * std::sqrt(calibration.covariance(k, k)))
          << "without " << c.machine << ": " << coefficient(calibration.estimated[static_cast<std::size_t>(k)]).name;
  }
}

/// Insignificant terms that are left out enter the uncertainty of the others.
TEST(WholeUnit, InsignificantIsNotZero) {
  double sum = 0, degrees = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const WholeUnitSession s = without(whole_unit_session(seed), "rate_table");
    const Calibration c = calibration_of(s);
    EXPECT_EQ(c.quality.verdict, Verdict::good);
    sum += squared_distance(c, s.truth.model);
    degrees += static_cast<double>(c.estimated.size());
  }
  EXPECT_LT(sum, chi_square_quantile(1 - 1e-5, degrees));
}

/// A scale that nothing excites must not shrink to reduce the noise of its row.
TEST(WholeUnit, OneMountOnTheRateTableGivesOneColumn) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    WholeUnitSession s = without(whole_unit_session(seed), "centrifuge");
    std::erase_if(s.session.steps, [](const Step& step) { return step.recording == "rate_table.csv" && step.mount->up != BodyAxis{2, 1}; });
    const Calibration c = calibration_of(s);
    EXPECT_THAT(c.quality.unobservable, Contains("gyro.matrix.xx"));
    EXPECT_THAT(c.quality.unobservable, Not(Contains("gyro.matrix.xz")));
    EXPECT_NEAR(c.quality.chi2_per_dof, 1, 0.4);  // some 300 degrees of freedom: five sigma
    const Eigen::VectorXd e = errors_of(c, s.truth.model);
    for (Index k = 0; k < e.size(); ++k)
      EXPECT_LT(std::abs(e[k]), 5 * std::sqrt(c.covariance(k, k))) << coefficient(c.estimated[static_cast<std::size_t>(k)]).name;
  }
}

TEST(WholeUnit, FewTemperaturesAndOneSenseOfRotationAreEnough) {
  WholeUnitSession s = whole_unit_session(9);
  std::erase_if(s.session.steps, [](const Step& step) {
    const bool between = step.recording == "chamber.csv" && *step.temperature > 1 && *step.temperature < 69;
    return between || (step.recording == "rate_table.csv" && step.rate < 0);
  });
  CalibrationOptions options;
  options.effects = false;  // thermal drifts and scales resemble the second order
  const Calibration c = calibration_of(s, options);
  for (const TermTest& test : c.quality.term_tests)
    EXPECT_TRUE(test.kept || test.term != "accel.thermal second order") << test.p_value;  // omitted points of three temperatures cannot be predicted
  EXPECT_LT(squared_distance(c, s.truth.model), chi_square_quantile(1 - 1e-5, static_cast<double>(c.estimated.size())));
}

TEST(WholeUnit, StepwiseNeedsAllThreeMachines) {
  const WholeUnitSession s = without(whole_unit_session(7), "centrifuge");
  EXPECT_THROW(calibration_of(s, full_whole_unit(true)), Unsupported);
}

TEST(WholeUnit, RadiiAndMountsAreFoundWhenDeclaredUncertain) {
  DaiUnitOptions options;
  options.record = 1;
  const WholeUnitSession s = whole_unit_session(8, options, [](Session& session) {
    session.rigs[2].radius.value = 20e-3;
    session.rigs[2].mount.value = 600 * unit::arcsec;
  });
  const Calibration c = calibration_of(s, full());
  EXPECT_LT(squared_distance(c, s.truth.model), chi_square_quantile(1 - 1e-5, 57));
  const RigErrors truth = draw_rig_errors(s.session, s.session.recordings[2], 8);
  int radii = 0;
  for (std::size_t k = 0; k < truth.sources.size(); ++k)
    for (const RigErrorEstimate& e : c.quality.rig_errors) {
      if (e.name != "centrifuge: " + truth.sources[k].name()) continue;
      EXPECT_LT(std::abs(e.value - truth.values[k]), 5 * e.uncertainty) << e.name;
      if (truth.sources[k].kind != RigErrorKind::radius) continue;
      ++radii;
      EXPECT_LT(e.uncertainty, 0.02 * e.declared_sigma) << e.name;  // gravity is the scale: 20 mm become some tenths
    }
  EXPECT_EQ(radii, 6);
}

}  // namespace
}  // namespace imulab::whole_unit
