#include "imulab/compensate.hpp"

#include "imulab/error.hpp"
#include "imulab/model/compensation_derivatives.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

/// Returns A0 + A1 V + A2 V^2 + A3 V^3.
Vector3d polynomial(const TriadModel& m, const Vector3d& v) {
  return m.offset + m.matrix * v + (m.quadratic + m.cubic.cwiseProduct(v)).cwiseProduct(v.cwiseAbs2());
}

Matrix3d polynomial_derivative(const TriadModel& m, const Vector3d& v) {
  const Vector3d bend = 2 * m.quadratic.cwiseProduct(v) + 3 * m.cubic.cwiseProduct(v.cwiseAbs2());
  return m.matrix + Matrix3d(bend.asDiagonal());
}

/// Returns V with polynomial(V) = out on the branch of the linear solution, by Newton's method until steps stop halving because of rounding.
Vector3d invert(const TriadModel& m, const Vector3d& out, const char* triad) {
  constexpr int most_steps = 50;  // about six suffice if the polynomial is invertible
  const double orientation = m.matrix.determinant();
  Vector3d v = m.matrix.inverse() * (out - m.offset);
  if (orientation != 0 && m.quadratic.isZero(0) && m.cubic.isZero(0)) return v;
  double last = std::numeric_limits<double>::infinity();
  for (int k = 0; k < most_steps; ++k) {
    const Matrix3d slope = polynomial_derivative(m, v);
    if (!(slope.determinant() * orientation > 0)) break;  // singular, or past a turning point: another branch
    const Vector3d residual = out - polynomial(m, v);
    const Vector3d step = slope.inverse() * residual;
    const double scale = out.norm() + m.offset.norm() + (m.matrix * v).norm();
    if (2 * step.norm() >= last && residual.norm() <= 1e-12 * scale) return v;
    v += step;
    last = step.norm();
  }
  throw Error(std::string("the ") + triad +
              " polynomial cannot be inverted here: its matrix is singular, or it turns back before reaching this output");
}

// One sample with the order of sums of the columns below, for bit-identical results.

/// The thermal terms of an axis.
struct AxisDrift {
  double c0, c1, c2, c3;
  AxisDrift(const TriadModel& m, Eigen::Index axis)
      : c0(m.thermal(axis, 0)), c1(m.thermal(axis, 1)), c2(m.thermal(axis, 2)), c3(m.thermal(axis, 3)) {}
  bool constant() const { return c1 == 0 && c2 == 0 && c3 == 0; }
  double at(double tau) const { return c0 + (c1 + (c2 + c3 * tau) * tau) * tau; }
};

Vector3d without_drift_of_sample(const TriadModel& m, const Vector3d& u, const Vector3d& tau) {
  Vector3d v;
  for (int i = 0; i < 3; ++i) {
    const AxisDrift c(m, i);
    v[i] = c.constant() ? u[i] - c.c0 : u[i] - c.at(tau[i]);
  }
  return v;
}

/// A row of M1 tau + M2 tau^2, times the output.
struct RowChange {
  double x1, y1, z1, x2, y2, z2;
  RowChange(const TriadModel& m, Eigen::Index row)
      : x1(m.matrix_thermal1(row, 0)),
        y1(m.matrix_thermal1(row, 1)),
        z1(m.matrix_thermal1(row, 2)),
        x2(m.matrix_thermal2(row, 0)),
        y2(m.matrix_thermal2(row, 1)),
        z2(m.matrix_thermal2(row, 2)) {}
  double of(double x, double y, double z, double tau) const { return tau * ((x1 * x + y1 * y + z1 * z) + tau * (x2 * x + y2 * y + z2 * z)); }
};

void change_of_sample(const TriadModel& m, const Vector3d& tau, Vector3d& out) {
  if (!m.matrix_varies()) return;
  const Vector3d p = out;
  for (int i = 0; i < 3; ++i) out[i] += RowChange(m, i).of(p[0], p[1], p[2], tau[i]);
}

