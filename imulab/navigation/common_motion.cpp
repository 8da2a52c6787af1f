#include "imulab/navigation/common_motion.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace imulab::common_motion {
namespace {

constexpr double step_s = 0.01;
constexpr double least_common_s = 5;

/// Readings at equal steps from `begin` on.
struct Grid {
  double begin = 0;
  std::vector<Vector3d> rate, force;
};

Grid grid_of(const Stream& stream) {
  const std::vector<Sample>& s = stream.samples;
  const auto middle = [&](std::size_t i) { return 0.5 * (s[i].begin + s[i].end); };
  Grid out{.begin = middle(0), .rate = {}, .force = {}};
  const auto n = static_cast<std::size_t>((middle(s.size() - 1) - out.begin) / step_s);
  for (std::size_t k = 0, i = 0; k < n; ++k) {
    const double t = out.begin + step_s * static_cast<double>(k);
    while (i + 2 < s.size() && middle(i + 1) < t) ++i;
    const double part = std::clamp((t - middle(i)) / (middle(i + 1) - middle(i)), 0., 1.);
    out.rate.push_back((1 - part) * s[i].rate + part * s[i + 1].rate);
    out.force.push_back((1 - part) * s[i].force + part * s[i + 1].force);
  }
  return out;
}

/// Sizes of the rates less their mean, each the mean over `together` steps.
std::vector<double> sizes_of(const Grid& grid, std::size_t together) {
  std::vector<double> out(grid.rate.size() / together);
  double mean = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (std::size_t k = 0; k < together; ++k) out[i] += grid.rate[i * together + k].norm() / static_cast<double>(together);
    mean += out[i] / static_cast<double>(out.size());
  }
  for (double& x : out) x -= mean;
  return out;
}

/// The correlation of a[i] with b[i + lag]; -1 where fewer than `least` are in common.
double correlation(const std::vector<double>& a, const std::vector<double>& b, std::ptrdiff_t lag, std::size_t least) {
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -lag);
  const std::ptrdiff_t end = std::min(static_cast<std::ptrdiff_t>(a.size()), static_cast<std::ptrdiff_t>(b.size()) - lag);
  if (end - begin < static_cast<std::ptrdiff_t>(least)) return -1;
  double ab = 0, aa = 0, bb = 0;
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const double x = a[static_cast<std::size_t>(i)], y = b[static_cast<std::size_t>(i + lag)];
    ab += x * y, aa += x * x, bb += y * y;
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : -1;
}

struct Peak {
  std::ptrdiff_t lag = 0;
  double height = -1;
};

/// The highest correlations of lags from `first` to `last`, in order, each more than `apart` from those before it.
std::vector<Peak> peaks_of(const std::vector<double>& a, const std::vector<double>& b, std::ptrdiff_t first, std::ptrdiff_t last, std::size_t least,
                           std::ptrdiff_t apart, std::size_t most) {
  std::vector<Peak> all, out;
  for (std::ptrdiff_t lag = first; lag <= last; ++lag) all.push_back({lag, correlation(a, b, lag, least)});
  std::sort(all.begin(), all.end(), [](const Peak& x, const Peak& y) { return x.height > y.height; });
  for (const Peak& peak : all) {
    if (out.size() == most || peak.height <= 0) break;
    if (std::all_of(out.begin(), out.end(), [&](const Peak& before) { return std::abs(peak.lag - before.lag) > apart; })) out.push_back(peak);
  }
  return out;
}

/// sum of other first^T of vectors at the same instants.
Matrix3d moments(const std::vector<Vector3d>& first, const std::vector<Vector3d>& other, std::ptrdiff_t lag, bool about_mean) {
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -lag);
  const std::ptrdiff_t end = std::min(static_cast<std::ptrdiff_t>(first.size()), static_cast<std::ptrdiff_t>(other.size()) - lag);
  Vector3d mean_first = Vector3d::Zero(), mean_other = Vector3d::Zero();
  Matrix3d sum = Matrix3d::Zero();
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    const Vector3d &a = first[static_cast<std::size_t>(i)], &b = other[static_cast<std::size_t>(i + lag)];
    sum += b * a.transpose(), mean_first += a, mean_other += b;
  }
  const double n = static_cast<double>(end - begin);
  return about_mean ? Matrix3d(sum - mean_other * mean_first.transpose() / n) : sum;
}

