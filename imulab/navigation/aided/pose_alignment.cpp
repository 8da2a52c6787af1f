#include "imulab/navigation/aided/pose_alignment.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/common_motion.hpp"
#include "imulab/navigation/inertial_samples.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace imulab::aided {
namespace {

using common_motion::Sample, common_motion::Stream;

constexpr double window = 0.05, step = 0.01;  // s: of a mean rate, which reduces the noise of attitudes; between two means
constexpr double half_span = 0.25;            // s: a second difference of positions with less has more noise than acceleration
constexpr double usual_gravity = 9.81;        // m/s^2: its direction counts, not its size

/// Sums of the readings from the begin of a recording to any time.
class ReadingSums {
 public:
  explicit ReadingSums(const Recording& recording) {
    for_each_increment(recording, {0, recording.size()}, [&](const TimedIncrement& read, double end) {
      if (time_.empty()) add(end - read.interval, Vector3d::Zero(), Vector3d::Zero());
      add(end, angle_.back() + read.increment.angle, velocity_.back() + read.increment.velocity);
    });
  }
  double begin() const { return time_.front(); }
  double end() const { return time_.back(); }
  Sample mean(double from, double to) const {
    return {from, to, (at(angle_, to) - at(angle_, from)) / (to - from), (at(velocity_, to) - at(velocity_, from)) / (to - from)};
  }

 private:
  void add(double time, const Vector3d& angle, const Vector3d& velocity) {
    time_.push_back(time), angle_.push_back(angle), velocity_.push_back(velocity);
  }
  Vector3d at(const std::vector<Vector3d>& sums, double t) const {
    const auto after = std::clamp<std::ptrdiff_t>(std::ranges::upper_bound(time_, t) - time_.begin(), 1, std::ssize(time_) - 1);
    const auto i = static_cast<std::size_t>(after);
    return sums[i - 1] + (t - time_[i - 1]) / (time_[i] - time_[i - 1]) * (sums[i] - sums[i - 1]);
  }

  std::vector<double> time_;
  std::vector<Vector3d> angle_, velocity_;
};

Stream stream_of(const ReadingSums& sums) {
  Stream out{.samples = {}, .interval = step};
  for (double t = sums.begin(); t + window <= sums.end(); t += step) out.samples.push_back(sums.mean(t, t + window));
  return out;
}

Eigen::Quaterniond quaternion(const Eigen::Vector4d& xyzw) { return Eigen::Quaterniond(xyzw); }

double time_of(const AidRecord& r, std::size_t row) { return 1e-9 * static_cast<double>(r.time[row]); }

/// Returns the row that follows `row` by a time, or nothing across a gap.
std::optional<std::size_t> row_after(const AidRecord& r, std::size_t row, double seconds) {
  std::size_t next = row + 1;
  while (next < r.time.size() && time_of(r, next) - time_of(r, row) < seconds - 1e-6) ++next;
  const bool near = next < r.time.size() && time_of(r, next) - time_of(r, row) < 2 * seconds + 0.5 * window;
  return near ? std::optional(next) : std::nullopt;
}

/// The rows before and after another one by `half_span`.
struct Neighbors {
  std::size_t before = 0, after = 0;
  double by_before = 0, by_after = 0;  // s
};
std::optional<Neighbors> neighbors(const AidRecord& r, std::size_t row) {
  const auto after = row_after(r, row, half_span);
  std::size_t before = row;
  while (before > 0 && time_of(r, row) - time_of(r, before) < half_span - 1e-6) --before;
  if (!after || time_of(r, row) - time_of(r, before) < half_span - 1e-6) return std::nullopt;
  return Neighbors{before, *after, time_of(r, row) - time_of(r, before), time_of(r, *after) - time_of(r, row)};
}

/// Returns the second difference of a quantity about a row: a mean of its second derivative.
template <class Quantity>
auto second_difference(const Neighbors& n, std::size_t row, const Quantity& at) {
  return (2 * ((at(n.after) - at(row)) / n.by_after - (at(row) - at(n.before)) / n.by_before) / (n.by_before + n.by_after)).eval();
}

/// Returns a mean of the acceleration of the tracked point in the frame of the poses.
std::optional<Vector3d> acceleration_at(const AidRecord& r, std::size_t row) {
  const auto n = neighbors(r, row);
  if (r.place.empty() || !n) return std::nullopt;
  const Vector3d out = second_difference(*n, row, [&](std::size_t i) { return r.place[i]; });
  return out.allFinite() ? std::optional(out) : std::nullopt;
}

/// Returns mean rates of the tracked body and, in frames whose z axis is up, its specific forces.
Stream stream_of(const AidRecord& r, const std::vector<Eigen::Vector4d>& attitude, bool upright) {
  Stream out{.samples = {}, .interval = step};
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    const auto j = row_after(r, i, window);
    if (!j || !attitude[i].allFinite() || !attitude[*j].allFinite()) continue;
    Sample mean{time_of(r, i), time_of(r, *j), Vector3d::Zero(), Vector3d::Zero()};
    mean.rate = rotation_log((quaternion(attitude[i]).conjugate() * quaternion(attitude[*j])).toRotationMatrix()) / (mean.end - mean.begin);
    if (upright) {
      const auto acceleration = acceleration_at(r, i);
      if (!acceleration) continue;
      mean.force = quaternion(attitude[i]).conjugate() * (*acceleration + usual_gravity * Vector3d::UnitZ());
    }
    out.samples.push_back(mean);
  }
  return out;
}