void polynomial_of_sample(const TriadModel& m, const Vector3d& v, Vector3d& out) {
  for (int i = 0; i < 3; ++i) {
    const double linear = m.offset[i] + (m.matrix(i, 0) * v[0] + m.matrix(i, 1) * v[1] + m.matrix(i, 2) * v[2]);
    out[i] = linear + (m.quadratic[i] + m.cubic[i] * v[i]) * (v[i] * v[i]);
  }
}

}  // namespace

Motion compensate(const SensorModel& model, const RawSample& raw) {
  Motion out;
  polynomial_of_sample(model.accel, without_drift_of_sample(model.accel, raw.accel, raw.accel_tau), out.force);
  change_of_sample(model.accel, raw.accel_tau, out.force);
  polynomial_of_sample(model.gyro, without_drift_of_sample(model.gyro, raw.gyro, raw.gyro_tau), out.rate);
  change_of_sample(model.gyro, raw.gyro_tau, out.rate);
  const Matrix3d& c = model.g_sensitivity;
  for (int i = 0; i < 3; ++i) out.rate[i] += c(i, 0) * out.force[0] + c(i, 1) * out.force[1] + c(i, 2) * out.force[2];
  return out;
}

RawSample decompensate(const SensorModel& model, const Motion& motion, const Vector3d& gyro_tau, const Vector3d& accel_tau) {
  const auto at_reference = [](const TriadModel& m, const Vector3d& out, const Vector3d& tau) {
    return m.matrix_varies() ? Vector3d(m.matrix_factor(tau).inverse() * out) : out;
  };
  const Vector3d accel = invert(model.accel, at_reference(model.accel, motion.force, accel_tau), "accelerometers'") + model.accel.drift(accel_tau);
  const Vector3d rate = motion.rate - model.g_sensitivity * motion.force;
  const Vector3d gyro = invert(model.gyro, at_reference(model.gyro, rate, gyro_tau), "gyros'") + model.gyro.drift(gyro_tau);
  return {.gyro = gyro, .accel = accel, .gyro_tau = gyro_tau, .accel_tau = accel_tau};
}

namespace {

constexpr std::size_t block_size = 256;  // 12 columns of a block have 24 KiB and stay in the first-level cache
using ColumnBlock = std::array<std::array<double, block_size>, 3>;
using Inputs = std::array<std::span<const double>, 3>;

void check_columns(const SensorModel& model, const RawColumns& raw, const MotionColumns& out) {
  const std::size_t n = raw.accel[0].size();
  const auto need = [n](std::size_t size, const char* what) {
    if (size != n)
      throw Error(std::string("compensate: the ") + what + " column has " + std::to_string(size) + " samples, expected " + std::to_string(n));
  };
  const auto need_thermal = [&](const TriadModel& m, const Inputs& columns, const std::string& what) {
    const bool used = m.varies();
    if (used && columns[0].empty() && n > 0) throw Error("the calibration has thermal terms, but the recording has no " + what + " temperature");
    if (used && !m.temperature) throw Error("the calibration has thermal terms, but no reference temperature for the " + what);
    for (const auto& c : columns)
      if (used || !c.empty()) need(c.size(), (what + " temperature").c_str());
  };
  for (std::size_t i = 0; i < 3; ++i) {
    need(raw.accel[i].size(), "accelerometer");
    need(raw.gyro[i].size(), "gyro");
    need(out.force[i].size(), "force");
    need(out.rate[i].size(), "rate");
  }
  need_thermal(model.accel, raw.accel_temperature, "accelerometer");
  need_thermal(model.gyro, raw.gyro_temperature, "gyro");
}

/// Computes V = U - (c0 + c1 tau + c2 tau^2 + c3 tau^3) for samples begin .. begin + n, and tau where the matrix depends on it.
void load(const TriadModel& m, const Inputs& raw, const Inputs& temperature, std::size_t begin, std::size_t n, ColumnBlock& v, ColumnBlock& tau) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* const u = raw[axis].data() + begin;
    const AxisDrift c(m, static_cast<Eigen::Index>(axis));
    if (c.constant())
      for (std::size_t k = 0; k < n; ++k) v[axis][k] = u[k] - c.c0;
    if (c.constant() && !m.matrix_varies()) continue;
    const double* const t = temperature[axis].data() + begin;
    const ThermalReading reading = *m.temperature;
    if (c.constant())
      for (std::size_t k = 0; k < n; ++k) tau[axis][k] = reading.tau(t[k]);
    else if (m.matrix_varies())
      for (std::size_t k = 0; k < n; ++k) tau[axis][k] = reading.tau(t[k]), v[axis][k] = u[k] - c.at(tau[axis][k]);
    else
      for (std::size_t k = 0; k < n; ++k) v[axis][k] = u[k] - c.at(reading.tau(t[k]));
  }
}