struct Procrustes {
  Matrix3d rotation;
  double handedness = 0;  ///< weakest direction over the strongest, negative for a reflection
  double second = 0;      ///< second direction over the strongest
};

/// The rotation R that is nearest to H = sum b a^T: with H = U S V^T, R = U diag(1, 1, det U V^T) V^T (Kabsch 1976).
Procrustes nearest_rotation(const Matrix3d& h) {
  const SymmetricEigen right = symmetric_eigen(h.transpose() * h);  // ascending
  Matrix3d v, u;
  for (int i = 0; i < 3; ++i) v.col(i) = right.vectors.col(2 - i);
  const double strongest = std::sqrt(std::max(0., right.values[2]));
  u.col(0) = (h * v.col(0)).normalized();
  Vector3d second = h * v.col(1);
  second -= u.col(0) * u.col(0).dot(second);
  u.col(1) = second.norm() > 1e-12 * strongest ? Vector3d(second.normalized()) : Vector3d(tangent_basis(u.col(0)).row(0));
  u.col(2) = u.col(0).cross(u.col(1)) * (v.determinant() > 0 ? 1 : -1);  // a rotation
  Procrustes out;
  out.rotation = u * v.transpose();
  out.handedness = u.col(2).dot(h * v.col(2)) / strongest;
  out.second = std::sqrt(std::max(0., right.values[1])) / strongest;
  return out;
}

/// The correlation of the rates at this lag, the others turned by the best rotation.
double agreement(const std::vector<Vector3d>& first, const std::vector<Vector3d>& other, std::ptrdiff_t lag) {
  const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -lag);
  const std::ptrdiff_t end = std::min(static_cast<std::ptrdiff_t>(first.size()), static_cast<std::ptrdiff_t>(other.size()) - lag);
  const std::vector<Vector3d> a(first.begin() + begin, first.begin() + end), b(other.begin() + begin + lag, other.begin() + end + lag);
  const Matrix3d h = moments(a, b, 0, true);
  const double size = moments(a, a, 0, true).trace() * moments(b, b, 0, true).trace();
  return size > 0 ? (nearest_rotation(h).rotation.transpose() * h).trace() / std::sqrt(size) : 0;
}

/// Sets the rotation that turns the first's rates and forces to the other's, from their moments; without forces, from the rates alone.
void set_rotation(const Matrix3d& of_rates, const Matrix3d& of_forces, const Names& names, Alignment& out) {
  constexpr double clear = 0.05;  // of a direction: errors of the readings make less
  constexpr double most_apart = 30 * unit::deg;
  const bool with_forces = !of_forces.isZero(0);
  const Procrustes rates = nearest_rotation(of_rates), forces = with_forces ? nearest_rotation(of_forces) : rates;
  for (const auto& [quantity, found] : {std::pair{"angular rates", rates}, {"forces", forces}})
    if (found.handedness < -clear)
      throw Unsupported(fmt::format("the {} of {} and {} are mirror images; expected right-handed axes: one of their axes has the wrong sign",
                                    quantity, names.first, names.other));
  if (!with_forces && rates.second < clear)
    throw Unsupported(
        fmt::format("{} and {} turn about one axis alone, which does not show how their axes lie; expected turns about two, or "
                    "positions in frame = \"level\"",
                    names.first, names.other));
  const double apart = rotation_log(rates.rotation.transpose() * forces.rotation).norm();
  if (rates.second > clear && forces.second > clear && apart > most_apart)
    throw Unsupported(
        fmt::format("{} and {}: the angular rates show another rotation than the forces, by {:.0f} deg; expected gyros and "
                    "accelerometers in the same axes",
                    names.first, names.other, apart / unit::deg));
  out.rotation = with_forces ? nearest_rotation(of_rates / of_rates.norm() + of_forces / of_forces.norm()).rotation : rates.rotation;
  out.second_rate = rates.second, out.second_force = forces.second;
}

}  // namespace