/// The force at the poses, in their frame.
struct FrameForces {
  std::vector<std::optional<Vector3d>> at;  // each row
  Vector3d mean = Vector3d::Zero();
};
FrameForces forces_in_frame(const ReadingSums& sums, const AidRecord& r, double offset, const Matrix3d& body) {
  FrameForces out;
  double count = 0;
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    const double t = time_of(r, i) - offset;
    out.at.emplace_back();
    if (t - window / 2 < sums.begin() || t + window / 2 > sums.end() || !r.attitude[i].allFinite()) continue;
    out.at.back() = quaternion(r.attitude[i]) * (body.transpose() * sums.mean(t - window / 2, t + window / 2).force);
    out.mean += *out.at.back(), ++count;
  }
  if (count > 0) out.mean /= count;
  return out;
}

/// Returns the mean force about a row with the weights of a second difference, a triangle.
std::optional<Vector3d> mean_force(const AidRecord& r, const FrameForces& forces, std::size_t row) {
  Vector3d sum = Vector3d::Zero();
  double weights = 0;
  const auto take = [&](std::size_t k) {
    const double weight = half_span - std::abs(time_of(r, k) - time_of(r, row));
    if (weight > 0 && forces.at[k]) sum += weight * *forces.at[k], weights += weight;
    return weight > 0;
  };
  for (std::size_t k = row; k < r.time.size() && take(k); ++k) {
  }
  for (std::size_t k = row; k-- > 0 && take(k);) {
  }
  return weights > 0 ? std::optional<Vector3d>(sum / weights) : std::nullopt;
}

