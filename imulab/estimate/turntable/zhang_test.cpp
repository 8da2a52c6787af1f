// Compares the turntable estimator with Zhang 2010: his formulas, and the closed form of their errors (docs/evidence/papers/zhang2010.md).
#include "imulab/earth.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "tests/table_session.hpp"
#include <numbers>

namespace imulab::turntable {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Applies Zhang's formulas (2010, eqs 6, 9, 10) to readings of his procedure: three axes forward and back, then 24 positions.
SensorModel zhang_formulas(const TableObservations& seen, double gravity) {
  SensorModel model;
  Matrix3d sums;
  const auto holds = static_cast<Index>(seen.parts.holds.size());
  for (std::size_t k = 0; k < seen.parts.turns.size(); ++k) {
    const Step& step = seen.parts.steps[seen.parts.turns[k].step];
    const Vector3d sum = seen.readings.segment<3>(6 * holds + 3 * static_cast<Index>(k));
    const int body_axis = 2 - static_cast<int>(step.axis);  // outer is up, middle north, inner east
    if (step.angle > 0)
      sums.col(body_axis) = sum;
    else
      sums.col(body_axis) -= sum;
  }
  model.gyro.matrix = (sums / (4 * std::numbers::pi * 5)).inverse();
  Vector3d gyro = Vector3d::Zero(), accel = Vector3d::Zero();
  Matrix3d faces = Matrix3d::Zero();
  constexpr std::array<int, 6> up{1, 2, 0, 1, 2, 0};  // x, y, z of north-up-east in east-north-up
  for (std::size_t k = 0; k < 24; ++k) {
    const Index row = 6 * (holds - 24 + static_cast<Index>(k));
    const Vector3d hold_accel = seen.readings.segment<3>(row), hold_gyro = seen.readings.segment<3>(row + 3);
    gyro += hold_gyro / 24;
    accel += hold_accel / 24;
    faces.col(up[k / 4]) += (k < 12 ? 1 : -1) * hold_accel / (8 * gravity);
  }
  model.gyro.offset = -model.gyro.matrix * gyro;
  model.accel.matrix = faces.inverse();
  model.accel.offset = -model.accel.matrix * accel;
  return model;
}

/// Only the 24 positions determine Zhang's bias and accelerometers: the rests around the turns get no weight here.
std::vector<std::size_t> rests_of_turns(const TableObservations& seen) {
  std::vector<std::size_t> parts;
  for (std::size_t k = 0; k + 24 < seen.parts.holds.size(); ++k) parts.push_back(k);
  return parts;
}

Estimator classical_estimator(const TableRun& run) {
  EstimatorOptions settings;
  settings.terms = linear_terms();
  settings.table_errors = false;
  settings.bias_while_turning = true;
  settings.left_out = rests_of_turns(run.seen);
  const RawNoise noise{raw_density(table_accel_noise, run.truth.accel.matrix), raw_density(table_gyro_noise, run.truth.gyro.matrix)};
  return Estimator(run.motion, run.truth, noise, settings);
}

TEST(Turntable, WithNoiseAloneItIsZhangsFormulas) {
  const TableRun run = run_of(zhang_steps(), table_of(0), 3, 1);
  const Estimator estimator = classical_estimator(run);
  const SensorModel classical = zhang_formulas(run.seen, 9.79), ours = estimator.estimate(run.seen.readings);
  const auto uncertainty = estimator.uncertainty(ours);
  ASSERT_EQ(uncertainty.stated.size(), 24u);
  for (std::size_t i = 0; i < 24; ++i) {
    const CoefficientIndex index = uncertainty.stated[i];
    const double sigma = std::sqrt(uncertainty.covariance(static_cast<Index>(i), static_cast<Index>(i)));
    const double error = coefficient_value(ours, index) - coefficient_value(run.truth, index);
    const double difference = coefficient_value(ours, index) - coefficient_value(classical, index);
    // Zhang neglects the Earth's rate in the known rotation of a turn; here its lever is w_ie T / (2 pi n), 6e-4, for the sum of a pair.
    EXPECT_LT(std::abs(difference), 2e-3 * sigma) << coefficient(index).name;
    EXPECT_LT(std::abs(error), 4.5 * sigma);
  }
}

TEST(Turntable, TheTurnsAlsoTellTheBias) {
  // With a bias common to holds and turns, the estimate averages over both.
  const TableRun run = run_of(zhang_steps(), table_of(0, 0), 4, 1);
  EstimatorOptions settings;
  settings.terms = linear_terms();
  const RawNoise noise{raw_density(table_accel_noise, run.truth.accel.matrix), raw_density(table_gyro_noise, run.truth.gyro.matrix)};
  const Estimator joint(run.motion, run.truth, noise, settings);
  const auto at_rest = classical_estimator(run).uncertainty(run.truth), with_turns = joint.uncertainty(run.truth);
  for (std::size_t i = 0; i < 24; ++i) {
    const Coefficient& c = coefficient(at_rest.stated[i]);
    const auto k = static_cast<Index>(i);
    const double ratio = std::sqrt(with_turns.covariance(k, k) / at_rest.covariance(k, k));
    // White noise averages over the whole time in which a bias is observed: 24 min of positions, 9 of rests and 18 of turning.
    if (c.triad == Triad::gyro && c.term == Term::offset) {
      EXPECT_NEAR(ratio, std::sqrt(24.0 / (24 + 9 + 6 * 180.2 / 60)), 2e-2) << c.name;
    }
    // The rests' means determine little of the noise in the second of rest at each end of a sum; at most all of it is removed.
    if (c.triad == Triad::gyro && c.term == Term::matrix) {
      EXPECT_GT(ratio, std::sqrt(180.2 / 182.2)) << c.name;
      EXPECT_LT(ratio, 1) << c.name;
    }
  }
}

// --- Zhang's closed form (docs/evidence/papers/zhang2010.md), in his north-up-east axes ---

/// The nine constant errors of a table, by RigAxis: (o1, o2), (m1, m2), (i1, i2), and the zero errors.
struct ConstantTableErrors {
  std::array<std::array<double, 2>, 3> orthogonality{};
  std::array<double, 3> zero{};
};

VectorXd error_values(const TableMotion& motion, const ConstantTableErrors& errors) {
  VectorXd values = motion.nominal();
  for (std::size_t k = 0; k < motion.sources().size(); ++k)
    for (std::size_t a = 0; a < 3; ++a) {
      const std::string& name = motion.sources()[k].name;
      const std::string axis(to_string(static_cast<RigAxis>(a)));
      if (name == "zero." + axis) values[static_cast<Index>(k)] = errors.zero[a];
      if (name == "orthogonality." + axis + ".1") values[static_cast<Index>(k)] = errors.orthogonality[a][0];
      if (name == "orthogonality." + axis + ".2") values[static_cast<Index>(k)] = errors.orthogonality[a][1];
    }
  return values;
}

struct ClosedForm {
  Matrix3d gyro_matrix, accel_matrix;  ///< Dg, Da
  Vector3d bias;                       ///< the vector that w_ie sin L / 3 and g / 3 multiply
};

ClosedForm closed_form(const ConstantTableErrors& e) {
  const double o1 = e.orthogonality[0][0], o2 = e.orthogonality[0][1], m1 = e.orthogonality[1][0], m2 = e.orthogonality[1][1];
  const double i1 = e.orthogonality[2][0], i2 = e.orthogonality[2][1], sm = e.zero[1], si = e.zero[2];
  const double ai1 = i1, ai2 = i2, am1 = m2, am2 = m1, ao1 = o2, ao2 = o1;
  ClosedForm f;
  f.gyro_matrix << 0, ao1 + si, ai1, am1 - si, 0, ai2, am2, ao2 - sm, 0;
  f.accel_matrix << 0, -am1 + si, -am2, -ao1 - si, 0, -ao2 + sm, -ai1, ao2 - sm, 0;
  f.bias << 2 * ao1 + 2 * am1, 0, ai2 + ao2 - sm;
  return f;
}

/// Returns P in v_enu = P v_neu, from north-up-east to east-north-up.
Matrix3d to_enu() {
  Matrix3d p;
  p << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return p;
}

/// Returns the unit whose first-order errors the closed form predicts for a unit with this truth.
SensorModel predicted(const SensorModel& truth, const ConstantTableErrors& errors) {
  const ClosedForm f = closed_form(errors);
  const Matrix3d p = to_enu();
  const Matrix3d gyro = p * f.gyro_matrix * p.transpose(), accel = p * f.accel_matrix * p.transpose();
  const Vector3d bias = p * f.bias / 3;
  SensorModel model = truth;
  model.gyro.matrix -= gyro * truth.gyro.matrix;
  model.accel.matrix -= accel * truth.accel.matrix;
  // Zhang's biases have the opposite sign: error of w0 = w_ie sin L (...) / 3 - Dg w0.
  model.gyro.offset -= earth_rate * std::sin(*table_site().latitude) * bias + gyro * truth.gyro.offset;
  model.accel.offset -= 9.79 * bias + accel * truth.accel.offset;
  return model;
}

/// Returns groups of differences from the closed form: gyro matrix, accelerometer matrix, gyro bias / Earth's rate, accelerometer bias / g.
std::array<double, 4> misfit(const ConstantTableErrors& errors) {
  RigDeclaration rig = table_of(0);
  const TablePlan plan = table_plan(zhang_steps(), 0);
  const VectorXd table = error_values(TableMotion(plan, rig, table_site()), errors);
  const TableRun run = run_of(zhang_steps(), rig, 5, 0, table);
  const SensorModel estimate = classical_estimator(run).estimate(run.seen.readings), expected = predicted(run.truth, errors);
  return {(estimate.gyro.matrix - expected.gyro.matrix).norm(), (estimate.accel.matrix - expected.accel.matrix).norm(),
          (estimate.gyro.offset - expected.gyro.offset).norm() / earth_rate, (estimate.accel.offset - expected.accel.offset).norm() / 9.79};
}

ConstantTableErrors scaled(ConstantTableErrors errors, double factor) {
  for (auto& pair : errors.orthogonality)
    for (double& x : pair) x *= factor;
  for (double& x : errors.zero) x *= factor;
  return errors;
}

/// All nine errors together, then each alone: halving the errors reduces the remainder to a quarter, so the first order is that of the closed form.
TEST(Turntable, WithoutNoiseItsErrorIsTheClosedForm) {
  const double e = 1e-3;  // 3.4 arcmin: the second order, 1e-6, is far above rounding, and the third, 1e-9, far below
  std::vector<ConstantTableErrors> cases(10);
  cases[0] = {{{{e, -0.7 * e}, {0.4 * e, 0.9 * e}, {-0.6 * e, 0.5 * e}}}, {0.8 * e, -0.3 * e, 1.1 * e}};
  for (std::size_t k = 0; k < 9; ++k) (k < 6 ? cases[k + 1].orthogonality[k / 2][k % 2] : cases[k + 1].zero[k - 6]) = e;
  for (const ConstantTableErrors& errors : cases) {
    const auto whole = misfit(errors), half = misfit(scaled(errors, 0.5));
    for (std::size_t group = 0; group < 4; ++group) {
      EXPECT_LT(whole[group], 5 * e * e) << group;  // a handful of products of two errors
      // Below 1e-8, only the third order and the Earth's rate in the sums of turns, 4e-8 of the first order, remain.
      if (whole[group] < 1e-8) continue;
      EXPECT_NEAR(whole[group] / half[group], 4, 0.1) << group;  // the third order is e times the second, about a percent
    }
  }
}

}  // namespace
}  // namespace imulab::turntable
