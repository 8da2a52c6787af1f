#include "imulab/fleet/statistics/prior.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/fleet_draw.hpp"
#include <cmath>

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

}  // namespace
}  // namespace imulab
