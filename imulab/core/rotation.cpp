#include "imulab/core/rotation.hpp"

#include "imulab/eigen.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <cmath>
#include <numbers>

namespace imulab {

Vector3d rotation_log(const Matrix3d& c) {
  const Eigen::AngleAxisd a(Eigen::Quaterniond(c).normalized());
  return a.angle() * a.axis();
}

namespace {

/// Right-handed axes: along a, across a and b, and the third.
Matrix3d triad(const Vector3d& a, const Vector3d& b) {
  Matrix3d axes;
  axes.col(0) = a.normalized();
  axes.col(1) = a.cross(b).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

}  // namespace

Matrix3d rotation_from_directions(const Vector3d& first_a, const Vector3d& second_a, const Vector3d& first_b, const Vector3d& second_b) {
  return triad(first_a, second_a) * triad(first_b, second_b).transpose();
}

Matrix3d orthonormalized(const Matrix3d& c) {
  const Eigen::JacobiSVD<Matrix3d> svd(c, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Matrix3d shortest_rotation(const Vector3d& a, const Vector3d& b) {
  const Vector3d from = a.normalized(), to = b.normalized();
  const double cosine = from.dot(to);
  if (cosine < -1 + 1e-12) return Eigen::AngleAxisd(std::numbers::pi, from.unitOrthogonal()).toRotationMatrix();
  const Vector3d axis = from.cross(to);
  const double s = std::sqrt((1 + cosine) * 2);  // twice the cosine of half the angle
  Eigen::Quaterniond q;
  q.vec() = axis * (1 / s);
  q.w() = s * 0.5;
  return q.toRotationMatrix();
}

Eigen::Matrix<double, 2, 3> tangent_basis(const Vector3d& direction) {
  Eigen::Index smallest;
  direction.cwiseAbs().minCoeff(&smallest);
  const Vector3d first = direction.cross(Vector3d::Unit(smallest)).normalized();
  Eigen::Matrix<double, 2, 3> basis;
  basis << first.transpose(), direction.cross(first).transpose();
  return basis;
}

}  // namespace imulab
