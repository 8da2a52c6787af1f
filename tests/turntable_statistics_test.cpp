// A short acceptance test on an irregular procedure, at the level of rest means and turn sums: table errors, g and noise are drawn.
// ctest: long
#include "imulab/coefficient.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/table_session.hpp"

namespace imulab {
namespace {

using acceptance::Run;
using Eigen::Index;
using Eigen::VectorXd;

Run odd_run(std::uint64_t seed) {
  const RigDeclaration rig = table_of(20 * unit::arcsec);
  TableObservations seen;
  seen.parts = table_plan(odd_steps(), rig);
  const TableMotion motion(seen.parts, rig, table_site());
  const SensorModel truth = drawn_unit(seed);
  const VectorXd errors = motion.nominal() + motion.sigma().cwiseProduct(drawn_normals(motion.sigma().size(), seed, "table"));
  seen.readings = readings(motion, truth, motion.truth(errors)) + drawn_noise(motion, truth, seed);
  CalibrationOptions options;
  options.effects = false;  // none are simulated: the estimates are compared with the bound of the model alone
  options.terms = linear_terms();
  const Calibration c = turntable::calibrate(seen, rig, table_imu(), table_site(), options);
  const turntable::RawNoise noise{turntable::raw_density(table_accel_noise, truth.accel.matrix),
                                  turntable::raw_density(table_gyro_noise, truth.gyro.matrix)};
  Run result{c.estimated, VectorXd(c.estimated.size()), c.covariance, acceptance::turntable_information(motion, truth, noise, c.estimated)};
  for (std::size_t i = 0; i < c.estimated.size(); ++i)
    result.error[static_cast<Index>(i)] = coefficient_value(c.model, c.estimated[i]) - coefficient_value(truth, c.estimated[i]);
  return result;
}

TEST(Statistics, TurntableUncertaintiesHoldOnAnOddProcedure) {
  const int count = 100;
  const auto runs = acceptance::run_all(odd_run, count);
  for (const auto& r : runs) ASSERT_EQ(r.indices.size(), 24u);
  const auto checks = acceptance::judge(runs);
  for (const auto& check : checks) {
    // Efficiency over 100 runs scatters: its band is widened by 3.3 sigmas of the chi-square of 100 x 24 degrees of freedom.
    const double slack = check.name == "efficiency" ? 3.3 * std::sqrt(2.0 / (24.0 * count)) : 0;
    EXPECT_GE(check.value, check.low) << acceptance::describe(checks);
    EXPECT_LE(check.value, check.high + slack) << acceptance::describe(checks);
  }
}

}  // namespace
}  // namespace imulab
