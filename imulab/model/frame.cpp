#include "imulab/model/frame.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/coefficient.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <ceres/jet.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

namespace {

template <class T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;
template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Coefficients = std::array<T, coefficient_count>;

using Jet = ceres::Jet<double, coefficient_count>;

/// The accelerometers sense A1^-1 a: its rows are their sensitive axes. With the cross products of A1's columns in their place (det A1 times
/// the rows) there is no division: the rows of R are these, orthonormalized in order.
template <class T>
Matrix3<T> rotation_of(const Matrix3<T>& a1) {
  const Vector3<T> c0 = a1.col(0), c1 = a1.col(1), c2 = a1.col(2);
  const T determinant = c0.dot(c1.cross(c2));
  const T sign = determinant < T(0) ? T(-1) : T(1);
  const Vector3<T> x_axis = sign * c1.cross(c2), y_axis = sign * c2.cross(c0);
  const Vector3<T> x = x_axis / x_axis.norm();
  const Vector3<T> y_part = y_axis - x.dot(y_axis) * x;
  const Vector3<T> y = y_part / y_part.norm();
  Matrix3<T> r;
  r << x.transpose(), y.transpose(), x.cross(y).transpose();
  return r;
}

template <class T>
Matrix3<T> block(const Coefficients<T>& c, Triad triad, Term term) {
  Matrix3<T> m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = c[static_cast<std::size_t>(coefficient_index(triad, term, i, j))];
  return m;
}

template <class T>
void set_block(Coefficients<T>& c, Triad triad, Term term, const Matrix3<T>& m) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c[static_cast<std::size_t>(coefficient_index(triad, term, i, j))] = m(i, j);
}

template <class T>
void rotate_offset(Coefficients<T>& c, Triad triad, const Matrix3<T>& r) {
  const auto at = static_cast<std::size_t>(coefficient_index(triad, Term::offset, 0, 0));
  const Vector3<T> rotated = r * Vector3<T>(c[at], c[at + 1], c[at + 2]);
  for (std::size_t i = 0; i < 3; ++i) c[at + i] = rotated(static_cast<Eigen::Index>(i));
}

/// a' = R a, w' = R w, coefficient by coefficient.
template <class T>
Coefficients<T> rotated(Coefficients<T> c) {
  const Matrix3<T> a1 = block(c, Triad::accel, Term::matrix);
  const Matrix3<T> r = rotation_of(a1);
  rotate_offset(c, Triad::accel, r);
  rotate_offset(c, Triad::gyro, r);
  set_block<T>(c, Triad::accel, Term::matrix, r * a1);
  set_block<T>(c, Triad::gyro, Term::matrix, r * block(c, Triad::gyro, Term::matrix));
  set_block<T>(c, Triad::gyro, Term::g_sensitivity, r * block(c, Triad::gyro, Term::g_sensitivity) * r.transpose());
  set_block<T>(c, Triad::accel, Term::lever_arm, block(c, Triad::accel, Term::lever_arm) * r.transpose());  // row i is r_i
  return c;
}

/// d rotated / d coefficients.
Eigen::MatrixXd rotation_jacobian(const SensorModel& model) {
  Coefficients<Jet> x;
  for (const CoefficientIndex i : coefficient_indices()) x[static_cast<std::size_t>(i)] = Jet(coefficient_value(model, i), i);
  const Coefficients<Jet> y = rotated(x);
  Eigen::MatrixXd jacobian(coefficient_count, coefficient_count);
  for (const CoefficientIndex i : coefficient_indices()) jacobian.row(i) = y[static_cast<std::size_t>(i)].v.transpose();
  return jacobian;
}

}  // namespace

bool zero_by_frame(CoefficientIndex index) {
  const Coefficient& c = coefficient(index);
  return c.triad == Triad::accel && c.term == Term::matrix && c.column > c.row;
}

Matrix3d accelerometer_frame(const Matrix3d& a1) {
  const double size = a1.col(0).norm() * a1.col(1).norm() * a1.col(2).norm();
  if (!(std::abs(a1.determinant()) > 1e-9 * size)) throw Error("accel.matrix is singular: its columns do not span three directions");
  return rotation_of(a1);
}

Calibration in_accelerometer_frame(const Calibration& calibration) {
  accelerometer_frame(calibration.model.accel.matrix);  // throws where there is no such frame
  Coefficients<double> values;
  for (const CoefficientIndex i : coefficient_indices()) values[static_cast<std::size_t>(i)] = coefficient_value(calibration.model, i);
  values = rotated(values);

  Calibration out = calibration;
  out.frame = "accelerometers";
  for (const CoefficientIndex i : coefficient_indices()) set_coefficient(out.model, i, zero_by_frame(i) ? 0.0 : values[static_cast<std::size_t>(i)]);
  std::erase_if(out.estimated, zero_by_frame);
  const Eigen::MatrixXd jacobian = rotation_jacobian(calibration.model)(out.estimated, calibration.estimated);
  out.covariance = jacobian * calibration.covariance * jacobian.transpose();
  return out;
}

}  // namespace imulab
