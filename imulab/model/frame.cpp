#include "imulab/frame.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/model/frame_axes.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/core.h>
#include <unsupported/Eigen/AutoDiff>

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

using Jet = Eigen::AutoDiffScalar<Eigen::Vector<double, coefficient_count>>;

/// Returns R. The accelerometers measure A1^-1 a, so its rows are their sensitive axes. The cross products of A1's columns (det A1 times the rows)
/// avoid a division: orthonormalized in order, they are the rows of R.
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

/// Returns a' = R a, w' = R w, coefficient by coefficient.
template <class T>
Coefficients<T> rotated(Coefficients<T> c) {
  const Matrix3<T> a1 = block(c, Triad::accel, Term::matrix);
  const Matrix3<T> r = rotation_of(a1);
  rotate_offset(c, Triad::accel, r);
  rotate_offset(c, Triad::gyro, r);
  set_block<T>(c, Triad::accel, Term::matrix, r * a1);
  set_block<T>(c, Triad::gyro, Term::matrix, r * block(c, Triad::gyro, Term::matrix));
  set_block<T>(c, Triad::gyro, Term::g_sensitivity, r * block(c, Triad::gyro, Term::g_sensitivity) * r.transpose());
  for (const Triad triad : {Triad::accel, Triad::gyro})
    for (const Term term : {Term::matrix_thermal1, Term::matrix_thermal2}) set_block<T>(c, triad, term, r * block(c, triad, term) * r.transpose());
  set_block<T>(c, Triad::accel, Term::lever_arm, block(c, Triad::accel, Term::lever_arm) * r.transpose());  // row i is r_i
  return c;
}

/// Returns d rotated / d coefficients.
Eigen::MatrixXd rotation_jacobian(const SensorModel& model) {
  Coefficients<Jet> x;
  for (const CoefficientIndex i : coefficient_indices()) x[static_cast<std::size_t>(i)] = Jet(coefficient_value(model, i), coefficient_count, i);
  const Coefficients<Jet> y = rotated(x);
  Eigen::MatrixXd jacobian(coefficient_count, coefficient_count);
  for (const CoefficientIndex i : coefficient_indices()) jacobian.row(i) = y[static_cast<std::size_t>(i)].derivatives().transpose();
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
  validate(calibration);
  accelerometer_frame(calibration.model.accel.matrix);  // throws if there is no such frame
  Coefficients<double> values;
  for (const CoefficientIndex i : coefficient_indices()) values[static_cast<std::size_t>(i)] = coefficient_value(calibration.model, i);
  values = rotated(values);

  Calibration out = calibration;
  out.frame = BodyFrame::accelerometers;
  for (const CoefficientIndex i : coefficient_indices()) set_coefficient(out.model, i, zero_by_frame(i) ? 0.0 : values[static_cast<std::size_t>(i)]);
  std::erase_if(out.estimated, zero_by_frame);
  const Eigen::MatrixXd jacobian = rotation_jacobian(calibration.model)(out.estimated, calibration.estimated);
  out.covariance = jacobian * calibration.covariance * jacobian.transpose();
  if (calibration.constant_covariance.size() > 0) out.constant_covariance = jacobian * calibration.constant_covariance * jacobian.transpose();
  return out;
}

std::string wrong_axes(const Matrix3d& gyro) {
  const Matrix3d m = gyro / std::cbrt(std::abs(gyro.determinant()));
  std::array<Eigen::Index, 3> source;
  for (Eigen::Index r = 0; r < 3; ++r) {
    m.row(r).cwiseAbs().maxCoeff(&source[static_cast<std::size_t>(r)]);
    if (std::abs(m(r, source[static_cast<std::size_t>(r)])) < 0.7) return {};  // mounted at an angle: undecided
  }
  if (source[0] == source[1] || source[0] == source[2] || source[1] == source[2]) return {};
  std::string swapped, reversed;
  int negative = 0;
  for (Eigen::Index r = 0; r < 3; ++r) {
    const Eigen::Index from = source[static_cast<std::size_t>(r)];
    if (from != r) swapped += fmt::format("{}{} reads about {}", swapped.empty() ? "" : ", ", "xyz"[from], "xyz"[r]);
    if (m(r, from) > 0) continue;
    ++negative;
    reversed += fmt::format("{}{}", reversed.empty() ? "" : " and ", "xyz"[from]);
  }
  if (swapped.empty() && negative == 0) return {};
  if (!swapped.empty()) return "the gyros' axes are not those of the accelerometers: gyro " + swapped + (negative ? "; reversed: " + reversed : "");
  if (negative == 3) return "the triads are left-handed: both have one axis reversed (or all three gyros are)";
  if (negative == 1) return "gyro " + reversed + " has the wrong sign";
  for (Eigen::Index r = 0; r < 3; ++r)
    if (m(r, r) > 0) return fmt::format("accelerometer {} (or the gyros {}) has the wrong sign", "xyz"[r], reversed);
  return {};
}

}  // namespace imulab
