#include "imulab/model/gauge.hpp"

#include "imulab/error.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TriadModel of_shifted_readings(TriadModel m, const Vector3d& shift) {
  // Expand powers of V' - k in powers of V'.
  const Vector3d& k = shift;
  const Vector3d k2 = k.cwiseAbs2();
  m.offset += -m.matrix * k + m.quadratic.cwiseProduct(k2) - m.cubic.cwiseProduct(k2.cwiseProduct(k));
  m.matrix.diagonal() += -2 * m.quadratic.cwiseProduct(k) + 3 * m.cubic.cwiseProduct(k2);
  m.quadratic -= 3 * m.cubic.cwiseProduct(k);
  return m;
}

SensorModel of_shifted_readings(SensorModel model, const Vector3d& accel_shift, const Vector3d& gyro_shift) {
  model.accel = of_shifted_readings(model.accel, accel_shift);
  model.gyro = of_shifted_readings(model.gyro, gyro_shift);
  return model;
}

TriadModel with_factor(TriadModel m, const Matrix3d& factor) {
  m.offset = factor * m.offset, m.matrix = factor * m.matrix;
  m.quadratic = factor.diagonal().cwiseProduct(m.quadratic), m.cubic = factor.diagonal().cwiseProduct(m.cubic);
  return m;
}

namespace {

/// Uses the thermal terms with tau = tau' + by: their constant part moves to the polynomial. Of S P with S = I + M1 tau + M2 tau^2, that is the value
/// of S at the new reference.
TriadModel with_reference(TriadModel m, double reference) {
  if (!m.temperature) return m;
  const double by = reference - m.temperature->reference;
  const Vector3d constant = m.drift(Vector3d::Constant(by));
  const Matrix3d factor = m.matrix_factor(Vector3d::Constant(by));
  m.thermal.col(1) += by * (2 * m.thermal.col(2) + 3 * by * m.thermal.col(3));
  m.thermal.col(2) += 3 * by * m.thermal.col(3);
  m.temperature->reference = reference;
  if (m.matrix_varies()) {
    m = with_factor(m, factor);
    m.matrix_thermal1 = (m.matrix_thermal1 + 2 * by * m.matrix_thermal2) * factor.inverse();
    m.matrix_thermal2 = m.matrix_thermal2 * factor.inverse();
  }
  return of_shifted_readings(m, constant);
}

/// Returns derivatives of the coefficients after a change by those before: central differences about `at` over one `step` each; 0 for a step 0.
MatrixXd derivatives(const ModelChange& change, const std::vector<CoefficientIndex>& indices, const SensorModel& at, const VectorXd& step) {
  MatrixXd out = MatrixXd::Zero(step.size(), step.size());
  for (Index k = 0; k < step.size(); ++k) {
    if (!(step[k] > 0)) continue;
    const auto moved = [&](double by) {
      SensorModel model = at;
      const CoefficientIndex index = indices[static_cast<std::size_t>(k)];
      set_coefficient(model, index, coefficient_value(model, index) + by);
      return model;
    };
    const auto difference = [&](const SensorModel& up, const SensorModel& down, Index i) {
      const CoefficientIndex index = indices[static_cast<std::size_t>(i)];
      return coefficient_value(up, index) - coefficient_value(down, index);
    };
    const SensorModel up = moved(step[k]), down = moved(-step[k]), up_after = change(up), down_after = change(down);
    for (Index i = 0; i < step.size(); ++i) out(i, k) = difference(up_after, down_after, i) / difference(up, down, k);
  }
  return out;
}

bool stays(const TriadModel& m, double reference) { return !m.temperature || m.temperature->reference == reference; }

}  // namespace

SensorModel with_references(const SensorModel& model, double accel_reference, double gyro_reference) {
  SensorModel out = model;
  out.accel = with_reference(model.accel, accel_reference);
  out.gyro = with_reference(model.gyro, gyro_reference);
  return out;
}

Calibration with_references(const Calibration& calibration, double accel_reference, double gyro_reference) {
  validate(calibration);
  Calibration out = calibration;
  if (stays(calibration.model.accel, accel_reference) && stays(calibration.model.gyro, gyro_reference)) return out;
  const auto change = [&](const SensorModel& model) { return with_references(model, accel_reference, gyro_reference); };
  out.model = change(calibration.model);
  // Products of a coefficient with the small drift: differences over one sigma are exact to third order.
  const MatrixXd transfer = derivatives(change, calibration.estimated, calibration.model, calibration.covariance.diagonal().cwiseSqrt());
  out.covariance = transfer * calibration.covariance * transfer.transpose();
  if (calibration.constant_covariance.size() > 0) out.constant_covariance = transfer * calibration.constant_covariance * transfer.transpose();
  return out;
}

MatrixXd covariance_after(const ModelChange& linear_change, const std::vector<CoefficientIndex>& indices, const MatrixXd& covariance) {
  SensorModel zero;  // unit steps are exact there
  zero.accel.matrix.setZero(), zero.gyro.matrix.setZero();
  if (covariance.rows() != std::ssize(indices) || covariance.cols() != covariance.rows())
    throw Error("a covariance of another size than its coefficients; expected a row and a column for each");
  const MatrixXd transfer = derivatives(linear_change, indices, zero, VectorXd::Ones(covariance.rows()));
  return transfer * covariance * transfer.transpose();
}

namespace {

/// In degC instead of K, or the other way.
void convert_to(const std::string& unit, std::optional<ThermalReading>& reading) {
  if (!reading || reading->unit == unit || reading->unit == "raw" || unit == "raw") return;
  const double by = unit == "K" ? 273.15 : -273.15;
  if (reading->has_range()) reading->range[0] += by, reading->range[1] += by;
  reading->reference += by, reading->unit = unit;
}

}  // namespace

Calibration in_gauge_of(const Calibration& a, const Calibration& given) {
  Calibration b = given;
  for (const auto& [of_a, of_b] : {std::pair{&a.model.accel, &b.model.accel}, {&a.model.gyro, &b.model.gyro}})
    if (of_a->temperature) convert_to(of_a->temperature->unit, of_b->temperature);
  const auto reference = [](const TriadModel& of_a, const TriadModel& of_b) {
    if (!of_a.temperature || !of_b.temperature) return of_b.temperature ? of_b.temperature->reference : 0;
    const bool drifts = of_a.varies() || of_b.varies();
    if (of_a.temperature->unit == of_b.temperature->unit) return of_a.temperature->reference;
    if (drifts)
      throw Error("thermal terms of readings in " + of_a.temperature->unit + " and in " + of_b.temperature->unit +
                  " cannot be compared; expected one unit");
    return of_b.temperature->reference;
  };
  return with_references(b, reference(a.model.accel, b.model.accel), reference(a.model.gyro, b.model.gyro));
}

}  // namespace imulab