/// Adds (M1 tau + M2 tau^2) times the output.
void change(const TriadModel& m, const ColumnBlock& tau, std::size_t n, ColumnBlock& out) {
  if (!m.matrix_varies()) return;
  const ColumnBlock p = out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const RowChange row(m, static_cast<Eigen::Index>(axis));
    for (std::size_t k = 0; k < n; ++k) out[axis][k] += row.of(p[0][k], p[1][k], p[2][k], tau[axis][k]);
  }
}

/// Computes A0 + A1 V + A2 V^2 + A3 V^3.
void polynomial(const TriadModel& m, const ColumnBlock& v, std::size_t n, ColumnBlock& out) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const double a0 = m.offset(i), ax = m.matrix(i, 0), ay = m.matrix(i, 1), az = m.matrix(i, 2), a2 = m.quadratic(i), a3 = m.cubic(i);
    if (a2 == 0 && a3 == 0) {
      for (std::size_t k = 0; k < n; ++k) out[axis][k] = a0 + (ax * v[0][k] + ay * v[1][k] + az * v[2][k]);
    } else {
      for (std::size_t k = 0; k < n; ++k)
        out[axis][k] = a0 + (ax * v[0][k] + ay * v[1][k] + az * v[2][k]) + (a2 + a3 * v[axis][k]) * (v[axis][k] * v[axis][k]);
    }
  }
}

void add_product(const Matrix3d& c, const ColumnBlock& a, std::size_t n, ColumnBlock& out) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const double cx = c(i, 0), cy = c(i, 1), cz = c(i, 2);
    for (std::size_t k = 0; k < n; ++k) out[axis][k] += cx * a[0][k] + cy * a[1][k] + cz * a[2][k];
  }
}

void store(const ColumnBlock& block, std::size_t begin, std::size_t n, const std::array<std::span<double>, 3>& out) {
  for (std::size_t axis = 0; axis < 3; ++axis) std::copy_n(block[axis].begin(), n, out[axis].begin() + static_cast<std::ptrdiff_t>(begin));
}

}  // namespace

void compensate(const SensorModel& model, const RawColumns& raw, const MotionColumns& out) {
  check_columns(model, raw, out);
  const bool sensitive = (model.g_sensitivity.array() != 0).any();
  ColumnBlock tau, v, force, rate;  // a block is computed before it is stored because `out` may be the memory of the input
  for (std::size_t begin = 0; begin < raw.accel[0].size(); begin += block_size) {
    const std::size_t n = std::min(block_size, raw.accel[0].size() - begin);
    load(model.accel, raw.accel, raw.accel_temperature, begin, n, v, tau);
    polynomial(model.accel, v, n, force);
    change(model.accel, tau, n, force);
    load(model.gyro, raw.gyro, raw.gyro_temperature, begin, n, v, tau);
    polynomial(model.gyro, v, n, rate);
    change(model.gyro, tau, n, rate);
    if (sensitive) add_product(model.g_sensitivity, force, n, rate);
    store(force, begin, n, out.force);
    store(rate, begin, n, out.rate);
  }
}

