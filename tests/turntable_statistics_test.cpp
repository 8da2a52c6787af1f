// The acceptance test of the turntable in small, at the level of rest means and turn sums: table errors, g and noise are drawn.
#include "imulab/model/coefficient.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/table_session.hpp"

namespace imulab {
namespace {

using acceptance::Run;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SensorModel with_coefficients(SensorModel model, const VectorXd& values) {
  const std::vector<int> indices = linear_terms();
  for (std::size_t i = 0; i < indices.size(); ++i) set_coefficient(model, indices[i], values[static_cast<Index>(i)]);
  return model;
}

/// Fisher information of the coefficients, derived apart from the estimator: readings with white noise alone, as a function of the coefficients and
/// of every table error, which are unknowns with a prior; derivatives by differences; the table errors eliminated.
MatrixXd fisher_information(const TableMotion& motion, const SensorModel& truth, const MatrixXd& noise) {
  const auto m = static_cast<Index>(linear_terms().size()), k = static_cast<Index>(motion.sources().size());
  VectorXd at(m + k), step(m + k);
  for (Index i = 0; i < m; ++i) at[i] = coefficient_value(truth, linear_terms()[static_cast<std::size_t>(i)]);
  at.tail(k) = motion.nominal();
  step.setConstant(1e-5);
  const auto predicted = [&](const VectorXd& x) { return readings(motion, with_coefficients(truth, x.head(m)), motion.truth(x.tail(k))); };
  MatrixXd jacobian(motion.rows(), m + k);
  for (Index c = 0; c < m + k; ++c) {
    VectorXd plus = at, minus = at;
    plus[c] += step[c];
    minus[c] -= step[c];
    jacobian.col(c) = (predicted(plus) - predicted(minus)) / (2 * step[c]);
  }
  // In units of each table error's sigma; those that are known exactly drop out.
  jacobian.rightCols(k) *= motion.sigma().asDiagonal();
  const MatrixXd white = noise.llt().matrixL().solve(jacobian);
  const MatrixXd information = white.transpose() * white;
  const MatrixXd cross = information.topRightCorner(m, k);
  return information.topLeftCorner(m, m) - cross * (information.bottomRightCorner(k, k) + MatrixXd::Identity(k, k)).ldlt().solve(cross.transpose());
}

Run run(const TableObservations& plan, const RigDeclaration& rig, std::uint64_t seed) {
  const TableMotion motion(plan, rig, table_site());
  const SensorModel truth = drawn_unit(seed);
  const VectorXd errors = motion.nominal() + motion.sigma().cwiseProduct(drawn_normals(motion.sigma().size(), seed, "table"));
  TableObservations seen = plan;
  seen.set_values(readings(motion, truth, motion.truth(errors)) + drawn_noise(motion, truth, seed));
  TurntableOptions options;
  options.terms = linear_terms();
  const Calibration c = calibrate_turntable(seen, rig, table_imu(), table_site(), options);
  const MatrixXd noise =
      noise_covariance(motion, raw_density(table_accel_noise, truth.accel.matrix), raw_density(table_gyro_noise, truth.gyro.matrix));
  Run result{c.estimated, VectorXd(c.estimated.size()), c.covariance, fisher_information(motion, truth, noise)};
  for (std::size_t i = 0; i < c.estimated.size(); ++i)
    result.error[static_cast<Index>(i)] = coefficient_value(c.model, c.estimated[i]) - coefficient_value(truth, c.estimated[i]);
  return result;
}

void expect_accepted(const std::vector<Step>& steps, double sigma) {
  const RigDeclaration rig = table_of(sigma);
  const TableObservations plan = planned_observations(steps, 5 * rig.timing.value);
  const int count = 200;
  std::vector<Run> runs(count);
  tbb::parallel_for(0, count, [&](int i) { runs[static_cast<std::size_t>(i)] = run(plan, rig, static_cast<std::uint64_t>(i + 1)); });
  for (const Run& r : runs) ASSERT_EQ(r.indices.size(), 24u);
  const auto checks = acceptance::judge(runs);
  for (const auto& check : checks) {
    // Efficiency over 200 runs scatters: its band is widened by 3.3 sigmas of the chi-square of 200 x 24 degrees of freedom.
    const double slack = check.name == "efficiency" ? 3.3 * std::sqrt(2.0 / (24.0 * count)) : 0;
    EXPECT_GE(check.value, check.low) << acceptance::describe(checks);
    EXPECT_LE(check.value, check.high + slack) << acceptance::describe(checks);
  }
}

TEST(TurntableStatistics, UncertaintiesHoldOnATableOfTwoArcseconds) { expect_accepted(zhang_steps(), 2 * unit::arcsec); }
TEST(TurntableStatistics, UncertaintiesHoldOnATableOfOneArcminute) { expect_accepted(zhang_steps(), 60 * unit::arcsec); }

TEST(TurntableStatistics, UncertaintiesHoldOnAnOddProcedure) { expect_accepted(odd_steps(), 20 * unit::arcsec); }

}  // namespace
}  // namespace imulab
