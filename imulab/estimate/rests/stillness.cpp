#include "imulab/estimate/rests/stillness.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"

#include <cmath>

namespace imulab::rests {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Returns the integral of the rate beyond the rests' common rate, body axes; the angles are so small that their order does not matter.
Vector3d turned(const Recording& recording, Range range, const Vector3d& mean, const SensorModel& model, const Scaling& scaling) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = range.begin; i < range.end; ++i) sum += scaling.gyro(reading_at(recording.gyro, i)) - mean;
  return recording.interval_s * (model.gyro.matrix * sum);
}

/// Returns the scaled gyro means in the middle half of each rest, which contains no end of a turn. (For white noise, subtracting
/// this mean does not increase the variance of the integral over half a rest.)
std::vector<Vector3d> middle_means(const Recording& recording, std::span<const RestMeans> rests, const Scaling& scaling) {
  std::vector<Vector3d> out;
  for (const RestMeans& rest : rests) {
    const std::size_t quarter = rest.range.size() / 4;
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = rest.range.begin + quarter; i < rest.range.end - quarter; ++i) sum += scaling.gyro(reading_at(recording.gyro, i));
    out.emplace_back(sum / static_cast<double>(rest.range.size() - 2 * quarter));
  }
  return out;
}

/// Returns the scaled gyro readings at the rests as explained by a drifting offset and a g-sensitivity: the remainder is Earth's rate, noise and a
/// turn. Few rests do not separate a steady turn from a g-sensitivity: their whole mean counts as explained, as that of a part of a rest.
std::vector<Vector3d> explained_means(const Recording& recording, std::span<const RestMeans> rests, const SensorModel& model,
                                      const Scaling& scaling) {
  constexpr std::size_t enough = 16;
  constexpr Index columns = 6;
  std::vector<Vector3d> out = middle_means(recording, rests, scaling);
  std::vector<std::size_t> whole;
  for (std::size_t k = 0; k < rests.size(); ++k)
    if (!is_part_of_rest(recording, rests, k)) whole.push_back(k);
  if (whole.size() < enough) return out;
  const double begin = rests.front().mid_s, span = std::max(rests.back().mid_s - begin, 1e-9);
  MatrixXd design = MatrixXd::Ones(std::ssize(whole), columns), mean(std::ssize(whole), 3);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const std::size_t k = whole[i];
    mean.row(row) = out[k].transpose();
    const double time = (rests[k].mid_s - begin) / span - 0.5;
    design.row(row).segment<3>(1) = output(model.accel, scaling.accel(rests[k].accel)).normalized().transpose();
    design(row, 4) = time, design(row, 5) = time * time;
  }
  MatrixXd normal = design.transpose() * design;
  normal.diagonal().array() += 1e-6 * static_cast<double>(whole.size());  // rests in one direction do not determine a g-sensitivity
  const MatrixXd coefficients = solve_semidefinite(normal, MatrixXd(design.transpose() * mean));
  for (std::size_t i = 0; i < whole.size(); ++i) out[whole[i]] = (design.row(static_cast<Index>(i)) * coefficients).transpose();
  return out;
}

}  // namespace

Range turn_between(const Recording& recording, Range rest, Range next, const Stillness& stillness) {
  const auto end_of = [&](Range r) { return stillness.moves ? r.size() / 2 : std::min(stillness.end, r.size() / 2); };
  Range turn{rest.end, next.begin};
  if (turn.size() == 0) return turn;
  if (const std::size_t n = end_of(rest); recording.gaps_in({rest.end - n, rest.end + 1}) == 0) turn.begin -= n;
  if (const std::size_t n = end_of(next); recording.gaps_in({next.begin, next.begin + n + 1}) == 0) turn.end += n;
  return turn;
}

Stillness stillness_of(const Recording& recording, std::span<const RestMeans> rests, const SensorModel& model, const Scaling& scaling,
                       const Vector3d& sample_sigma, const Vector3d& rounding_sigma) {
  constexpr double level = 1e-3, sure = 3.3;  // probability, and the equivalent number of standard deviations
  constexpr double end_s = 0.5;               // a hand stops within some tenths of a second
  Stillness out;
  out.end = static_cast<std::size_t>(std::round(end_s / recording.interval_s));
  const std::vector<Vector3d> means = explained_means(recording, rests, model, scaling);
  const auto of_axis = [&](const Vector3d& sigma) { return (model.gyro.matrix * sigma).norm() / std::sqrt(3.0); };  // rad/s
  const double sample = of_axis(sample_sigma), rounding = of_axis(rounding_sigma);
  double square = 0, variance = 0, chi2 = 0, along = 0, along_square = 0;
  int count = 0;
  const auto add = [&](std::size_t k, Range part, Range turn) {
    if (part.size() == 0 || recording.gaps_in(part) > 0) return;
    const double duration = static_cast<double>(part.size()) * recording.interval_s;
    // The Earth's rate, in other axes at each rest, cannot be distinguished from wander.
    const double expected =
        sample * sample * duration * recording.interval_s + std::pow(rounding * duration, 2) + std::pow(earth_rate * duration, 2) / 3;
    const Vector3d seen = turned(recording, part, means[k], model, scaling);
    square += seen.squaredNorm(), variance += 3 * expected, chi2 += seen.squaredNorm() / expected;
    count += 3;
    if (turn.size() == 0) return;
    const double component = seen.dot(turned(recording, turn, means[k], model, scaling).normalized());
    along += component, along_square += component * component;
  };
  for (std::size_t k = 0; k < rests.size(); ++k) {
    const Range rest = rests[k].range;
    if (is_part_of_rest(recording, rests, k)) continue;
    const std::size_t middle = rest.begin + rest.size() / 2, end = std::min(out.end, rest.size() / 2);
    add(k, {rest.begin + end, middle}, {k == 0 ? rest.begin : rests[k - 1].range.end, rest.begin});
    add(k, {middle, rest.end - end}, {rest.end, k + 1 == rests.size() ? rest.end : rests[k + 1].range.begin});
  }
  if (count == 0) return out;
  const bool tails = std::abs(along) > sure * std::sqrt(along_square);  // for parts of random sign and any size, the ratio is about N(0, 1)
  out.moves = tails || chi_square_tail(chi2, count) < level;
  if (out.moves) out.wander = std::sqrt(std::max(0.0, (square - variance) / count));
  return out;
}

void level_at_middle(const Recording& recording, std::vector<RestMeans>& rests, const SensorModel& model, const Scaling& scaling) {
  const std::vector<Vector3d> means = explained_means(recording, rests, model, scaling);
  const Matrix3d to_raw = (model.accel.matrix * scaling.accel_scale.cwiseInverse().asDiagonal()).inverse();
  for (std::size_t k = 0; k < rests.size(); ++k) {
    RestMeans& rest = rests[k];
    if (is_part_of_rest(recording, rests, k) || recording.gaps_in(rest.range) > 0) continue;
    const Vector3d force = output(model.accel, scaling.accel(rest.accel));
    Vector3d angle = -turned(recording, {rest.range.begin, rest.range.begin + rest.range.size() / 2}, means[k], model, scaling),
             sum = Vector3d::Zero();
    for (std::size_t i = rest.range.begin; i < rest.range.end; ++i) {
      angle += turned(recording, {i, i + 1}, means[k], model, scaling);
      sum += angle;
    }
    // The force of a sample in the axes at the middle is f + angle x f.
    rest.accel += to_raw * (sum / static_cast<double>(rest.range.size())).cross(force);
  }
}

}  // namespace imulab::rests
