#include "imulab/model/forward_model.hpp"

#include <Eigen/LU>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Matrix3d matrix_at(const VectorXd& v, Index at) { return Eigen::Map<const RowMajor3>(v.data() + at); }

}  // namespace

Index Forward::of(const Coefficient& c) {
  const bool accel = c.triad == Triad::accel;
  switch (c.term) {
    case Term::offset:
      return (accel ? accel_offset : gyro_offset) + c.row;
    case Term::matrix:
      return (accel ? accel_matrix : gyro_matrix) + 3 * c.row + c.column;
    default:
      return gyro_force + 3 * c.row + c.column;
  }
}

VectorXd forward(const SensorModel& model) {
  VectorXd v = VectorXd::Zero(Forward::all);
  const Matrix3d accel = model.accel.matrix.inverse(), gyro = model.gyro.matrix.inverse();
  v.segment<3>(Forward::accel_offset) = -accel * model.accel.offset;
  Eigen::Map<RowMajor3>(v.data() + Forward::accel_matrix) = accel;
  v.segment<3>(Forward::gyro_offset) = -gyro * model.gyro.offset;
  Eigen::Map<RowMajor3>(v.data() + Forward::gyro_matrix) = gyro;
  Eigen::Map<RowMajor3>(v.data() + Forward::gyro_force) = gyro * model.g_sensitivity;
  return v;
}

SensorModel backward(const VectorXd& v) {
  SensorModel model;
  model.accel.matrix = matrix_at(v, Forward::accel_matrix).inverse();
  model.accel.offset = -model.accel.matrix * v.segment<3>(Forward::accel_offset);
  model.gyro.matrix = matrix_at(v, Forward::gyro_matrix).inverse();
  model.gyro.offset = -model.gyro.matrix * v.segment<3>(Forward::gyro_offset);
  model.g_sensitivity = model.gyro.matrix * matrix_at(v, Forward::gyro_force);
  return model;
}

MatrixXd backward_derivatives(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients) {
  const VectorXd v = forward(at);
  const Vector3d accel_at = v.segment<3>(Forward::accel_offset), gyro_at = v.segment<3>(Forward::gyro_offset);
  const Matrix3d force_at = matrix_at(v, Forward::gyro_force);
  MatrixXd out = MatrixXd::Zero(static_cast<Index>(coefficients.size()), Forward::all);
  for (Index column = 0; column < Forward::turning_bias; ++column) {
    const VectorXd d = VectorXd::Unit(Forward::all, column);
    SensorModel change;
    change.accel.matrix = -at.accel.matrix * matrix_at(d, Forward::accel_matrix) * at.accel.matrix;
    change.accel.offset = -change.accel.matrix * accel_at - at.accel.matrix * d.segment<3>(Forward::accel_offset);
    change.gyro.matrix = -at.gyro.matrix * matrix_at(d, Forward::gyro_matrix) * at.gyro.matrix;
    change.gyro.offset = -change.gyro.matrix * gyro_at - at.gyro.matrix * d.segment<3>(Forward::gyro_offset);
    change.g_sensitivity = change.gyro.matrix * force_at + at.gyro.matrix * matrix_at(d, Forward::gyro_force);
    for (std::size_t i = 0; i < coefficients.size(); ++i) out(static_cast<Index>(i), column) = coefficient_value(change, coefficients[i]);
  }
  return out;
}

std::vector<MatrixXd> backward_curvatures(const SensorModel& at, const std::vector<CoefficientIndex>& coefficients, const VectorXd& scale) {
  constexpr double step = 1e-3;  // of a column's size: off by its square, and by rounding over it
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

}  // namespace imulab
