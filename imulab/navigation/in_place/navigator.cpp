#include "imulab/navigation/in_place/navigator.hpp"

#include "imulab/earth.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/navigation/integration/increment.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab::in_place {

using Eigen::Index;

namespace {

/// Returns the interval of a sample: an IMU that rests on both sides of a gap also rested inside it.
double interval(const Recording& r, std::size_t i, const Block& block) {
  if (block.at_rest && i > 0 && r.follows_gap(i)) return r.time_s(i) - r.time_s(i - 1);
  return r.interval(i, r.gyro_increment);
}

}  // namespace

Navigator::Navigator(const Recording& recording, const SensorModel& model, double delay, double latitude, double gravity,
                     const OptionalSums& optional)
    : readings(recording, model),
      recording_(recording),
      lever_arm_(model.lever_arm),
      late_(std::clamp(delay / recording.interval_s, -1.0, 1.0)),
      optional_(optional),
      earth_rate_(earth_rate_enu(latitude)),
      gravity_(0, 0, -gravity) {}

void Navigator::align(const Range& range) {
  Vector3d force = Vector3d::Zero(), rate = Vector3d::Zero();
  for (std::size_t i = range.begin; i < range.end; ++i) force += readings.force(i), rate += readings.rate(i);
  if (!(rate.cross(force).norm() > 0)) rate = force.unitOrthogonal();
  C_nb = rotation_from_directions(Vector3d::UnitZ(), Vector3d::UnitY(), force, rate);
}

/// Central differences over a block sum to the change of the rate from its start to its end.
Vector3d Navigator::angular_acceleration(std::size_t i) {
  const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, recording_.size() - 1);
  return (readings.rate(after) - readings.rate(before)) / (static_cast<double>(after - before) * recording_.interval_s);
}

Vector3d Navigator::force_at_origin(std::size_t i) {
  const auto effect_at = [&](std::size_t k) { return Vector3d(size_effect(readings.rate(k), angular_acceleration(k), lever_arm_)); };
  const std::size_t neighbor = late_ > 0 ? std::max<std::size_t>(i, 1) - 1 : std::min(i + 1, recording_.size() - 1);
  return readings.force(i) - ((1 - std::abs(late_)) * effect_at(i) + std::abs(late_) * effect_at(neighbor));
}

BlockSums Navigator::over(const Block& block, std::size_t first) {
  BlockSums sum;
  if (block.observed || block.lost) velocity_.setZero();
  pushes_.setZero(), squares_.setZero();
  for (std::size_t i = block.samples.begin; i < block.samples.end; ++i) add(sum, i, first, block);
  if (optional_.parts) sum.end_parts();
  if (const auto n = static_cast<double>(block.samples.size()); optional_.parts && block.at_rest && n > 1)
    sum.shaking = (squares_ - pushes_.cwiseAbs2() / n) / (n - 1);
  return sum;
}

void Navigator::add(BlockSums& sum, std::size_t i, std::size_t first, const Block& block) {
  const double dt = interval(recording_, i, block);
  const Vector3d rate = readings.rate(i), force = block.at_rest || lever_arm_.isZero() ? readings.force(i) : force_at_origin(i);
  const Increment sample{rate * dt, force * dt};
  const integration::BodyStep step = i > first ? integration::body_step(sample, previous_) : integration::body_step({&sample, 1});
  previous_ = sample;

  const Vector3d turn = dt * earth_rate_;  // rotation of east-north-up
  const Vector3d turn_b = C_nb.transpose() * turn;
  const Vector3d pushed = C_nb * step.velocity;
  const Matrix3d before = C_nb;
  C_nb = before * rotation_exp(step.rotation - turn_b - 0.5 * turn_b.cross(step.rotation));  // exp(-turn) C exp(rotation)
  sum.velocity += pushed - 0.5 * turn.cross(pushed) + dt * gravity_;

  // Simpson's rule within the sample: unobservable directions remain unobservable only if the derivatives are accurate.
  const Matrix3d K = skew<double>(step.rotation);
  const Matrix3d half = 0.5 * (before + C_nb) - 0.125 * before * K * K;
  // The rate and force that errors multiply are noise-free if known: otherwise an axis without rate or gravity would fit its own noise with a scale.
  ErrorStep error{dt,
                  block.at_rest ? Vector3d(half.transpose() * earth_rate_) : rate,
                  block.observed ? Vector3d(half.transpose() * -gravity_) : force,
                  (dt / 6) * (before + 4 * half + C_nb),
                  (dt * dt / 6) * (before + 2 * half),
                  {}};
  for (Index b = 0; b < 3; ++b) {
    Matrix3d& with_force = error.with_force[static_cast<std::size_t>(b)];
    if (block.observed)  // C_nb f_b, where f_b = C_bn (0, 0, g) turns
      with_force = (-gravity_.z() * dt / 6) * (before(2, b) * before + 4 * half(2, b) * half + C_nb(2, b) * C_nb);
    else
      with_force = force[b] * error.once;
  }
  if (!block.observed) {
    const Vector3d gained = pushed + dt * gravity_, moving = velocity_ + 0.5 * gained;
    error.moved = skew<double>(moving) * error.once;
    sum.path += dt * moving;
    velocity_ += gained;
  }
  if (!block.at_rest && (optional_.delay || optional_.lever_arm)) error.turning = {rate, force, angular_acceleration(i)};
  if (optional_.parts && block.at_rest) {
    const Vector3d push = force - error.force;
    pushes_ += push, squares_ += push.cwiseAbs2();
  }
  sum.add(error, skew<double>(Vector3d(-gravity_)), optional_);
}

