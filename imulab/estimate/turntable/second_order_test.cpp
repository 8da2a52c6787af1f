// Compares the second order of a turntable estimate with the estimator: with the common part of its errors under mirrored draws.
#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "tests/table_session.hpp"
#include <string>

namespace imulab::turntable {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd values_of(const SensorModel& model) {
  static const std::vector<CoefficientIndex> terms = linear_terms();
  VectorXd v(24);
  for (Index i = 0; i < 24; ++i) v[i] = coefficient_value(model, terms[static_cast<std::size_t>(i)]);
  return v;
}

/// Returns six faces and a turn each way about each axis: so few directions that all pairs can be tested.
std::vector<Step> short_procedure() {
  TableSteps steps;
  for (const RigAxis axis : {RigAxis::middle, RigAxis::outer, RigAxis::inner}) {
    std::array<double, 3> turned{};
    turned[static_cast<std::size_t>(axis)] = 1800;
    steps.hold(60, {}).turn(axis, 1800).hold(60, turned).turn(axis, -1800);
  }
  for (const auto& [inner, middle] : std::vector<std::array<double, 2>>{{90, 0}, {0, 0}, {0, -90}, {-90, 0}, {0, 180}, {0, 90}})
    steps.hold(60, {0, middle, inner});
  return steps.steps();
}

/// Weights come from the table's errors (the default) or from noise alone.
TEST(TurntableSecondOrder, IsThatOfTheEstimator) {
  const RigDeclaration rig = table_of(60 * unit::arcsec);
  const TableMotion motion(table_plan(short_procedure(), 0.05), rig, table_site());
  const SensorModel truth = drawn_unit(21);
  const RawNoise noise{raw_density(table_accel_noise, truth.accel.matrix), raw_density(table_gyro_noise, truth.gyro.matrix)};
  const MatrixXd noise_factor = noise_covariance(motion, noise.accel, noise.gyro).llt().matrixL();
  for (const bool table_errors : {true, false}) {
    EstimatorOptions settings;
    settings.terms = linear_terms();
    settings.table_errors = table_errors;
    const Estimator estimator(motion, truth, noise, settings);
    const auto second = estimator.second_order(truth, linear_terms());
    // The directions are those of all independent normal draws, one sigma each: of the table, then of the noise.
    const Index sources = motion.sigma().size(), all = sources + motion.rows();
    const auto even = [&](const VectorXd& table, const VectorXd& white) {
      const auto estimate = [&](double sign) {
        const VectorXd seen = readings(motion, truth, motion.truth(motion.nominal() + sign * table)) + sign * white;
        return values_of(estimator.estimate(estimator.linearized(seen)));
      };
      return VectorXd(0.5 * (estimate(1) + estimate(-1)));
    };
    // The result is not exactly the truth: weights over eight orders leave errors of 1e-9 along rotations hidden by table errors of 1 arcmin.
    const VectorXd without = even(VectorXd::Zero(sources), VectorXd::Zero(motion.rows()));
    const auto along = [&](Index i, Index j) {
      VectorXd table = VectorXd::Zero(sources), white = VectorXd::Zero(motion.rows());
      for (const Index k : {i, j}) {
        if (k < sources)
          table[k] += motion.sigma()[k] * (i == j ? 0.5 : 1);
        else if (k < all)
          white += noise_factor.col(k - sources) * (i == j ? 0.5 : 1);
      }
      return VectorXd(even(table, white) - without);
    };
    MatrixXd own(24, all);
    for (Index i = 0; i < all; ++i) own.col(i) = along(i, i);
    const VectorXd bias = own.rowwise().sum();
    VectorXd variance = 2 * own.rowwise().squaredNorm();
    for (Index i = 0; i < all; ++i)
      for (Index j = 0; j < i; ++j) variance += (along(i, j) - own.col(i) - own.col(j)).cwiseAbs2();
    for (Index i = 0; i < 24; ++i) {
      const std::string name(coefficient(linear_terms()[static_cast<std::size_t>(i)]).name);
      const double sigma = std::sqrt(variance[i]);
      // The fourth order is 1e-7 of the second; rounding of W1 = 1 and sums of 31 rad is 1e-14 for second orders of 1e-8; differences for T: 1e-8.
      EXPECT_NEAR(second.bias[i] / sigma, bias[i] / sigma, 1e-4) << name << table_errors;
      EXPECT_NEAR(std::sqrt(second.covariance(i, i)) / sigma, 1, 1e-4) << name << table_errors;
    }
  }
}

}  // namespace
}  // namespace imulab::turntable