namespace {

bool linear(const TriadModel& m) { return m.quadratic.isZero(0) && m.cubic.isZero(0); }

/// Solves polynomial(V) = out for V, in place.
void invert_columns(const TriadModel& m, const char* triad, const std::array<std::span<double>, 3>& columns) {
  const std::size_t n = columns[0].size();
  double* const x = columns[0].data();
  double* const y = columns[1].data();
  double* const z = columns[2].data();
  if (!linear(m)) {
    for (std::size_t k = 0; k < n; ++k) {
      const Vector3d v = invert(m, {x[k], y[k], z[k]}, triad);
      x[k] = v(0), y[k] = v(1), z[k] = v(2);
    }
    return;
  }
  const Matrix3d inverse = m.matrix.inverse();
  const double ox = m.offset(0), oy = m.offset(1), oz = m.offset(2);
  const double xx = inverse(0, 0), xy = inverse(0, 1), xz = inverse(0, 2), yx = inverse(1, 0), yy = inverse(1, 1), yz = inverse(1, 2);
  const double zx = inverse(2, 0), zy = inverse(2, 1), zz = inverse(2, 2);
  for (std::size_t k = 0; k < n; ++k) {
    const double a = x[k] - ox, b = y[k] - oy, c = z[k] - oz;
    x[k] = xx * a + xy * b + xz * c;
    y[k] = yx * a + yy * b + yz * c;
    z[k] = zx * a + zy * b + zz * c;
  }
}

void expect_readings(const TriadModel& m, std::size_t readings, std::size_t samples) {
  if (readings != samples || !m.temperature)
    throw Error("decompensate: the model has thermal terms; expected a thermal reading for each sample and a reference temperature");
}

/// Multiplies the output by the inverse of I + M1 tau + M2 tau^2.
void remove_change(const TriadModel& m, const Inputs& temperature, const std::array<std::span<double>, 3>& columns) {
  if (!m.matrix_varies()) return;
  for (std::size_t axis = 0; axis < 3; ++axis) expect_readings(m, temperature[axis].size(), columns[axis].size());
  const auto tau = [&](std::size_t axis, std::size_t k) { return m.temperature->tau(temperature[axis][k]); };
  for (std::size_t k = 0; k < columns[0].size(); ++k) {
    const Vector3d out = m.matrix_factor({tau(0, k), tau(1, k), tau(2, k)}).inverse() * Vector3d(columns[0][k], columns[1][k], columns[2][k]);
    for (std::size_t axis = 0; axis < 3; ++axis) columns[axis][k] = out[static_cast<Eigen::Index>(axis)];
  }
}

/// Adds c0 + c1 tau + c2 tau^2 + c3 tau^3.
void add_drift(const TriadModel& m, const Inputs& temperature, const std::array<std::span<double>, 3>& columns) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const AxisDrift c(m, static_cast<Eigen::Index>(axis));
    if (c.c0 == 0 && c.constant()) continue;
    expect_readings(m, temperature[axis].size(), columns[axis].size());
    for (std::size_t k = 0; k < columns[axis].size(); ++k) columns[axis][k] += c.at(m.temperature->tau(temperature[axis][k]));
  }
}

}  // namespace

void decompensate(const SensorModel& model, const Inputs& gyro_temperature, const Inputs& accel_temperature, const MotionColumns& columns) {
  for (const auto* triad : {&columns.rate, &columns.force})
    for (const std::span<double>& column : *triad)
      if (column.size() != columns.rate[0].size()) throw Error("decompensate: columns of different lengths; expected six of one length");
  if (!model.g_sensitivity.isZero(0))
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto c = model.g_sensitivity.row(static_cast<Eigen::Index>(axis));
      for (std::size_t k = 0; k < columns.rate[axis].size(); ++k)
        columns.rate[axis][k] -= c(0) * columns.force[0][k] + c(1) * columns.force[1][k] + c(2) * columns.force[2][k];
    }
  remove_change(model.accel, accel_temperature, columns.force);
  remove_change(model.gyro, gyro_temperature, columns.rate);
  invert_columns(model.accel, "accelerometers'", columns.force);
  invert_columns(model.gyro, "gyros'", columns.rate);
  add_drift(model.accel, accel_temperature, columns.force);
  add_drift(model.gyro, gyro_temperature, columns.rate);
}