/// Returns the scale s and a lever arm l by least squares, s y'' = f - g up + (C l)'', if positions explain the accelerations.
std::optional<double> scale_of(const AidRecord& r, const FrameForces& forces, const Vector3d& up) {
  Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double squares = 0;
  for (std::size_t i = 0; i < r.time.size(); ++i) {
    const auto acceleration = acceleration_at(r, i);
    const auto force = mean_force(r, forces, i);
    if (!acceleration || !force) continue;
    Eigen::Matrix<double, 3, 4> row;
    row << *acceleration, -second_difference(*neighbors(r, i), i, [&](std::size_t k) { return quaternion(r.attitude[k]).toRotationMatrix(); });
    const Vector3d by_imu = *force - up * forces.mean.norm();
    if (!row.allFinite()) continue;
    N += row.transpose() * row, right += row.transpose() * by_imu, squares += by_imu.squaredNorm();
  }
  constexpr double least_turns = 1e-6;  // m^2/s^4: without turns the lever arm stays zero
  N.diagonal().tail<3>().array() += least_turns;
  const Eigen::Vector4d x = N.ldlt().solve(right);
  const Vector3d arm = N.bottomRightCorner<3, 3>().ldlt().solve(right.tail<3>());
  const double with = squares - x.dot(right), without = squares - arm.dot(right.tail<3>());
  constexpr double explained = 2;  // ratio of the squares: that of noise alone is near 1
  return x.allFinite() && without > explained * with ? std::optional(x[0]) : std::nullopt;
}

/// Throws Unsupported for turns that the inverse quaternions explain.
common_motion::Alignment aligned_turns(const Stream& imu, const AidRecord& r, bool upright, const common_motion::Names& names) {
  const Stream poses = stream_of(r, r.attitude, upright);
  if (poses.samples.size() < 2) throw Unsupported(names.other + ": has no two attitudes within 0.1 s; expected at least 10 in a second");
  try {
    return common_motion::aligned(imu, poses, names);
  } catch (const Unsupported&) {
    std::vector<Eigen::Vector4d> inverse;
    for (const Eigen::Vector4d& q : r.attitude) inverse.push_back(quaternion(q).conjugate().coeffs());
    try {
      common_motion::aligned(imu, stream_of(r, inverse, false), names);
    } catch (const Error&) {
      inverse.clear();
    }
    if (!inverse.empty())
      throw Unsupported(
          names.other +
          ": its quaternions turn from the frame to the tracked body, or have w in another place; expected x, y, z, w of the turn from the "
          "body to the frame");
    throw;
  }
}

}  // namespace

PoseAlignment align_poses(const Recording& recording, const Aid& aid, const std::string& name) {
  const AidRecord& r = aid.record;
  const bool upright = aid.frame != AidFrame::free && !r.place.empty() && aid.scale_known;
  const ReadingSums sums(recording);
  const common_motion::Alignment turns = aligned_turns(stream_of(sums), r, upright, {recording.name, name, "an IMU and what is tracked"});
  constexpr double about_two = 0.05, accelerated = 1e-4;  // of the largest motion: errors of the readings are below
  if (turns.second_rate < about_two && turns.second_force < accelerated)
    throw Unsupported(
        fmt::format("{} and {} turn about one axis alone and hardly accelerate, which does not show how their axes lie; expected turns "
                    "about two axes, or accelerations",
                    recording.name, name));
  PoseAlignment out{.offset = turns.offset, .body = turns.rotation.transpose()};
  const FrameForces forces = forces_in_frame(sums, r, turns.offset, out.body);
  const Vector3d up = aid.frame == AidFrame::free ? Vector3d(forces.mean.normalized()) : Vector3d::UnitZ();
  if (aid.frame == AidFrame::free) out.frame = shortest_rotation(up, Vector3d::UnitZ());
  if (r.place.empty()) return out;
  const std::optional<double> scale = scale_of(r, forces, up);
  constexpr double far = 1.5;  // beyond errors of a first guess
  if (!aid.scale_known) {
    if (!scale) throw Unsupported(name + ": its positions hardly accelerate, which does not show their scale; expected motion, or scale = \"known\"");
    out.scale = *scale;
  } else if (scale && *scale < 0) {
    throw Unsupported(name + ": its positions accelerate against the IMU; expected right-handed axes, and attitudes of the same frame");
  } else if (scale && (*scale > far || *scale < 1 / far)) {
    throw Unsupported(fmt::format(
        "{}: one unit of its positions is {:.3g} m by the accelerations of the IMU; expected metres, or scale = \"unknown\"", name, *scale));
  }
  return out;
}

}  // namespace imulab::aided
