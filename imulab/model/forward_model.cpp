#include "imulab/model/forward_model.hpp"

#include "imulab/model/gauge.hpp"

#include <Eigen/LU>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Matrix3d matrix_at(const VectorXd& v, Index at) { return Eigen::Map<const RowMajor3>(v.data() + at); }

void set_nonlinearity(SensorModel& model, const VectorXd& v) {
  model.accel.quadratic = v.segment<3>(Forward::accel_quadratic), model.accel.cubic = v.segment<3>(Forward::accel_cubic);
  model.gyro.quadratic = v.segment<3>(Forward::gyro_quadratic), model.gyro.cubic = v.segment<3>(Forward::gyro_cubic);
}

/// Returns the reading with zero output: of the linear model, then refined by Newton's method.
Vector3d zero_of(const TriadModel& m) {
  Vector3d v = -m.matrix.inverse() * m.offset;
  if (m.quadratic.isZero(0) && m.cubic.isZero(0)) return v;
  constexpr int steps = 5;  // nonlinearity is small: each step doubles the number of correct digits
  for (int i = 0; i < steps; ++i) {
    const TriadModel here = of_shifted_readings(m, -v);
    v -= here.matrix.inverse() * here.offset;
  }
  return v;
}

/// A model of readings relative to their zeros, without offsets.
struct AboutZero {
  SensorModel model;
  Vector3d accel_zero, gyro_zero;
};

AboutZero about_zero(const SensorModel& model) {
  AboutZero out{{}, zero_of(model.accel), zero_of(model.gyro)};
  out.model = of_shifted_readings(model, -out.accel_zero, -out.gyro_zero);
  return out;
}

/// Returns the change of a triad about its zero due to changes of forward matrix, zero and nonlinearity (in `change`).
TriadModel change_of(const TriadModel& at, TriadModel change, const Matrix3d& matrix, const Vector3d& zero) {
  change.offset = -at.matrix * zero;
  change.matrix = -at.matrix * matrix * at.matrix;
  change.matrix.diagonal() -= 2 * at.quadratic.cwiseProduct(zero);
  change.quadratic -= 3 * at.cubic.cwiseProduct(zero);
  return change;
}

}  // namespace

Index Forward::of(const Coefficient& c) {
  const bool accel = c.triad == Triad::accel;
  switch (c.term) {
    case Term::offset:
      return (accel ? accel_offset : gyro_offset) + c.row;
    case Term::matrix:
      return (accel ? accel_matrix : gyro_matrix) + Index{3} * c.row + c.column;
    case Term::quadratic:
      return (accel ? accel_quadratic : gyro_quadratic) + c.row;
    case Term::cubic:
      return (accel ? accel_cubic : gyro_cubic) + c.row;
    default:
      return gyro_force + Index{3} * c.row + c.column;
  }
}

VectorXd forward(const SensorModel& given) {
  VectorXd v = VectorXd::Zero(Forward::all);
  const AboutZero about = about_zero(given);
  const SensorModel& model = about.model;
  const Matrix3d accel = model.accel.matrix.inverse(), gyro = model.gyro.matrix.inverse();
  v.segment<3>(Forward::accel_offset) = about.accel_zero;
  Eigen::Map<RowMajor3>(v.data() + Forward::accel_matrix) = accel;
  v.segment<3>(Forward::gyro_offset) = about.gyro_zero;
  Eigen::Map<RowMajor3>(v.data() + Forward::gyro_matrix) = gyro;
  Eigen::Map<RowMajor3>(v.data() + Forward::gyro_force) = gyro * model.g_sensitivity;
  v.tail(Forward::all - Forward::nonlinearity) << model.accel.quadratic, model.accel.cubic, model.gyro.quadratic, model.gyro.cubic;
  return v;
}

SensorModel backward(const VectorXd& v) {
  SensorModel model;
  model.accel.matrix = matrix_at(v, Forward::accel_matrix).inverse();
  model.gyro.matrix = matrix_at(v, Forward::gyro_matrix).inverse();
  model.g_sensitivity = model.gyro.matrix * matrix_at(v, Forward::gyro_force);
  set_nonlinearity(model, v);
  return of_shifted_readings(model, v.segment<3>(Forward::accel_offset), v.segment<3>(Forward::gyro_offset));
}

MatrixXd backward_derivatives(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) {
  const AboutZero about = about_zero(at);
  const Matrix3d gyro = about.model.gyro.matrix, force_at = gyro.inverse() * at.g_sensitivity;
  MatrixXd out = MatrixXd::Zero(static_cast<Index>(coefficients.size()), Forward::all);
  for (Index column = 0; column < Forward::all; ++column) {
    const VectorXd d = VectorXd::Unit(Forward::all, column);
    SensorModel change;
    set_nonlinearity(change, d);
    change.accel = change_of(about.model.accel, change.accel, matrix_at(d, Forward::accel_matrix), d.segment<3>(Forward::accel_offset));
    change.gyro = change_of(about.model.gyro, change.gyro, matrix_at(d, Forward::gyro_matrix), d.segment<3>(Forward::gyro_offset));
    change.g_sensitivity = -gyro * matrix_at(d, Forward::gyro_matrix) * gyro * force_at + gyro * matrix_at(d, Forward::gyro_force);
    change = of_shifted_readings(change, about.accel_zero, about.gyro_zero);
    for (std::size_t i = 0; i < coefficients.size(); ++i) out(static_cast<Index>(i), column) = coefficient_value(change, coefficients[i]);
  }
  return out;
}

std::vector<MatrixXd> backward_curvatures(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients, const VectorXd& scale) {
  constexpr double step = 1e-3;  // relative to the size of a column: the error is its square, plus rounding divided by it
  const VectorXd v = forward(at);
  std::vector<MatrixXd> out(coefficients.size(), MatrixXd::Zero(Forward::all, Forward::all));
  const auto derivatives = [&](Index column, double sign) {
    return backward_derivatives(backward(v + sign * step * scale[column] * VectorXd::Unit(Forward::all, column)), coefficients);
  };
  for (Index column = 0; column < Forward::turning_bias; ++column) {
    const MatrixXd second = (derivatives(column, 1) - derivatives(column, -1)) / (2 * step * scale[column]);
    for (std::size_t i = 0; i < out.size(); ++i) out[i].row(column) = second.row(static_cast<Index>(i));
  }
  return out;
}

SensorModel without_error(const SensorModel& model, const SensorModel& error) {
  const Matrix3d one = Matrix3d::Identity(), keep_accel = one - error.accel.matrix, keep_gyro = one - error.gyro.matrix;
  SensorModel out = model;
  out.accel.offset = keep_accel * model.accel.offset - error.accel.offset;
  out.accel.matrix = keep_accel * model.accel.matrix;
  // The g-sensitivity receives the corrected force.
  out.gyro.offset = keep_gyro * (model.gyro.offset + model.g_sensitivity * error.accel.offset) - error.gyro.offset;
  out.gyro.matrix = keep_gyro * model.gyro.matrix;
  out.g_sensitivity = keep_gyro * model.g_sensitivity * (one + error.accel.matrix) - error.g_sensitivity;
  out.lever_arm += error.lever_arm;
  for (Eigen::Index i = 0; i < 3; ++i) {  // q (a0 + a1 V)^2
    const double q = error.accel.quadratic[i], a0 = model.accel.offset[i], a1 = model.accel.matrix(i, i);
    out.accel.offset[i] -= q * a0 * a0;
    out.accel.matrix(i, i) -= 2 * q * a0 * a1;
    out.accel.quadratic[i] -= q * a1 * a1;
  }
  return out;
}

}  // namespace imulab
