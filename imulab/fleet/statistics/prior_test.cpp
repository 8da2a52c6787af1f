#include "imulab/fleet/statistics/prior.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/fleet_draw.hpp"
#include <cmath>
#include <limits>

namespace imulab {
namespace {

using Eigen::Index;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// A draw of a few coefficients of one calibration, correlated, about nominal values.
FleetPrior drawn_prior(const std::vector<CoefficientIndex>& coefficients) {
  const RandomStream random(3, "prior");
  const Index n = std::ssize(coefficients);
  FleetPrior out{.fleet = "fleet.db",
                 .units = 60,
                 .accel_unit = "",
                 .gyro_unit = "",
                 .coefficients = coefficients,
                 .mean = Eigen::VectorXd(n),
                 .covariance = {}};
  Eigen::MatrixXd draw(n, n);
  for (Index i = 0; i < n; ++i) {
    const Coefficient& c = coefficient(coefficients[static_cast<std::size_t>(i)]);
    const double size = c.term == Term::matrix ? 1e-3 : c.triad == Triad::accel ? 2e-3 * unit::g : 0.3 * unit::deg;
    out.mean[i] = (c.term == Term::matrix && c.row == c.column ? 1 : 0) + size * random.normal(1000 + static_cast<std::uint64_t>(i));
    for (Index j = 0; j < n; ++j) draw(i, j) = size * random.normal(static_cast<std::uint64_t>(i * n + j));
  }
  out.covariance = draw * draw.transpose() + Eigen::MatrixXd(draw.rowwise().squaredNorm().asDiagonal()) * 0.1;
  return out;
}

Eigen::VectorXd values_of(const Calibration& c) {
  Eigen::VectorXd x(std::ssize(c.estimated));
  for (std::size_t k = 0; k < c.estimated.size(); ++k) x[static_cast<Index>(k)] = coefficient_value(c.model, c.estimated[k]);
  return x;
}

TEST(FleetPrior, IsOneObservationMore) {
  // Against the sum of both informations: coefficients of the calibration alone, of both, and of the prior alone.
  Calibration c = drawn_calibration(1, 7, 0, 1.0);
  std::vector<CoefficientIndex> known = c.estimated;
  known.erase(known.begin(), known.begin() + 3);                                   // the accelerometers' offsets are the calibration's alone
  const std::vector<CoefficientIndex> more = select_each({"gyro.g_sensitivity"});  // the g-sensitivity the prior's
  known.insert(known.end(), more.begin(), more.end());
  const FleetPrior prior = drawn_prior(known);
  const Index own = std::ssize(c.estimated), all = own + std::ssize(more);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(all, all);
  Eigen::VectorXd vector = Eigen::VectorXd::Zero(all);
  const Eigen::MatrixXd of_data = inverse_of(c.covariance), of_prior = inverse_of(prior.covariance);
  information.topLeftCorner(own, own) = of_data;
  vector.head(own) = of_data * values_of(c);
  information.bottomRightCorner(all - 3, all - 3) += of_prior;
  vector.tail(all - 3) += of_prior * prior.mean;
  const Eigen::MatrixXd covariance = inverse_of(information);
  const Eigen::VectorXd expected = covariance * vector;

  const PriorUse use = take_prior(c, prior);
  EXPECT_TRUE(use.taken) << use.p_value;
  EXPECT_EQ(use.filled, more);
  ASSERT_EQ(std::ssize(c.estimated), all);
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  // The inverses above lose digits to sizes between 1e-3 and 1e3: 1e-8 of a sigma is enough.
  EXPECT_LT(((values_of(c) - expected).array() / sigma.array()).abs().maxCoeff(), 1e-7);
  EXPECT_LT(((c.covariance - covariance).array() / (sigma * sigma.transpose()).array()).abs().maxCoeff(), 1e-7);
}

TEST(FleetPrior, NeedsCoefficientsInCommon) {
  constexpr Index units = 9;
  FleetSample sample;
  sample.coefficients = select_each({"accel.offset"});
  sample.values = sample.variances = Eigen::MatrixXd::Ones(units, std::ssize(sample.coefficients));
  for (Index unit = 0; unit < units; ++unit) sample.last.push_back(unit);
  const auto covariance = [&](Index) { return Eigen::MatrixXd(Eigen::MatrixXd::Identity(3, 3)); };
  EXPECT_THAT([&] { fleet_prior(sample, covariance); }, ThrowsMessage<Error>(HasSubstr("no bias and no matrix in common")));
}

TEST(FleetPrior, AUnitOfAnotherKindDoesNotTakeIt) {
  Calibration c = drawn_calibration(1, 7, 0, 0.3);
  FleetPrior prior = drawn_prior(c.estimated);
  c.model.gyro.matrix(0, 1) += 0.05;
  const Calibration before = c;
  const PriorUse use = take_prior(c, prior);
  EXPECT_FALSE(use.taken);
  EXPECT_LT(use.p_value, 1e-3);
  EXPECT_EQ(values_of(c), values_of(before));
  EXPECT_EQ(c.covariance, before.covariance);
  prior.gyro_unit = "count";
  EXPECT_THAT([&] { take_prior(c, prior); }, ThrowsMessage<Error>(HasSubstr("expected one kind of unit")));
}

TEST(FleetPrior, LeavesLessToReach) {
  FleetPrior prior = drawn_prior(select_each({"gyro.matrix", "accel.offset"}));
  for (std::size_t k = 0; k < prior.coefficients.size(); ++k) {
    const Coefficient& c = coefficient(prior.coefficients[k]);
    if (c.term == Term::matrix && c.row == c.column) prior.mean[static_cast<Index>(k)] = c.row == 0 ? 2 : 1;  // x: readings in half the unit
  }
  prior.covariance = Eigen::MatrixXd(Eigen::VectorXd::Constant(12, 1e-6).asDiagonal());
  const CoefficientIndex xx = coefficient_index("gyro.matrix.xx"), yy = coefficient_index("gyro.matrix.yy");
  EXPECT_DOUBLE_EQ(relative_sigma(prior, xx), 0.5e-3);
  EXPECT_TRUE(std::isinf(relative_sigma(prior, coefficient_index("gyro.offset.x"))));
  // 600 ppm: the prior alone has xx; yy needs 1 / sqrt(1/600^2 - 1/1000^2) = 750 ppm; what the prior does not have needs all.
  const std::vector<Requirement> left = left_to_reach(parse_requirements("gyro.matrix.diagonal <= 600 ppm, gyro.offset <= 1 deg/h"), prior);
  ASSERT_EQ(left.size(), 5u);
  EXPECT_EQ(left[0].coefficients, std::vector{yy});
  EXPECT_NEAR(left[0].limit, 750e-6, 1e-12);
  EXPECT_EQ(left[2].coefficients, std::vector{coefficient_index("gyro.offset.x")});
  EXPECT_DOUBLE_EQ(left[2].limit, unit::deg / 3600);
}

/// Units with three accelerometer offsets, and terms over temperature of twice the spread at second order (at 50 K) as at first.
FleetSample thermal_sample() {
  constexpr Index units = 40;
  const RandomStream random(4, "thermal");
  FleetSample s;
  s.coefficients = select_each({"accel.offset", "accel.thermal.x1", "accel.thermal.y2", "accel.matrix_thermal1.yx", "gyro.thermal.x1"});
  s.values = s.variances = Eigen::MatrixXd(units, 7);
  const double sizes[] = {1e-2, 1e-2, 1e-2, 1e-3, 2e-3 / 50, 1e-5, 1e-6};
  for (Index unit = 0; unit < units; ++unit) {
    s.last.push_back(unit);
    for (Index k = 0; k < 7; ++k) {
      s.values(unit, k) = sizes[k] * random.normal(static_cast<std::uint64_t>(10 * unit + k));
      s.variances(unit, k) = 0.25 * sizes[k] * sizes[k];
    }
    if (unit > 3) s.values(unit, 6) = std::numeric_limits<double>::quiet_NaN();  // too few units have the gyros' term
  }
  s.common = {0, 1, 2};
  s.mean_covariance = Eigen::MatrixXd(1e-6 * Eigen::MatrixXd::Identity(3, 3));
  return s;
}

TEST(FleetPrior, HasTheSizesOfTermsOverTemperature) {
  const FleetSample s = thermal_sample();
  const FleetPrior prior = fleet_prior(s, [&](Index) { return s.mean_covariance; });
  const auto size = [&](Index column, double factor) {
    return factor * std::sqrt((s.values.col(column).array().square() + s.variances.col(column).array()).mean());
  };
  ASSERT_EQ(prior.effect_sigmas.size(), 2u);
  EXPECT_NEAR(prior.effect_sigmas.at("accel.thermal"), size(4, 50), 1e-12) << "the order with the largest";
  EXPECT_NEAR(prior.effect_sigmas.at("accel.matrix_thermal"), size(5, 10), 1e-12) << "a misalignment is a tenth of a scale";
}

TEST(FleetPrior, GivesItsSizesToAPlausibleUnit) {
  FleetPrior prior{.effect_sigmas = {{"accel.thermal", 1e-3}}};
  Calibration c;
  c.estimated = select_each({"accel.offset.x", "accel.thermal.x1", "accel.thermal.x2"});
  c.covariance = Eigen::MatrixXd(Eigen::Vector3d(1e-6, 1e-8, 1e-12).asDiagonal());
  EXPECT_TRUE(fit_of_sizes(c, prior).taken);
  c.model.accel.thermal(0, 1) = 5e-3;
  const PriorUse use = fit_of_sizes(c, prior);
  EXPECT_FALSE(use.taken);
  EXPECT_NEAR(use.distance, 5e-3 / std::sqrt(1e-6 + 1e-8), 1e-9);
  EXPECT_LT(use.p_value, 1e-3);
  c.estimated = select_each({"accel.offset"});
  EXPECT_FALSE(fit_of_sizes(c, prior).taken) << "no such terms";
  EXPECT_EQ(fit_of_sizes(c, prior).p_value, 1);
  Session session;
  session.recordings = {RecordingSource{}};
  session.imu.effect_sigmas["gyro.thermal"] = 1, prior.effect_sigmas["gyro.thermal"] = 2;
  EXPECT_EQ(with_sizes(session, prior).imu.effect_sigmas.at("accel.thermal"), 1e-3);
  EXPECT_EQ(with_sizes(session, prior).imu.effect_sigmas.at("gyro.thermal"), 1) << "declared";
  session.recordings[0].accel_temperature = ThermalSource{.unit = "raw"};
  EXPECT_EQ(with_sizes(session, prior).imu.effect_sigmas.size(), 1u);
}

}  // namespace
}  // namespace imulab