namespace {

std::size_t samples_of(const Recording& recording, double seconds) { return static_cast<std::size_t>(std::lround(seconds / recording.interval_s)); }

/// Returns a bound on the difference of the rate at the end of sample i - 1 from the mean of its neighbors, from the change of slope there.
double kink(const Recording& recording, std::size_t i) {
  double sum = 0;
  for (const std::vector<double>& rate : recording.gyro) {
    const double bend = rate[i + 1] - rate[i] - rate[i - 1] + rate[i - 2];
    sum += bend * bend;
  }
  return std::sqrt(sum);
}

double rate_size(const Recording& recording, std::size_t i) { return std::hypot(recording.gyro[0][i], recording.gyro[1][i], recording.gyro[2][i]); }

/// Returns the end of a motion's block. The accelerometer velocity depends on lever arm and rate, so the lever arm is determined as accurately as the
/// rate at the end. A block therefore ends where the rate is smoothest, between half and three halves of its length. A noise-free steady turn, as in
/// predictions, is equally smooth everywhere; rounding must not decide, and the length remains.
std::size_t smooth_end(const Recording& recording, std::size_t begin, std::size_t length, std::size_t end) {
  constexpr double rounding = 1e-12;  // relative to the rate: above the rounding of any computation, far below a gyro's noise
  const std::size_t first = begin + std::max<std::size_t>(2, (length + 1) / 2);
  std::size_t best = std::min(begin + length, end);
  double least = best >= first && best + 1 < end ? kink(recording, best) : std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i <= begin + 3 * length / 2 && i + 1 < end; ++i)
    if (const double bend = kink(recording, i); bend + rounding * rate_size(recording, i) < least) {
      least = bend;
      best = i;
    }
  return best;
}

}  // namespace

std::vector<Range> still_parts(const Recording& recording, std::vector<Range> rests) {
  const std::size_t margin = samples_of(recording, settling_time);
  for (Range& rest : rests)
    if (rest.size() > 5 * margin) rest = {rest.begin + margin, rest.end - margin};
  return rests;
}

Blocks cut_into_blocks(const Recording& recording, const std::vector<Range>& rests, bool observe_motion) {
  Blocks out;
  bool lost = false;
  const auto cut = [&](const Range& range, double seconds, bool at_rest) {
    const std::size_t length = std::max<std::size_t>(1, samples_of(recording, seconds));
    for (std::size_t begin = range.begin; begin < range.end;) {
      std::size_t end = at_rest ? std::min(begin + length, range.end) : smooth_end(recording, begin, length, range.end);
      if (range.end - end < length / 2) end = range.end;  // avoids short remainders
      out.blocks.push_back({{begin, end}, at_rest, at_rest || observe_motion, std::exchange(lost, false)});
      begin = end;
    }
  };
  for (std::size_t k = 0; k < rests.size(); ++k) {
    if (k > 0 && rests[k].begin > rests[k - 1].end) {
      const Range motion{rests[k - 1].end, rests[k].begin};
      const bool gap = recording.gaps_in({motion.begin, motion.end + 1}) > 0;
      lost = gap || recording.saturated_in(motion) > 0;
      if (lost)
        out.warnings.push_back(
            fmt::format("the motion from {:.2f} to {:.2f} s has {}; it is not used, and the attitude is aligned anew at the next rest",
                        recording.time_s(motion.begin), recording.time_s(motion.end), gap ? "a gap" : "saturated samples"));
      else
        cut(motion, 0.2, false);
    }
    cut(rests[k], 1, true);
  }
  return out;
}

}  // namespace imulab::in_place
