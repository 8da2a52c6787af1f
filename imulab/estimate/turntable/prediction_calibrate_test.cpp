// A calibration states its predicted uncertainties.
#include "imulab/estimate/turntable/fit.hpp"
#include "imulab/estimate/turntable/prediction.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/table_session.hpp"

namespace imulab::turntable {
namespace {

/// Returns the covariance of dM M^-1 instead of the matrices M, and of nonlinearity of calibrated readings: as for a unit with an ideal matrix.
Eigen::MatrixXd as_of_an_ideal_unit(const Calibration& c) {
  const auto n = static_cast<Eigen::Index>(c.estimated.size());
  Eigen::MatrixXd map = Eigen::MatrixXd::Identity(n, n);
  const auto term = [&](Eigen::Index i) { return coefficient(c.estimated[static_cast<std::size_t>(i)]); };
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const Coefficient to = term(i), from = term(j);
      const double scale = (to.triad == Triad::accel ? c.model.accel : c.model.gyro).matrix(to.row, to.row);
      if (i == j && to.term == Term::quadratic) map(i, i) = std::pow(scale, -2);
      if (i == j && to.term == Term::cubic) map(i, i) = std::pow(scale, -3);
      if (to.term != Term::matrix || from.term != Term::matrix || to.triad != from.triad || to.row != from.row) continue;
      map(i, j) = (to.triad == Triad::accel ? c.model.accel : c.model.gyro).matrix.inverse()(from.column, to.column);
    }
  return map * c.covariance * map.transpose();
}

/// Compares the uncertainties with these terms named; if there are none, with all optional terms.
void expect_stated(const std::vector<Step>& steps, const std::vector<CoefficientIndex>& terms) {
  Plan plan;
  plan.rig = table_of(2 * unit::arcsec);
  plan.parts = table_plan(steps, plan.rig);
  plan.site = table_site();
  plan.accel_noise.N = table_accel_noise;
  plan.gyro_noise.N = table_gyro_noise;
  plan.terms = terms;
  ImuDeclaration imu = table_imu();
  if (terms.empty()) {
    imu.grade = "tactical";  // its priors do not depend on the drawn offsets
    EstimatorOptions asked;
    asked.terms = chosen_coefficients({}, "m/s^2", "rad/s");
    asked = with_optional_terms(asked, imu);
    plan.terms = asked.terms, plan.optional = asked.optional;
  }
  const Prediction predicted = predict(plan);

  const TableMotion motion(plan.parts, plan.rig, plan.site);
  const TableRun run =
      run_of(steps, plan.rig, 5, 1, motion.nominal() + motion.sigma().cwiseProduct(drawn_normals(motion.sigma().size(), 5, "table")));
  CalibrationOptions options;
  options.terms = terms;
  options.effects = false;  // the plan has no effects either
  const Calibration stated = calibrate(run.seen, plan.rig, imu, plan.site, options);
  ASSERT_EQ(stated.estimated, predicted.coefficients);
  const Eigen::MatrixXd covariance = as_of_an_ideal_unit(stated);
  const Eigen::VectorXd sigma = predicted.sigma;
  for (Eigen::Index i = 0; i < sigma.size(); ++i)
    // They are linearized at different points: at estimated table errors of 1e-5, and misalignments of 1e-3 with sigmas between 0.1 and 10 ppm.
    EXPECT_NEAR(std::sqrt(covariance(i, i)) / sigma[i], 1, 0.01) << coefficient(stated.estimated[static_cast<std::size_t>(i)]).name;
}

TEST(TurntablePrediction, IsWhatACalibrationStatesOnZhangsProcedure) { expect_stated(zhang_steps(), linear_terms()); }
TEST(TurntablePrediction, IsWhatACalibrationStatesOnAnOddProcedure) { expect_stated(odd_steps(), linear_terms()); }

TEST(TurntablePrediction, IsWhatACalibrationStatesWithTheTermsThatAnImuMayHave) {
  expect_stated(zhang_steps(), {});
  expect_stated(odd_steps(), {});
}

}  // namespace
}  // namespace imulab::turntable
