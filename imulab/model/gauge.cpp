#include "imulab/model/gauge.hpp"

#include "imulab/core/error.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;

TriadModel of_shifted_readings(TriadModel m, const Vector3d& shift) {
  // Powers of V' - k in powers of V'.
  const Vector3d k = shift, k2 = k.cwiseAbs2();
  m.offset += -m.matrix * k + m.quadratic.cwiseProduct(k2) - m.cubic.cwiseProduct(k2.cwiseProduct(k));
  m.matrix.diagonal() += -2 * m.quadratic.cwiseProduct(k) + 3 * m.cubic.cwiseProduct(k2);
  m.quadratic -= 3 * m.cubic.cwiseProduct(k);
  return m;
}

namespace {

/// c1 tau + c2 tau^2 with tau = tau' + by: its constant part goes to the polynomial.
TriadModel with_reference(TriadModel m, double reference) {
  if (!m.temperature) return m;
  const double by = reference - m.temperature->reference;
  const Vector3d constant = m.thermal.col(1) * by + m.thermal.col(2) * (by * by);
  m.thermal.col(1) += 2 * by * m.thermal.col(2);
  m.temperature->reference = reference;
  return of_shifted_readings(m, constant);
}

/// Coefficients that drag others along when the reference changes.
bool moves(Term term) { return term != Term::g_sensitivity && term != Term::lever_arm; }

bool stays(const TriadModel& m, double reference) { return !m.temperature || m.temperature->reference == reference; }

}  // namespace

SensorModel with_references(const SensorModel& model, double accel_reference, double gyro_reference) {
  SensorModel out = model;
  out.accel = with_reference(model.accel, accel_reference);
  out.gyro = with_reference(model.gyro, gyro_reference);
  return out;
}

Calibration with_references(const Calibration& calibration, double accel_reference, double gyro_reference) {
  Calibration out = calibration;
  if (stays(calibration.model.accel, accel_reference) && stays(calibration.model.gyro, gyro_reference)) return out;
  out.model = with_references(calibration.model, accel_reference, gyro_reference);
  const auto n = static_cast<Index>(calibration.estimated.size());
  MatrixXd transfer = MatrixXd::Identity(n, n);
  for (Index k = 0; k < n; ++k) {
    const int index = calibration.estimated[static_cast<std::size_t>(k)];
    if (!moves(coefficient_table()[static_cast<std::size_t>(index)].term)) continue;
    // Products of a coefficient with the drift, which is small: central differences over one sigma are exact to the third order of it.
    const double h = std::sqrt(calibration.covariance(k, k));
    if (!(h > 0)) continue;
    const auto moved = [&](double by) {
      SensorModel model = calibration.model;
      set_coefficient(model, index, coefficient_value(model, index) + by);
      return with_references(model, accel_reference, gyro_reference);
    };
    const SensorModel up = moved(h), down = moved(-h);
    for (Index i = 0; i < n; ++i) {
      const int at = calibration.estimated[static_cast<std::size_t>(i)];
      transfer(i, k) = (coefficient_value(up, at) - coefficient_value(down, at)) / (2 * h);
    }
  }
  out.covariance = transfer * calibration.covariance * transfer.transpose();
  return out;
}

Calibration in_gauge_of(const Calibration& a, const Calibration& b) {
  const auto reference = [](const TriadModel& of_a, const TriadModel& of_b) {
    if (!of_a.temperature || !of_b.temperature) return of_b.temperature ? of_b.temperature->reference : 0;
    const bool drifts = !of_a.thermal.isZero(0) || !of_b.thermal.isZero(0);
    if (of_a.temperature->unit == of_b.temperature->unit) return of_a.temperature->reference;
    if (drifts)
      throw Error("thermal terms of readings in " + of_a.temperature->unit + " and in " + of_b.temperature->unit +
                  " cannot be compared: the same unit was expected");
    return of_b.temperature->reference;
  };
  return with_references(b, reference(a.model.accel, b.model.accel), reference(a.model.gyro, b.model.gyro));
}

}  // namespace imulab
