#include "imulab/estimate/hybrid/latitude_at_rest.hpp"

#include "imulab/compensate.hpp"
#include "imulab/earth.hpp"
#include "imulab/units.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

struct Rest {
  Vector3d up, rate;
  double duration;  // [s]
};

std::vector<Rest> compensated(const std::vector<RestMeans>& rests, SensorModel model) {
  model.g_sensitivity.setZero();  // an equal g-sensitivity may be the result of a wrong latitude
  std::vector<Rest> out;
  for (const RestMeans& rest : rests) {
    const Motion motion = compensate(model, {.gyro = rest.gyro, .accel = rest.accel});
    out.push_back({motion.force.normalized(), motion.rate, std::max(rest.end_s - rest.begin_s, 1e-3)});
  }
  return out;
}

/// A value and its variance.
struct Measured {
  double value, variance;
};

/// The Earth's rate along gravity [rad/s], and the square of its component across gravity.
struct EarthsRate {
  Measured along, across2;

  /// Returns the chi-square of a latitude.
  double misfit(double latitude) const {
    const double c = earth_rate * std::cos(latitude);
    return std::pow(along.value - earth_rate * std::sin(latitude), 2) / along.variance + std::pow(across2.value - c * c, 2) / across2.variance;
  }
};

std::optional<EarthsRate> earths_rate(const std::vector<Rest>& rests, const GyrosAtRest& gyros) {
  constexpr std::size_t unknowns = 4, fewest = unknowns + 4;
  if (rests.size() < fewest) return {};
  Matrix4d information = Matrix4d::Zero();
  Vector4d sum = Vector4d::Zero();
  double all = 0;
  for (const Rest& r : rests) {
    const Vector4d row = (Vector4d() << 1, r.up).finished();
    information += r.duration * row * row.transpose();
    sum += r.duration * r.up.dot(r.rate) * row;
    all += r.duration;
  }
  if (Eigen::SelfAdjointEigenSolver<Matrix4d>(information).eigenvalues()[0] < 1e-2 * all) return {};  // the attitudes hardly differ
  const Matrix4d inverse = information.inverse();
  const Vector4d solution = inverse * sum;
  const Vector3d offset = solution.tail<3>();
  double squares = 0;
  for (const Rest& r : rests) squares += r.duration * std::pow(r.up.dot(r.rate - offset) - solution[0], 2);
  const double density2 = std::max(gyros.noise * gyros.noise, squares / static_cast<double>(rests.size() - unknowns));  // (rad/s)^2 s

  const Matrix3d of_offset = density2 * inverse.bottomRightCorner<3, 3>();
  double mean = 0, spread = 0;
  std::vector<double> across2;
  Vector3d by_offset = Vector3d::Zero();
  for (const Rest& r : rests) {
    const Matrix3d level = Matrix3d::Identity() - r.up * r.up.transpose();
    const Vector3d across = level * (r.rate - offset);
    across2.push_back(across.squaredNorm() - 2 * density2 / r.duration - (level * of_offset).trace());
    mean += r.duration / all * across2.back();
    by_offset -= 2 * r.duration / all * across;
  }
  for (std::size_t k = 0; k < rests.size(); ++k) spread += std::pow(rests[k].duration / all * (across2[k] - mean), 2);
  const double n = static_cast<double>(rests.size()), noise2 = 4 * density2 * (std::max(mean, 0.0) / all + n * density2 / (all * all));
  return EarthsRate{
      {solution[0], density2 * inverse(0, 0) + std::pow(gyros.scale * solution[0], 2) + std::pow(gyros.g_sensitivity * gyros.gravity, 2)},
      {mean, std::max(spread * n / (n - 1), noise2) + by_offset.dot(of_offset * by_offset) + std::pow(2 * gyros.scale * mean, 2)}};
}

/// Returns the most likely latitude between these limits.
double most_likely(const EarthsRate& seen, double from, double to) {
  const auto among = [&](double begin, double end, int steps) {
    double best = begin;
    for (int k = 1; k <= steps; ++k)
      if (const double at = begin + (end - begin) * k / steps; seen.misfit(at) < seen.misfit(best)) best = at;
    return best;
  };
  constexpr int steps = 360;
  const double coarse = among(from, to, steps), step = (to - from) / steps;
  return among(std::max(from, coarse - step), std::min(to, coarse + step), steps);
}

}  // namespace

std::optional<SeenLatitude> latitude_against(double declared, double declared_sigma, const std::vector<RestMeans>& rests, const SensorModel& model,
                                             const GyrosAtRest& gyros) {
  constexpr double unlikely = 25, pole = 90 * unit::deg;
  const auto seen = earths_rate(compensated(rests, model), gyros);
  if (!seen) return {};
  const double best = most_likely(*seen, -pole, pole), least = seen->misfit(best);
  const double near = most_likely(*seen, std::max(-pole, declared - 3 * declared_sigma), std::min(pole, declared + 3 * declared_sigma));
  if (least > unlikely || seen->misfit(near) - least < unlikely) return {};
  double width = 0.001 * unit::deg;
  while (width < pole && seen->misfit(best + width) + seen->misfit(best - width) < 2 * (least + 1)) width *= 1.05;
  return SeenLatitude{best, width};
}

}  // namespace imulab::hybrid
