#include "imulab/estimate/coarse/coarse.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/recording/gyro_saturation.hpp"

#include <Eigen/LU>

#include <cmath>

namespace imulab::coarse {

namespace {

/// Below this ratio of singular values (columns normalized), a combination is undetermined: directions set by hand are wrong by a few percent.
constexpr double rank_threshold = 1e-2;

std::optional<Eigen::VectorXd> solve(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) { return solve_full_rank(a, b, rank_threshold); }

}  // namespace

std::optional<CoarseAccel> coarse_accel(const std::vector<Vector3d>& readings, double gravity) {
  const auto n = static_cast<Eigen::Index>(readings.size());
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
  for (const bool cross_terms : {true, false}) {
    // u^T M u + m . u = 1 with M = Q / k, m = -2 Q B / k, k = g^2 - B^T Q B
    Eigen::MatrixXd a(n, cross_terms ? 9 : 6);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Vector3d& u = readings[static_cast<std::size_t>(i)];
      a.row(i).head<6>() << u.x() * u.x(), u.y() * u.y(), u.z() * u.z(), u.x(), u.y(), u.z();
      if (cross_terms) a.row(i).tail<3>() << 2 * u.x() * u.y(), 2 * u.x() * u.z(), 2 * u.y() * u.z();
    }
    const auto x = solve(a, ones);
    if (!x) continue;
    Matrix3d m = Vector3d(x->head<3>()).asDiagonal();
    if (cross_terms) {
      m(0, 1) = m(1, 0) = (*x)[6];
      m(0, 2) = m(2, 0) = (*x)[7];
      m(1, 2) = m(2, 1) = (*x)[8];
    }
    const Vector3d bias = -0.5 * m.inverse() * x->segment<3>(3);
    const double k = gravity * gravity / (1 + bias.dot(m * bias));
    const auto factor = reverse_cholesky(k * m);
    if (!factor) continue;
    const Matrix3d matrix = *factor;
    return CoarseAccel{-matrix * bias, matrix, cross_terms};
  }
  return {};
}

std::optional<CoarseGyro> coarse_gyro_at_rest(const std::vector<RestMeans>& rests, const SensorModel& model, const Scaling& scaling,
                                              double earth_rate_vertical) {
  if (earth_rate_vertical == 0) return {};  // homogeneous: the scale is lost
  const auto n = static_cast<Eigen::Index>(rests.size());
  Eigen::MatrixXd a(n, 12);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RestMeans& rest = rests[static_cast<std::size_t>(i)];
    const Vector3d f = linear_output(model.accel, scaling.accel(rest.accel)).normalized(), u = scaling.gyro(rest.gyro);
    for (int r = 0; r < 3; ++r) a.row(i).segment<3>(3 * r) = f[r] * u.transpose();
    a.row(i).tail<3>() = f;
  }
  const auto x = solve(a, Eigen::VectorXd::Constant(n, earth_rate_vertical));
  if (!x) return {};
  CoarseGyro gyro;
  for (int r = 0; r < 3; ++r) gyro.matrix.row(r) = x->segment<3>(3 * r);
  gyro.offset = x->tail<3>();
  return gyro;
}

std::optional<Matrix3d> coarse_gyro_in_motion(const Recording& recording, const std::vector<RestMeans>& rests, const SensorModel& model,
                                              const Scaling& scaling) {
  // For each quarter of a second, up(end) - up(begin) is the sum over samples of (up x W1 v) dt, where v is the gyro reading minus its mean at rest.
  const double quarter = std::min(std::round(0.25 / recording.interval_s), static_cast<double>(recording.size()));  // an interval of 0 gives all
  const auto chunk = static_cast<std::size_t>(std::max(2.0, quarter));
  const Vector3d at_rest = mean_gyro(rests);
  const std::size_t around = chunk / 4;  // samples on each side over which gravity is averaged
  const auto up_at = [&](std::size_t i) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = i - around; k <= i + around; ++k) sum += reading_at(recording.accel, k);
    return Vector3d(linear_output(model.accel, scaling.accel(sum / static_cast<double>(2 * around + 1))).normalized());
  };
  const GyroSaturation saturation(recording);
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  Eigen::Matrix<double, 9, 1> right = Eigen::Matrix<double, 9, 1>::Zero();
  for (std::size_t k = 0; k + 1 < rests.size(); ++k) {
    for (std::size_t i = rests[k].range.end; i + chunk <= rests[k + 1].range.begin; i += chunk) {
      if (i < around || i + chunk + around >= recording.size()) continue;  // gravity is unknown around one of its ends
      // the angle of this chunk was not measured, or it is adjacent to a gap
      if (saturation.in({i, i + chunk}) > 0 || recording.gaps_in({i, i + chunk + 1}) > 0) continue;
      const auto beyond = [&](std::size_t at) { return recording.saturated_in({at - around, at + around + 1}) > 0; };
      if (beyond(i) || beyond(i + chunk)) continue;  // gravity was not measured
      const Vector3d begin = up_at(i), end = up_at(i + chunk);
      Vector3d angle = Vector3d::Zero();
      for (std::size_t s = i; s < i + chunk; ++s)
        angle += (reading_at(recording.gyro, s) - at_rest).cwiseQuotient(scaling.gyro_scale) * recording.interval_s;
      const Matrix3d up = skew<double>(0.5 * (begin + end));
      Eigen::Matrix<double, 3, 9> row;
      for (int j = 0; j < 3; ++j) row.middleCols<3>(3 * j) = up * angle[j];
      normal += row.transpose() * row;
      right += row.transpose() * (end - begin);
    }
  }
  // Squares: the noise of an axis that turns by less than 3 % of the largest turning dominates its scale.
  if (!(normal.diagonal().minCoeff() > 1e-3 * normal.diagonal().maxCoeff())) return {};
  const auto x = solve(normal, right);
  if (!x) return {};
  Matrix3d matrix;
  for (int j = 0; j < 3; ++j) matrix.col(j) = x->segment<3>(3 * j);
  return matrix;
}

}  // namespace imulab::coarse
