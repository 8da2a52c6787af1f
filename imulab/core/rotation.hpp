// Rotations as 3x3 direction cosine matrices and rotation vectors. `C_ab` takes a vector from frame b to frame a.
#pragma once

#include "imulab/eigen.hpp"

#include <cmath>

namespace imulab {

/// The matrix of the cross product: skew(a) b = a x b.
template <class T>
Eigen::Matrix<T, 3, 3> skew(const Eigen::Matrix<T, 3, 1>& a) {
  Eigen::Matrix<T, 3, 3> m;
  m << T(0), -a.z(), a.y(), a.z(), T(0), -a.x(), -a.y(), a.x(), T(0);
  return m;
}

/// Rotation matrix of a rotation vector [rad] (Rodrigues), exact to rounding for any angle.
inline Matrix3d rotation_exp(const Vector3d& r) {
  const double t2 = r.squaredNorm();
  double a, b;  // sin t / t and (1 - cos t) / t^2
  if (t2 < 1e-4) {
    a = 1 - t2 / 6 * (1 - t2 / 20 * (1 - t2 / 42));
    b = 0.5 - t2 / 24 * (1 - t2 / 30 * (1 - t2 / 56));
  } else {
    const double t = std::sqrt(t2);
    a = std::sin(t) / t;
    b = (1 - std::cos(t)) / t2;
  }
  const Matrix3d k = skew<double>(r);
  return Matrix3d::Identity() + a * k + b * k * k;
}

/// Rotation vector [rad] of a rotation matrix, angle in [0, pi].
Vector3d rotation_log(const Matrix3d& c);

/// Rotation by `angle` [rad] about the unit vector `axis`, right-handed. T: double, or a type that carries derivatives.
template <class T>
Eigen::Matrix<T, 3, 3> rotation_about(const Eigen::Matrix<T, 3, 1>& axis, const T& angle) {
  using std::cos, std::sin;
  const Eigen::Matrix<T, 3, 3> k = skew<T>(axis), k2 = k * k;
  const T sine = sin(angle), versine = T(1) - cos(angle);
  Eigen::Matrix<T, 3, 3> m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = T(i == j ? 1 : 0) + sine * k(i, j) + versine * k2(i, j);
  return m;
}
inline Matrix3d rotation_about(const Vector3d& axis, double angle) { return rotation_about<double>(axis, angle); }

/// The nearest rotation matrix: removes the rounding errors that long products accumulate.
Matrix3d orthonormalized(const Matrix3d& c);

/// C_ab from two directions known in both frames, of any length: `first` is met exactly, `second` in the plane with it (TRIAD, Black 1964). The
/// directions must not be parallel.
Matrix3d rotation_from_directions(const Vector3d& first_a, const Vector3d& second_a, const Vector3d& first_b, const Vector3d& second_b);

/// The rotation by the smallest angle that takes unit vector a to unit vector b.
Matrix3d shortest_rotation(const Vector3d& a, const Vector3d& b);

/// Rows: two unit vectors that complete the unit vector `direction` to a right-handed triad.
Eigen::Matrix<double, 2, 3> tangent_basis(const Vector3d& direction);

/// d (v / |v|) / d v
inline Matrix3d direction_derivative(const Vector3d& v) {
  const Vector3d unit = v.normalized();
  return (Matrix3d::Identity() - unit * unit.transpose()) / v.norm();
}

}  // namespace imulab
