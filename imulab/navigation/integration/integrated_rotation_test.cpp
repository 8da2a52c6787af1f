#include "imulab/navigation/integration/integrated_rotation.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

/// Records rates and forces given as functions of time, as means over the intervals (fine midpoint sums).
template <class Rate, class Force>
Recording record(Rate rate, Force force, double duration, double dt) {
  Recording r;
  r.interval_s = dt;
  const auto n = static_cast<std::size_t>(std::lround(duration / dt));
  for (std::size_t i = 0; i < n; ++i) {
    Vector3d w = Vector3d::Zero(), f = Vector3d::Zero();
    const int fine = 64;
    for (int k = 0; k < fine; ++k) {
      const double t = (static_cast<double>(i) + (k + 0.5) / fine) * dt;
      w += rate(t) / fine;
      f += force(t) / fine;
    }
    r.time_ns.push_back(static_cast<std::int64_t>(std::llround(1e9 * dt * static_cast<double>(i + 1))));
    for (std::size_t j = 0; j < 3; ++j) {
      r.gyro[j].push_back(w[static_cast<Eigen::Index>(j)]);
      r.accel[j].push_back(f[static_cast<Eigen::Index>(j)]);
    }
  }
  return r;
}

const auto some_rate = [](double t) { return Vector3d(1.2 * std::sin(2 * t), 0.8 * std::cos(3 * t), 0.5 - 0.4 * t); };
const auto some_force = [](double t) { return Vector3d(9 * std::cos(t), 3 * std::sin(2 * t), 4 + t); };

SensorModel some_model() {
  SensorModel m;
  m.accel.offset = {0.1, -0.2, 0.3};
  m.accel.matrix << 1.01, 0, 0, 0.02, 0.98, 0, -0.01, 0.015, 1.03;
  m.gyro.offset = {0.01, -0.02, 0.005};
  m.gyro.matrix << 1.02, 0.01, -0.02, 0.005, 0.97, 0.01, -0.015, 0.02, 1.01;
  m.g_sensitivity << 1e-3, -2e-4, 3e-4, 5e-4, -1e-3, 2e-4, -3e-4, 1e-4, 2e-3;
  return m;
}

TEST(IntegratedRotation, SteadyTurnIntegratesExactly) {
  const Vector3d rate(0.3, -0.5, 0.7);
  const Recording r = record([&](double) { return rate; }, some_force, 4, 0.01);
  const IntegratedRotation turn = integrate_rotation(r, {0, r.size()}, SensorModel{}, {}, Vector3d::Zero());
  EXPECT_LT((turn.C - rotation_exp(4 * rate)).norm(), 1e-12);  // rounding of 400 products
  EXPECT_NEAR(turn.duration_s, 4, 1e-12);
}

TEST(IntegratedRotation, ConingIsCompensated) {
  // Classical coning: moving the axis along a small cone of half angle a at angular frequency b turns the body by about pi a^2 per cycle.
  const double a = 0.02, b = 2 * M_PI * 2;
  const auto attitude = [&](double t) { return rotation_exp(a * Vector3d(std::cos(b * t), std::sin(b * t), 0)); };
  const auto rate = [&](double t) {
    const double h = 1e-5;
    return Vector3d(rotation_log(attitude(t - h).transpose() * attitude(t + h)) / (2 * h));
  };
  const Recording r = record(rate, some_force, 10, 0.01);
  const Matrix3d truth = attitude(0).transpose() * attitude(10);
  const Matrix3d found = integrate_rotation(r, {0, r.size()}, SensorModel{}, {}, Vector3d::Zero()).C;
  Matrix3d without = Matrix3d::Identity();
  for (std::size_t i = 0; i < r.size(); ++i) without = without * rotation_exp(0.01 * Vector3d(r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]));
  const double error = rotation_log(truth.transpose() * found).norm(), error_without = rotation_log(truth.transpose() * without).norm();
  EXPECT_GT(error_without, 2e-6);
  // One interval plus the previous has an error smaller by about (b dt)^2 / 20, plus start and end without a previous interval.
  EXPECT_LT(error, 0.1 * error_without);
}

TEST(IntegratedRotation, DerivativesOfTheRotationEqualDifferences) {
  const Recording r = record(some_rate, some_force, 3, 0.002);
  const SensorModel model = some_model();
  const Range all{0, r.size()};
  const IntegratedRotation at = integrate_rotation(r, all, model, {}, Vector3d::Zero());
  for (const char* selector : {"gyro.offset", "gyro.matrix", "gyro.g_sensitivity"}) {
    for (const CoefficientIndex index : select_coefficients(selector)) {
      const Coefficient& c = coefficient(index);
      const double h = 1e-5;
      SensorModel plus = model, minus = model;
      set_coefficient(plus, index, coefficient_value(model, index) + h);
      set_coefficient(minus, index, coefficient_value(model, index) - h);
      const Matrix3d p = integrate_rotation(r, all, plus, {}, Vector3d::Zero()).C, m = integrate_rotation(r, all, minus, {}, Vector3d::Zero()).C;
      const Vector3d difference = rotation_log(p * m.transpose()) / (2 * h);
      const int integral = c.term == Term::offset ? 0 : c.term == Term::matrix ? 1 + c.column : 4 + c.column;
      const Vector3d derivative = at.phi[static_cast<std::size_t>(integral)].col(c.row);
      // The midpoint rule neglects (rate dt)^2 / 12 of the integrand, 1e-6; the derivative of the coning term has the same size.
      EXPECT_LT((difference - derivative).norm(), 2e-5 * (1 + derivative.norm())) << c.name;
    }
  }
}

TEST(IntegratedRotation, NoiseOfTheRotationIsThatOfItsSamples) {
  // With equal axes, each sample contributes sigma^2 dt^2 to each component, for any rotation.
  const Recording r = record(some_rate, some_force, 3, 0.01);
  const Matrix3d p = integrate_rotation(r, {0, r.size()}, SensorModel{}, {}, Vector3d::Constant(1e-3)).covariance;
  const double expected = 300 * 1e-6 * 1e-4;
  // The mean of two attitudes is shorter than one by (rate dt)^2 / 8 per component: below 1e-4.
  EXPECT_LT((p - expected * Matrix3d::Identity()).norm(), 1e-3 * expected);
}

}  // namespace
}  // namespace imulab
