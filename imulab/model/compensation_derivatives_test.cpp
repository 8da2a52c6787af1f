#include "imulab/model/compensation_derivatives.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

Vector6 out(const SensorModel& model, const RawSample& raw) {
  const Motion m = compensate(model, raw);
  Vector6 v;
  v << m.rate, m.force;
  return v;
}

SensorModel drawn_model(const RandomStream& draws) {
  SensorModel model;
  for (const CoefficientIndex k : coefficient_indices())
    set_coefficient(model, k, coefficient_value(model, k) + 0.1 * draws.normal(static_cast<std::uint64_t>(k)));
  return model;
}

TEST(CompensationDerivatives, AreThoseOfTheModel) {
  const RandomStream draws(1, "compensation derivatives");
  const SensorModel model = drawn_model(draws);
  RawSample raw;
  std::uint64_t n = 100;
  for (Vector3d* v : {&raw.gyro, &raw.accel, &raw.gyro_tau, &raw.accel_tau})
    for (double& x : *v) x = draws.normal(n++);
  const CompensationDerivatives d = compensation_derivatives(model, raw);
  // Central differences of polynomials up to third order in each coefficient and reading of size one have truncation errors of h^2 and rounding
  // errors of 1e-16 / h.
  constexpr double h = 1e-5, tolerance = 1e-8;
  for (const CoefficientIndex k : coefficient_indices()) {
    SensorModel up = model, down = model;
    set_coefficient(up, k, coefficient_value(model, k) + h);
    set_coefficient(down, k, coefficient_value(model, k) - h);
    EXPECT_LT(((out(up, raw) - out(down, raw)) / (2 * h) - d.coefficients.col(k)).cwiseAbs().maxCoeff(), tolerance) << coefficient(k).name;
  }
  for (int k = 0; k < 6; ++k) {
    const auto moved = [&](double by, bool temperature) {
      RawSample r = raw;
      Vector3d& v = temperature ? (k < 3 ? r.gyro_tau : r.accel_tau) : (k < 3 ? r.gyro : r.accel);
      v[k % 3] += by;
      return out(model, r);
    };
    EXPECT_LT(((moved(h, false) - moved(-h, false)) / (2 * h) - d.raw.col(k)).cwiseAbs().maxCoeff(), tolerance) << k;
    EXPECT_LT(((moved(h, true) - moved(-h, true)) / (2 * h) - d.temperature.col(k)).cwiseAbs().maxCoeff(), tolerance) << k;
  }
  EXPECT_EQ(d.motion.force, compensate(model, raw).force);
}

TEST(OutputCovariance, OfOneScaleGrowsWithTheReading) {
  Calibration c;
  c.estimated = {coefficient_index("accel.matrix.xx")};
  c.covariance = Eigen::MatrixXd::Constant(1, 1, 4e-6);
  const RawSample raw{.accel = {300, 0, 0}};
  EXPECT_NEAR(output_covariance(c, raw)(3, 3), 4e-6 * 300 * 300, 1e-12);  // rounding of 0.36
  EXPECT_EQ(output_covariance(c, raw)(4, 4), 0);
}

}  // namespace
}  // namespace imulab
