#include "imulab/estimate/rests/stillness.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"

#include <cmath>

namespace imulab::rests {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// The integral of the rate beyond the rests' common one, body axes: angles so small that their order does not matter.
Vector3d turned(const Recording& recording, Range range, const Vector3d& mean, const SensorModel& model, const Scaling& scaling) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = range.begin; i < range.end; ++i) sum += scaling.gyro(reading_at(recording.gyro, i)) - mean;
  return recording.interval_s * (model.gyro.matrix * sum);
}

/// The scaled gyro readings at the rests, as an offset that drifts and a g-sensitivity explain them: what is left of a rest's mean is the Earth's
/// rate, noise and a turn. Few rests do not tell a steady turn from a g-sensitivity: of them, all of the mean is taken as explained.
std::vector<Vector3d> explained_means(std::span<const RestMeans> rests, const SensorModel& model, const Scaling& scaling) {
  constexpr std::size_t enough = 16;
  constexpr Index columns = 6;
  std::vector<Vector3d> out;
  if (rests.size() < enough) {
    for (const RestMeans& rest : rests) out.push_back(scaling.gyro(rest.gyro));
    return out;
  }
  const double begin = rests.front().mid_s, span = std::max(rests.back().mid_s - begin, 1e-9);
  MatrixXd design = MatrixXd::Ones(std::ssize(rests), columns), mean(std::ssize(rests), 3);
  for (std::size_t k = 0; k < rests.size(); ++k) {
    const auto row = static_cast<Index>(k);
    mean.row(row) = scaling.gyro(rests[k].gyro).transpose();
    const double time = (rests[k].mid_s - begin) / span - 0.5;
    design.row(row).segment<3>(1) = output(model.accel, scaling.accel(rests[k].accel)).normalized().transpose();
    design(row, 4) = time, design(row, 5) = time * time;
  }
  MatrixXd normal = design.transpose() * design;
  normal.diagonal().array() += 1e-6 * static_cast<double>(rests.size());  // rests in one direction show no g-sensitivity
  const MatrixXd coefficients = solve_semidefinite(normal, MatrixXd(design.transpose() * mean));
  for (Index row = 0; row < design.rows(); ++row) out.emplace_back((design.row(row) * coefficients).transpose());
  return out;
}

}  // namespace

Range first_half(const RestMeans& rest) { return {rest.range.begin, rest.range.begin + rest.range.size() / 2}; }
Range second_half(const RestMeans& rest) { return {rest.range.begin + rest.range.size() / 2, rest.range.end}; }

Stillness stillness_of(const Recording& recording, std::span<const RestMeans> rests, const SensorModel& model, const Scaling& scaling,
                       const Vector3d& sample_sigma, const Vector3d& rounding_sigma) {
  constexpr double level = 1e-3;
  if (rests.empty()) return {};
  const std::vector<Vector3d> means = explained_means(rests, model, scaling);
  const auto of_axis = [&](const Vector3d& sigma) { return (model.gyro.matrix * sigma).norm() / std::sqrt(3.0); };  // rad/s
  const double sample = of_axis(sample_sigma), rounding = of_axis(rounding_sigma);
  double square = 0, variance = 0, chi2 = 0;
  int count = 0;
  for (std::size_t k = 0; k < rests.size(); ++k)
    for (const Range half : {first_half(rests[k]), second_half(rests[k])}) {
      if (half.size() == 0 || recording.gaps_in(half) > 0) continue;
      const double duration = static_cast<double>(half.size()) * recording.interval_s;
      // The Earth's rate, in other axes at each rest, is not told from a wander.
      const double expected =
          sample * sample * duration * recording.interval_s + std::pow(rounding * duration, 2) + std::pow(earth_rate * duration, 2) / 3;
      const double seen = turned(recording, half, means[k], model, scaling).squaredNorm();
      square += seen, variance += 3 * expected, chi2 += seen / expected;
      count += 3;
    }
  if (count == 0) return {};
  const double noise = std::sqrt(variance / count);
  if (chi_square_tail(chi2, count) > level) return {0, noise};
  return {std::sqrt(std::max(0.0, (square - variance) / count)), noise};
}

void level_at_middle(const Recording& recording, std::vector<RestMeans>& rests, double weight, const SensorModel& model, const Scaling& scaling) {
  if (!(weight > 0)) return;
  const std::vector<Vector3d> means = explained_means(rests, model, scaling);
  const Matrix3d to_raw = (model.accel.matrix * scaling.accel_scale.cwiseInverse().asDiagonal()).inverse();
  for (std::size_t k = 0; k < rests.size(); ++k) {
    RestMeans& rest = rests[k];
    if (recording.gaps_in(rest.range) > 0) continue;
    const Vector3d force = output(model.accel, scaling.accel(rest.accel));
    Vector3d angle = -turned(recording, first_half(rest), means[k], model, scaling), sum = Vector3d::Zero();
    for (std::size_t i = rest.range.begin; i < rest.range.end; ++i) {
      angle += turned(recording, {i, i + 1}, means[k], model, scaling);
      sum += angle;
    }
    // A sample's force in the axes at the middle is f + angle x f.
    rest.accel += to_raw * (weight / static_cast<double>(rest.range.size()) * sum).cross(force);
  }
}

}  // namespace imulab::rests
