#include "imulab/model/compensation_derivatives.hpp"

namespace imulab {

using Eigen::Index;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using CoefficientRows = Eigen::Matrix<double, 3, coefficient_count>;

/// One triad: its output with derivatives, before the gyros' g-sensitivity.
struct TriadDerivatives {
  Matrix3d raw, temperature;
  CoefficientRows coefficients = CoefficientRows::Zero();
};

/// V = U - (c1 tau + c2 tau^2), out = A0 + A1 V + A2 V^2 + A3 V^3.
TriadDerivatives derivatives(Triad triad, const TriadModel& m, const Vector3d& reading, const Vector3d& tau) {
  const Vector3d v = reading - m.thermal.col(0) - m.thermal.col(1).cwiseProduct(tau) - m.thermal.col(2).cwiseProduct(tau.cwiseAbs2());
  TriadDerivatives d;
  const Vector3d bend = 2 * m.quadratic.cwiseProduct(v) + 3 * m.cubic.cwiseProduct(v.cwiseAbs2());
  d.raw = m.matrix + Matrix3d(bend.asDiagonal());
  d.temperature = -d.raw * Vector3d(m.thermal.col(1) + 2 * m.thermal.col(2).cwiseProduct(tau)).asDiagonal();
  const int first = coefficient_index(triad, Term::offset, 0, 0);
  const auto table = coefficient_table();
  for (int k = first; k < coefficient_count && table[static_cast<std::size_t>(k)].triad == triad; ++k) {
    const Coefficient& c = table[static_cast<std::size_t>(k)];
    switch (c.term) {
      case Term::offset:
        d.coefficients(c.row, k) = 1;
        break;
      case Term::matrix:
        d.coefficients(c.row, k) = v[c.column];
        break;
      case Term::quadratic:
        d.coefficients(c.row, k) = v[c.row] * v[c.row];
        break;
      case Term::cubic:
        d.coefficients(c.row, k) = v[c.row] * v[c.row] * v[c.row];
        break;
      case Term::thermal:
        d.coefficients.col(k) = -d.raw.col(c.row) * (c.column == 1 ? tau[c.row] : tau[c.row] * tau[c.row]);
        break;
      case Term::g_sensitivity:
      case Term::lever_arm:
        break;
    }
  }
  return d;
}

}  // namespace

CompensationDerivatives compensation_derivatives(const SensorModel& model, const RawSample& raw) {
  const TriadDerivatives accel = derivatives(Triad::accel, model.accel, raw.accel, raw.accel_tau);
  const TriadDerivatives gyro = derivatives(Triad::gyro, model.gyro, raw.gyro, raw.gyro_tau);
  CompensationDerivatives d{compensate(model, raw), {}, Matrix6::Zero(), Matrix6::Zero()};
  const Matrix3d& C = model.g_sensitivity;
  d.coefficients << accel.coefficients, gyro.coefficients + C * accel.coefficients;
  const int first = coefficient_index(Triad::gyro, Term::g_sensitivity, 0, 0);  // row by row
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) d.coefficients(3 + i, first + 3 * i + j) = d.motion.force[j];
  d.raw << accel.raw, Matrix3d::Zero(), C * accel.raw, gyro.raw;
  d.temperature << accel.temperature, Matrix3d::Zero(), C * accel.temperature, gyro.temperature;
  return d;
}

Matrix6 output_covariance(const Calibration& calibration, const RawSample& raw) {
  const auto all = compensation_derivatives(calibration.model, raw).coefficients;
  Eigen::MatrixXd g(6, static_cast<Index>(calibration.estimated.size()));
  for (std::size_t i = 0; i < calibration.estimated.size(); ++i) g.col(static_cast<Index>(i)) = all.col(calibration.estimated[i]);
  return g * calibration.covariance * g.transpose();
}

}  // namespace imulab