Alignment aligned(const Stream& first_stream, const Stream& other_stream, const Names& names) {
  constexpr std::size_t together = 10;  // of the coarse search
  constexpr double most_lag_s = 1000;
  const auto same = [](const Sample& a, const Sample& b) { return a.rate == b.rate && a.force == b.force; };
  if (std::equal(first_stream.samples.begin(), first_stream.samples.end(), other_stream.samples.begin(), other_stream.samples.end(), same))
    throw Error(fmt::format("{} and {} have the same readings; expected those of {}", names.first, names.other, names.expected));
  const Grid first = grid_of(first_stream), other = grid_of(other_stream);
  const double length_first = step_s * static_cast<double>(first.rate.size()), length_other = step_s * static_cast<double>(other.rate.size());
  const double shorter = std::min(length_first, length_other);
  const auto refuse_short = [&] {
    throw Unsupported(
        fmt::format("{} and {} have less than {:.0f} s in common; expected records of one motion", names.first, names.other, least_common_s));
  };
  if (shorter < least_common_s) refuse_short();
  // Equal stamps where at least half of the shorter record is then in common: one clock, or two that were set. Else both begin together.
  const double common = std::min(first.begin + length_first, other.begin + length_other) - std::max(first.begin, other.begin);
  const double shift = common > shorter / 2 ? other.begin - first.begin : 0;  // of stamps: other[i] is at first[i] + shift where lag is 0

  const std::vector<double> a = sizes_of(first, together), b = sizes_of(other, together);
  const double step = step_s * static_cast<double>(together);
  const auto lags = [&](double s) { return static_cast<std::ptrdiff_t>(std::llround(s / step)); };
  const std::ptrdiff_t at_equal_stamps = lags(-shift);
  const std::ptrdiff_t most = lags(std::min(most_lag_s, std::max(length_first, length_other)));
  const auto least = static_cast<std::size_t>(std::max(least_common_s, shorter / 2) / step);
  constexpr std::size_t candidates = 8;
  const std::vector<Peak> coarse =
      peaks_of(a, b, at_equal_stamps - most, at_equal_stamps + most, std::min(least, std::min(a.size(), b.size())), lags(0.5), candidates);
  if (coarse.empty()) throw Unsupported(fmt::format("{} and {}: no turns in common; expected turns of some 30 deg/s", names.first, names.other));

  // Sizes of rates do not know their signs: the rates themselves, turned as well as can be, decide between the candidates.
  Alignment out;
  const std::vector<double> fine_a = sizes_of(first, 1), fine_b = sizes_of(other, 1);
  Peak fine;
  for (const Peak& candidate : coarse) {
    const auto middle = candidate.lag * static_cast<std::ptrdiff_t>(together);
    constexpr std::ptrdiff_t around = 20;
    const std::vector<Peak> near = peaks_of(fine_a, fine_b, middle - around, middle + around, 100, 0, 1);
    if (near.empty() || std::abs(near.front().lag - middle) == around) continue;  // a slope of another maximum
    const double height = agreement(first.rate, other.rate, near.front().lag);
    const double offset = other.begin - first.begin + step_s * static_cast<double>(near.front().lag);
    constexpr double alike = 0.98;
    if (height > alike * fine.height && fine.height > alike * height) out.second_offset = offset;
    if (height > fine.height) {
      if (fine.height < alike * height) out.second_offset.reset();
      fine = {near.front().lag, height};
    }
  }
  out.agreement = fine.height;
  const double here = correlation(fine_a, fine_b, fine.lag, 100), before = correlation(fine_a, fine_b, fine.lag - 1, 100),
               after = correlation(fine_a, fine_b, fine.lag + 1, 100), bend = before - 2 * here + after;
  out.offset =
      other.begin - first.begin + step_s * (static_cast<double>(fine.lag) + (bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0));
  constexpr double least_agreement = 0.6;  // noise of a poor gyro in slow turns leaves more
  if (fine.height < least_agreement)
    throw Unsupported(
        fmt::format("{} and {} do not turn alike: the correlation of their angular rates is {:.2f} at most; "
                    "expected {} on one rigid body, in one motion with turns of some 30 deg/s",
                    names.first, names.other, fine.height, names.expected));

  set_rotation(moments(first.rate, other.rate, fine.lag, true), moments(first.force, other.force, fine.lag, false), names, out);
  return out;
}

}  // namespace imulab::common_motion
