#include "imulab/recording/coverage.hpp"

#include "imulab/core/decomposition.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab {

namespace {

constexpr int parameters = 9;

/// The derivative of |force| by offsets, scales and misalignments for a force along a unit vector.
Eigen::Matrix<double, 1, parameters> dependence(const Vector3d& u) {
  Eigen::Matrix<double, 1, parameters> row;
  row << u.x(), u.y(), u.z(), u.x() * u.x(), u.y() * u.y(), u.z() * u.z(), u.x() * u.y(), u.x() * u.z(), u.y() * u.z();
  return row;
}

/// Evenly spread over the sphere: a Fibonacci lattice; 3 deg apart.
std::vector<Vector3d> lattice() {
  constexpr int count = 4000;
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, angle = i * std::numbers::pi * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
    points.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return points;
}

}  // namespace

std::vector<double> leverages(const std::vector<Vector3d>& directions) {
  if (directions.empty()) return {};
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(directions.size()), parameters);
  for (std::size_t i = 0; i < directions.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = dependence(directions[i].normalized());
  const SingularValues svd = singular_values(rows);
  constexpr double least = 1e-3;  // of the largest singular value: directions closer to degenerate say nothing
  Eigen::Index rank = 0;
  while (rank < svd.values.size() && svd.values[rank] > least * svd.values[0]) ++rank;
  const Eigen::VectorXd sums = svd.U.leftCols(rank).rowwise().squaredNorm();
  return {sums.begin(), sums.end()};
}

std::vector<CoverageGap> coverage_gaps(const std::vector<Vector3d>& directions, double least, std::size_t most) {
  std::vector<CoverageGap> gaps;
  if (directions.empty()) return gaps;
  const std::vector<Vector3d> points = lattice();
  std::vector<double> nearest(points.size(), -1);  // cosine
  const auto cover = [&](const Vector3d& unit) {
    for (std::size_t k = 0; k < points.size(); ++k) nearest[k] = std::max(nearest[k], points[k].dot(unit));
  };
  for (const Vector3d& direction : directions) cover(direction.normalized());
  while (gaps.size() < most) {
    const auto at = std::min_element(nearest.begin(), nearest.end());
    const double angle = std::acos(std::clamp(*at, -1.0, 1.0));
    if (angle <= least) break;
    gaps.push_back({points[static_cast<std::size_t>(at - nearest.begin())], angle});
    cover(gaps.back().direction);
  }
  return gaps;
}

}  // namespace imulab
