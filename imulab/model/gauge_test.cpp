#include "imulab/model/gauge.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"
#include "imulab/error.hpp"

#include <gtest/gtest.h>

#include <string>

namespace imulab {
namespace {

SensorModel unit() {
  const RandomStream draws(1, "gauge");
  SensorModel model;
  for (const CoefficientIndex k : coefficient_indices())
    set_coefficient(model, k, coefficient_value(model, k) + 0.05 * draws.normal(static_cast<std::uint64_t>(k)));
  // Of a matrix that is not diagonal, products with nonlinear terms are left out.
  for (TriadModel* triad : {&model.accel, &model.gyro})
    for (Matrix3d* m : {&triad->matrix_thermal1, &triad->matrix_thermal2}) *m = Matrix3d(m->diagonal().asDiagonal());
  model.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  model.gyro.temperature = ThermalReading{"raw", 5000, {4990, 5010}};
  return model;
}

RawSample sample(const SensorModel& model, double accel_temperature, double gyro_temperature) {
  RawSample raw{.gyro = {-0.4, 0.9, 0.2}, .accel = {0.3, -0.7, 1.1}};
  raw.accel_tau.setConstant(accel_temperature - model.accel.temperature->reference);
  raw.gyro_tau.setConstant(gyro_temperature - model.gyro.temperature->reference);
  return raw;
}

TEST(Gauge, AnotherReferenceIsTheSameCompensation) {
  const SensorModel a = unit(), b = with_references(a, 22, 5004);
  for (const double t : {-1.0, 0.0, 2.5}) {
    const Motion x = compensate(a, sample(a, 25 + t, 5000 - t)), y = compensate(b, sample(b, 25 + t, 5000 - t));
    EXPECT_LT((x.force - y.force).norm(), 1e-12);  // rounding of numbers of order one
    EXPECT_LT((x.rate - y.rate).norm(), 1e-12);
  }
  EXPECT_NEAR(coefficient_value(with_references(b, 25, 5000), coefficient_index("accel.offset.y")),
              coefficient_value(a, coefficient_index("accel.offset.y")), 1e-12);
}

TEST(Gauge, KelvinAndDegreesAreOneScale) {
  Calibration a, b;
  a.model = b.model = unit();
  b.model.accel.temperature = ThermalReading{"K", 25 + 273.15, {273.15, 70 + 273.15}};
  EXPECT_EQ(in_gauge_of(a, b).model.accel.temperature->reference, 25);
  EXPECT_NEAR((in_gauge_of(a, b).model.accel.matrix - a.model.accel.matrix).norm(), 0, 1e-12);
  EXPECT_EQ(in_gauge_of(b, a).model.accel.temperature->unit, "K");
  b.model.accel.temperature->unit = "raw";
  EXPECT_THROW(in_gauge_of(a, b), Error);
}

/// The uncertainty of the output is equal in every gauge.
TEST(Gauge, CarriesTheCovariance) {
  Calibration a;
  a.model = unit();
  const RandomStream draws(2, "gauge covariance");
  for (const CoefficientIndex k : coefficient_indices())
    if (const Coefficient& c = coefficient(k); c.term != Term::lever_arm && (!is_matrix_thermal(c.term) || c.row == c.column))
      a.estimated.push_back(k);
  const auto n = static_cast<Eigen::Index>(a.estimated.size());
  Eigen::MatrixXd root(n, n);
  for (Eigen::Index k = 0; k < n * n; ++k) root(k) = 1e-5 * draws.normal(static_cast<std::uint64_t>(k));
  a.covariance = root * root.transpose();
  const Calibration b = with_references(a, 21, 5003);
  const auto p = output_covariance(a, sample(a.model, 30, 4999)), q = output_covariance(b, sample(b.model, 30, 4999));
  EXPECT_LT((p - q).norm(), 1e-6 * p.norm());  // of the differences, third order of 1e-4
}

/// For readings about the middle of an unsigned converter, the uncertainty of the compensated output does not change.
TEST(Gauge, CarriesTheCovarianceToShiftedReadings) {
  Calibration a;
  a.model = unit();
  const RandomStream draws(3, "shifted readings");
  for (const char* term : {"offset", "matrix", "quadratic", "cubic"})
    for (const CoefficientIndex k : select_coefficients(std::string("gyro.") + term)) a.estimated.push_back(k);
  const auto n = static_cast<Eigen::Index>(a.estimated.size());
  a.covariance =
      Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index k) { return 1e-10 * (1 + draws.uniform(static_cast<std::uint64_t>(k))); }).asDiagonal();
  const Vector3d shift(5, -7, 3);
  const auto shifted = [&](const SensorModel& model) {
    SensorModel out = model;
    out.gyro = of_shifted_readings(model.gyro, shift);
    return out;
  };
  Calibration b = a;
  b.model = shifted(a.model);
  b.covariance = covariance_after(shifted, a.estimated, a.covariance);
  RawSample x = sample(a.model, 25, 5000), y = x;
  y.gyro += shift;
  const auto p = output_covariance(a, x), q = output_covariance(b, y);
  EXPECT_LT((p - q).norm(), 1e-9 * p.norm());  // rounding of 7^6
  EXPECT_LT((compensate(b.model, y).rate - compensate(a.model, x).rate).norm(), 1e-9);
}

TEST(Gauge, UnitsAreNotMixed) {
  Calibration a, b;
  a.model = b.model = unit();
  b.model.accel.temperature->unit = "raw";
  EXPECT_THROW(in_gauge_of(a, b), Error);
  b.model.accel.temperature->unit = "degC", b.model.accel.temperature->reference = 20;
  EXPECT_EQ(in_gauge_of(a, b).model.accel.temperature->reference, 25);
}

}  // namespace
}  // namespace imulab
