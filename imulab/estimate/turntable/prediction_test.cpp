#include "imulab/estimate/turntable/prediction.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/estimate/turntable/estimator.hpp"
#include "imulab/parallel.hpp"
#include "imulab/procedure.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include "tests/table_steps.hpp"
#include <algorithm>
#include <atomic>
#include <cmath>

namespace imulab::turntable {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Returns a navigation-grade unit on this table.
Plan plan_by_steps(const std::vector<Step>& steps, double table_sigma) {
  Plan plan;
  plan.rig = table_of(table_sigma);
  plan.parts = table_plan(steps, plan.rig);
  plan.site = table_site();
  plan.accel_noise.N = 5 * unit::ug_per_sqrt_hz;
  plan.gyro_noise.N = 0.001 * unit::deg_per_sqrt_h;
  for (const char* selector : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"})
    for (const CoefficientIndex index : select_coefficients(selector)) plan.terms.push_back(index);
  return plan;
}

std::vector<CoefficientIndex> linear() { return select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"}); }

/// Returns a standard procedure with its own declarations except table accuracy and grade, with these terms; if there are none, all optional terms.
Plan standard(Session session, double table_sigma, const char* grade = "navigation", const std::vector<CoefficientIndex>& terms = linear()) {
  RigDeclaration& rig = session.rigs.front();
  rig.angle.value = rig.orthogonality.value = rig.zero.value = table_sigma;
  session.imu.grade = grade;
  return turntable::plan_of(session, terms);
}
Plan zhang(double table_sigma, const char* grade = "navigation", const std::vector<CoefficientIndex>& terms = linear()) {
  return standard(zhang_24_procedure({}), table_sigma, grade, terms);
}

std::string name_of(CoefficientIndex index) { return std::string(coefficient(index).name); }

/// Compares every coefficient's closed-form sigma with that of 20,000 calibrations.
void expect_agreement(const Plan& plan, std::size_t coefficients) {
  const Prediction closed = predict(plan);
  const MonteCarloResult sampled = monte_carlo(plan, 20000, 1);
  EXPECT_EQ(closed.coefficients.size(), coefficients);
  EXPECT_TRUE(closed.undetermined.empty());
  ASSERT_EQ(sampled.coefficients, closed.coefficients);
  EXPECT_EQ(sampled.runs, 20000u);
  const VectorXd sigma = closed.sigma;
  for (Index i = 0; i < sigma.size(); ++i) {
    const std::string name = name_of(closed.coefficients[static_cast<std::size_t>(i)]);
    // The sigma of 20,000 normal draws scatters by 0.5 %; products of errors scatter more.
    EXPECT_NEAR(sampled.sigma[i] / sigma[i], 1, std::max(0.03, 4 * sampled.sampling_sigma[i])) << name;
    EXPECT_NEAR(sampled.sampling_sigma[i], 0.005, 0.003) << name;
    // The mean is that of the sampled errors: 4.5 sigmas for 24 of them at a time.
    EXPECT_NEAR(sampled.mean[i] / sigma[i], 0, 4.5 / std::sqrt(20000)) << name;
  }
}

TEST(TurntablePrediction, AgreesWithMonteCarloOnZhangsProcedure) { expect_agreement(zhang(2 * unit::arcsec), 24); }
TEST(TurntablePrediction, AgreesWithMonteCarloOnAPathOfQuarterTurns) { expect_agreement(standard(cheng_path_procedure({}), unit::deg / 60), 24); }
TEST(TurntablePrediction, AgreesWithMonteCarloOnAnOddProcedure) { expect_agreement(plan_by_steps(odd_steps(), 20 * unit::arcsec), 24); }
/// Sums of squares would lose results limited only by noise of a millionth of the table's errors. A tenth of the noise gives a tenth of these
/// uncertainties, and does not change those that the table limits.
TEST(TurntablePrediction, KeepsItsDigitsWithNoiseAMillionthOfTheTablesErrors) {
  const auto sigma_with = [](double accel, double gyro) {
    Plan plan = zhang(20 * unit::arcsec);
    plan.accel_noise.N = accel, plan.gyro_noise.N = gyro;
    const Prediction p = predict(plan);
    EXPECT_TRUE(p.undetermined.empty());
    EXPECT_EQ(p.coefficients.size(), 24u);
    return std::pair(p.coefficients, p.first_order());
  };
  const auto [coefficients, usual] = sigma_with(1e-8, 1e-11);
  const VectorXd quiet = sigma_with(1e-9, 1e-12).second;
  for (Index i = 0; i < quiet.size(); ++i) {
    const std::string name = name_of(coefficients[static_cast<std::size_t>(i)]);
    const double ratio = quiet[i] / usual[i];
    if (name.find("offset") != std::string::npos)
      EXPECT_NEAR(ratio, 0.1, 5e-3) << name << ": the table's share of the variance is 1e-3 of it";
    else if (name != "gyro.matrix.xx" && name != "gyro.matrix.yy" && name != "gyro.matrix.zz")  // the noise and the table's timing limit these
      EXPECT_NEAR(ratio, 1, 1e-5) << name;
  }
}
TEST(TurntablePrediction, AgreesWithMonteCarloWithGSensitivity) {
  std::vector<CoefficientIndex> terms = linear();
  for (const CoefficientIndex index : select_coefficients("gyro.g_sensitivity")) terms.push_back(index);
  expect_agreement(zhang(60 * unit::arcsec, "mems", terms), 33);
}

/// Terms are drawn from their priors: observable, weakly observable and unobservable ones.
TEST(TurntablePrediction, AgreesWithMonteCarloWithDrawnTerms) {
  expect_agreement(zhang(2 * unit::arcsec, "navigation", {}), 45);
  expect_agreement(zhang(2 * unit::arcsec, "mems", {}), 45);
  expect_agreement(standard(cheng_path_procedure({}), unit::deg / 60, "tactical", {}), 45);
}

TEST(TurntablePrediction, AgreesWithMonteCarloWithClassicalWeights) {
  Plan plan = zhang(2 * unit::arcsec);
  plan = classical(plan);
  expect_agreement(plan, 24);
}

/// Returns the largest fraction of a source in any coefficient's variance.
double largest_share(const Prediction& p, const char* source) {
  const auto found = std::find(p.sources.begin(), p.sources.end(), source);
  if (found == p.sources.end()) return 0;
  return p.variance.col(found - p.sources.begin()).cwiseQuotient(p.first_order().cwiseAbs2()).maxCoeff();
}

/// Classical weights are used: the default finds the latitude from the holds, which leaves no effect of it.
TEST(TurntablePrediction, AgreesWithMonteCarloWithAnUncertainLatitudeAndTurnOnBiases) {
  std::vector<Step> steps = odd_steps();
  for (const auto& [middle, inner] : {std::pair{90.0, 0.0}, {-90.0, 0.0}, {0.0, 0.0}, {180.0, 0.0}, {0.0, 90.0}, {0.0, -90.0}}) {  // away from turns
    Step hold;
    hold.start = steps.back().end + 10;
    hold.end = hold.start + 30;
    hold.angles = {20 * unit::deg, middle * unit::deg, inner * unit::deg};
    steps.push_back(hold);
  }
  Plan plan = plan_by_steps(steps, 20 * unit::arcsec);
  plan.site.latitude_sigma = 0.1 * unit::deg;
  plan.gyro_noise.turn_on.value = 0.003 * unit::deg_per_h;
  plan.accel_noise.turn_on.value = 60 * unit::ug;
  EXPECT_LT(largest_share(predict(plan), "latitude"), 1e-3);
  plan = classical(plan);
  for (const char* source : {"latitude", "gyro turn-on", "accelerometer turn-on"}) EXPECT_GT(largest_share(predict(plan), source), 0.2) << source;
  expect_agreement(plan, 24);
}

/// The budget comes from the estimator's sensitivity to each source; the covariance that it states, from its normal equations.
TEST(TurntablePrediction, SharesMakeUpTheStatedCovariance) {
  for (const Plan& plan : {zhang(2 * unit::arcsec), zhang(2 * unit::arcsec, "tactical", {}), plan_by_steps(odd_steps(), unit::deg / 60)}) {
    const TableMotion motion(plan.parts, plan.rig, plan.site);
    const Matrix3d one = Matrix3d::Identity();
    EstimatorOptions settings;
    settings.terms = plan.terms, settings.optional = plan.optional;
    const Estimator estimator(motion, {}, {raw_density(plan.accel_noise.N, one), raw_density(plan.gyro_noise.N, one)}, settings);
    const auto stated = estimator.uncertainty({});
    const Prediction p = predict(plan);
    ASSERT_EQ(p.coefficients, stated.stated);
    for (Index i = 0; i < p.variance.rows(); ++i)  // rounding of weights over eight orders
      EXPECT_NEAR(p.variance.row(i).sum() / stated.covariance(i, i), 1, 1e-6) << name_of(p.coefficients[static_cast<std::size_t>(i)]);
  }
}

/// The default weights reach the bound; the classical ones do not if the table's errors differ from reading to reading.
TEST(TurntablePrediction, ClassicalWeightsAreNoBetterThanTheBound) {
  Plan plan = zhang(20 * unit::arcsec);
  plan.gyro_noise.turn_on.value = 0.003 * unit::deg_per_h;
  const Prediction best = predict(plan);
  plan = classical(plan);
  const Prediction classical = predict(plan);
  ASSERT_EQ(classical.coefficients, best.coefficients);
  const Eigen::ArrayXd ratio = classical.first_order().array() / classical.cramer_rao.array();
  EXPECT_GT(ratio.minCoeff(), 1 - 1e-6);  // rounding
  EXPECT_GT(ratio.maxCoeff(), 2);
  for (Index i = 0; i < ratio.size(); ++i) EXPECT_NEAR(classical.cramer_rao[i] / best.first_order()[i], 1, 1e-6);
}

/// A bias that is constant in the recording is an error of the offset and of nothing else.
TEST(TurntablePrediction, ATurnOnBiasAddsItsSquareToTheOffsets) {
  Plan plan = zhang(2 * unit::arcsec);
  const Prediction without = predict(plan);
  plan.gyro_noise.turn_on.value = 0.003 * unit::deg_per_h;
  plan.accel_noise.turn_on = {20 * unit::ug, true};  // size and sign are constant but unknown to the calibration
  const Prediction with = predict(plan);
  ASSERT_EQ(with.coefficients, without.coefficients);
  EXPECT_EQ(with.sources.size(), without.sources.size() + 2);
  for (std::size_t k = 0; k < with.coefficients.size(); ++k) {
    const auto i = static_cast<Index>(k);
    const Coefficient& c = coefficient(with.coefficients[k]);
    const double bias = c.triad == Triad::gyro ? plan.gyro_noise.turn_on.value : plan.accel_noise.turn_on.value;
    const double added = with.variance.row(i).sum() - without.variance.row(i).sum(), before = without.variance.row(i).sum();
    // Rounding of differences: 1e-12 of the variance, and 1e-6 of the square because weights span eight orders.
    EXPECT_NEAR(added, c.term == Term::offset ? bias * bias : 0, 1e-12 * before + 1e-6 * (c.term == Term::offset ? bias * bias : 0)) << c.name;
    EXPECT_EQ(with.second_order[i], without.second_order[i]) << c.name;
  }
}

TEST(TurntablePrediction, MonteCarloIsRepeatableOnAnyNumberOfThreads) {
  const Plan plan = zhang(20 * unit::arcsec);
  std::vector<MonteCarloResult> results;
  for (const auto& [threads, seed] : {std::pair{1, 7}, {2, 7}, {2, 8}}) {
    const ThreadLimit control(static_cast<std::size_t>(threads));
    results.push_back(monte_carlo(plan, 1000, static_cast<std::uint64_t>(seed)));  // the last block is not full
  }
  EXPECT_EQ(results[0].sigma, results[1].sigma);
  EXPECT_EQ(results[0].mean, results[1].mean);
  EXPECT_EQ(results[0].sampling_sigma, results[1].sampling_sigma);
  EXPECT_NE(results[0].sigma, results[2].sigma);
}

TEST(TurntablePrediction, MonteCarloTellsHowFarItIs) {
  std::atomic<std::uint64_t> calls = 0, most = 0;
  monte_carlo(zhang(2 * unit::arcsec), 300, 1, [&](std::uint64_t done) {
    ++calls;
    std::uint64_t before = most;
    while (before < done && !most.compare_exchange_weak(before, done)) {
    }
  });
  EXPECT_EQ(most, 300u);
  EXPECT_GT(calls, 1u);
}

}  // namespace
}  // namespace imulab::turntable
