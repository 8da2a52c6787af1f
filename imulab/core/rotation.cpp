#include "imulab/core/rotation.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace imulab {

Vector3d rotation_log(const Matrix3d& c) {
  const Eigen::AngleAxisd a(Eigen::Quaterniond(c).normalized());
  return a.angle() * a.axis();
}

Matrix3d orthonormalized(const Matrix3d& c) {
  const Eigen::JacobiSVD<Matrix3d> svd(c, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace imulab