using Eigen::Index;

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using CoefficientRows = Eigen::Matrix<double, 3, coefficient_count>;

/// The output of one triad with derivatives, before the gyros' g-sensitivity.
struct TriadDerivatives {
  Matrix3d raw, temperature;
  CoefficientRows coefficients = CoefficientRows::Zero();
};

/// Computes V = U - (c1 tau + c2 tau^2 + c3 tau^3), P = A0 + A1 V + A2 V^2 + A3 V^3, out = S P.
TriadDerivatives derivatives(Triad triad, const TriadModel& m, const Vector3d& reading, const Vector3d& tau) {
  const Vector3d v = reading - m.drift(tau), p = polynomial(m, v);
  const Matrix3d factor = m.matrix_factor(tau);
  TriadDerivatives d;
  d.raw = factor * polynomial_derivative(m, v);
  const Vector3d steepness = m.thermal.col(1) + (2 * m.thermal.col(2) + 3 * m.thermal.col(3).cwiseProduct(tau)).cwiseProduct(tau);
  d.temperature = -d.raw * steepness.asDiagonal();
  d.temperature.diagonal() += (m.matrix_thermal1 + 2 * tau.asDiagonal() * m.matrix_thermal2) * p;
  const int first = coefficient_index(triad, Term::offset, 0, 0);
  const auto table = coefficient_table();
  for (int k = first; k < coefficient_count && table[static_cast<std::size_t>(k)].triad == triad; ++k) {
    const Coefficient& c = table[static_cast<std::size_t>(k)];
    switch (c.term) {
      case Term::offset:
        d.coefficients.col(k) = factor.col(c.row);
        break;
      case Term::matrix:
        d.coefficients.col(k) = factor.col(c.row) * v[c.column];
        break;
      case Term::quadratic:
        d.coefficients.col(k) = factor.col(c.row) * (v[c.row] * v[c.row]);
        break;
      case Term::cubic:
        d.coefficients.col(k) = factor.col(c.row) * (v[c.row] * v[c.row] * v[c.row]);
        break;
      case Term::thermal:
        d.coefficients.col(k) = -d.raw.col(c.row) * (c.column == 1 ? tau[c.row] : std::pow(tau[c.row], c.column));
        break;
      case Term::matrix_thermal1:
        d.coefficients(c.row, k) = tau[c.row] * p[c.column];
        break;
      case Term::matrix_thermal2:
        d.coefficients(c.row, k) = tau[c.row] * tau[c.row] * p[c.column];
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
  d.coefficients << gyro.coefficients + C * accel.coefficients, accel.coefficients;
  const int first = coefficient_index(Triad::gyro, Term::g_sensitivity, 0, 0);  // row by row
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) d.coefficients(i, first + 3 * i + j) = d.motion.force[j];
  d.raw << gyro.raw, C * accel.raw, Matrix3d::Zero(), accel.raw;
  d.temperature << gyro.temperature, C * accel.temperature, Matrix3d::Zero(), accel.temperature;
  return d;
}

Matrix6 output_covariance(const Calibration& calibration, const RawSample& raw) {
  validate(calibration);
  const auto all = compensation_derivatives(calibration.model, raw).coefficients;
  Eigen::MatrixXd g(6, static_cast<Index>(calibration.estimated.size()));
  for (std::size_t i = 0; i < calibration.estimated.size(); ++i) g.col(static_cast<Index>(i)) = all.col(calibration.estimated[i]);
  return g * calibration.covariance * g.transpose();
}

}  // namespace imulab
