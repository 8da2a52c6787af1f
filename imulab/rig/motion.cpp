#include "imulab/rig/motion.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/stamp_text.hpp"
#include "imulab/error.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/rig/table_attitude.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab {

namespace {

using Angles = std::array<double, 3>;

constexpr double written_time = 1e-3;  // s: times and rates are often given by hand to the millisecond

/// Builds the pieces one after the other.
struct Builder {
  double commanded_time = 0, time = 0;  // commanded and carried out so far: a late rotation ends after its step
  Angles actual{};
  std::vector<MotionPiece> pieces{};

  MotionPiece resting_for(double duration, std::optional<double> temperature) const {
    MotionPiece piece;
    piece.begin = time, piece.end = time + duration, piece.temperature = temperature;
    for (std::size_t a = 0; a < 3; ++a) piece.angle[a][0] = actual[a];
    return piece;
  }
  void append(const MotionPiece& piece) {
    if (piece.end <= piece.begin) return;
    pieces.push_back(piece);
    time = piece.end;
  }
  void rest_until(double end, std::optional<double> temperature) {
    MotionPiece piece = resting_for(0, temperature);
    piece.end = end;
    append(piece);
  }
};

/// The gap before a hold: rest, or the move to its angles.
void reach(Builder& build, const Step& step, std::size_t index, const AxisCommand& command, const Angles& error_change) {
  const double gap = step.start - build.commanded_time;
  const bool moves = std::any_of(command.moves.begin(), command.moves.end(), [](bool m) { return m; });
  if (moves && gap < same_time)
    throw Error(fmt::format("{}: its angles differ from those of the previous step, without time to reach them; expected a start later than {} s",
                            step_name(step, index), stamp_text(build.commanded_time)));
  if (!moves) return build.rest_until(step.start, step.temperature);
  MotionPiece move = build.resting_for(gap, step.temperature);
  for (std::size_t a = 0; a < 3; ++a) {
    if (!command.moves[a]) continue;
    const double whole = std::fmod(command.after[a] - command.before[a], 2 * std::numbers::pi) + error_change[a];
    move.angle[a] = {build.actual[a], 0, 0, 10 * whole, -15 * whole, 6 * whole};
    build.actual[a] += whole;
  }
  build.append(move);
}

/// Duration of each ramp of a rotation by `angle` (unsigned) at rate `rate`, and the whole rotation's.
struct Trapezoid {
  double ramp, duration;
};

Trapezoid trapezoid(const Step& step, std::size_t index) {
  const double angle = std::abs(step.angle), available = step.end - step.start;
  if (!(step.rate > 0)) throw Error(fmt::format("{}: the rate is not positive; expected a rate above 0", step_name(step, index)));
  if (step.acceleration) {
    if (!(*step.acceleration > 0)) throw Error(fmt::format("{}: the acceleration is not positive; expected one above 0", step_name(step, index)));
    const double ramp = std::min(step.rate / *step.acceleration, std::sqrt(angle / *step.acceleration));
    const double duration = ramp + (ramp > 0 ? angle / (ramp * *step.acceleration) : 0);
    if (duration > available + written_time)
      throw Error(fmt::format("{}: {:g} deg at {:g} deg/s and {:g} deg/s^2 take {:.9g} s, but the step lasts {:.9g} s", step_name(step, index),
                              step.angle / unit::deg, step.rate / unit::deg, *step.acceleration / unit::deg, duration, available));
    return {ramp, std::min(duration, available)};
  }
  const double cruise = angle / step.rate;
  if (cruise > available + written_time || cruise < available / 2 - written_time)
    throw Error(
        fmt::format("{}: {:g} deg at {:g} deg/s take {:.9g} to {:.9g} s (with ramps), but the step lasts {:.9g} s; give the acceleration if the "
                    "axis waits",
                    step_name(step, index), step.angle / unit::deg, step.rate / unit::deg, cruise, 2 * cruise, available));
  return {std::clamp(available - cruise, 0.0, available / 2), available};
}

void rotate(Builder& build, const Step& step, std::size_t index, const Angles& error_change, double delay) {
  const auto axis = static_cast<std::size_t>(step.axis);
  auto [ramp, duration] = trapezoid(step, index);
  // A rotation-time error stretches the whole motion; no rig is late or early by a factor of two of its rate.
  const double stretch = duration > 0 ? std::clamp(1 + delay / duration, 0.5, 2.0) : 1;
  ramp *= stretch, duration *= stretch;
  build.rest_until(step.start, step.temperature);
  const double whole = step.angle + error_change[axis];
  const double cruise = duration - 2 * ramp, rate = duration > ramp ? whole / (duration - ramp) : 0.0;
  double angle = build.actual[axis];
  const auto append = [&](double lasting, double linear, double quadratic) {
    MotionPiece piece = build.resting_for(lasting, step.temperature);
    piece.angle[axis] = {angle, linear, quadratic, 0, 0, 0};
    build.append(piece);
    angle += linear + quadratic;
  };
  append(ramp, 0, rate * ramp / 2);
  append(cruise, rate * cruise, 0);
  append(ramp, rate * ramp, -rate * ramp / 2);
  build.actual[axis] += whole;
}

/// The rig with its errors.
struct ActualRig {
  RigAxes axes;
  Matrix3d C_nt;
  std::vector<Angles> error_before, error_after;  ///< rad: actual less commanded angle, by step
  std::vector<double> delay;                      ///< s: by how much each step's rotation takes longer
};

ActualRig actual_rig(const RigErrors& errors, std::size_t steps) {
  const RigErrorIndex index = index_of(errors.sources, steps);
  const auto value = [&](int source) { return source == RigErrorIndex::none ? 0.0 : errors.values[static_cast<std::size_t>(source)]; };
  Orthogonality<double> orthogonality;
  for (std::size_t a = 0; a < 3; ++a) orthogonality[a] = {value(index.orthogonality[a][0]), value(index.orthogonality[a][1])};
  ActualRig rig{table_axes(orthogonality), table_tilt(value(index.tilt[0]), value(index.tilt[1])), {}, {}, {}};
  for (std::size_t k = 0; k < steps; ++k) {
    Angles before, after;
    for (std::size_t a = 0; a < 3; ++a) {
      before[a] = value(index.zero[a]) + value(index.angle_before[k][a]);
      after[a] = value(index.zero[a]) + value(index.angle_after[k][a]);
    }
    rig.error_before.push_back(before);
    rig.error_after.push_back(after);
    rig.delay.push_back(value(index.timing[k]));
  }
  return rig;
}

}  // namespace

bool MotionPiece::at_rest() const {
  return std::all_of(angle.begin(), angle.end(),
                     [](const AnglePolynomial& p) { return std::all_of(p.begin() + 1, p.end(), [](double c) { return c == 0; }); });
}

RigMotion rig_motion(std::span<const Step> steps, const RigErrors& errors) {
  if (steps.empty()) throw Error("no steps; expected at least one");
  const ActualRig rig = actual_rig(errors, steps.size());
  const std::vector<AxisCommand> commands = commands_of(steps);
  Builder build;
  for (std::size_t a = 0; a < 3; ++a) build.actual[a] = commands.front().before[a] + rig.error_before.front()[a];
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    if (step.kind == StepKind::spin) throw Error(step_name(step, k) + ": a turntable or a hand does not spin; expected hold or rotate");
    if (step.start < build.commanded_time - same_time || step.end <= step.start)
      throw Error(
          fmt::format("{}: wrong times; expected a start from {} s on and a later end", step_name(step, k), stamp_text(build.commanded_time)));
    Angles error_change;
    for (std::size_t a = 0; a < 3; ++a) error_change[a] = rig.error_after[k][a] - rig.error_before[k][a];
    if (step.kind == StepKind::hold) {
      reach(build, step, k, commands[k], error_change);
    } else {
      rotate(build, step, k, error_change, rig.delay[k]);
    }
    build.rest_until(step.end, step.temperature);
    build.commanded_time = step.end;
  }
  return {.axes = rig.axes, .C_nt = rig.C_nt, .pieces = std::move(build.pieces)};
}

AxisStates axis_states(const MotionPiece& piece, double t) {
  const double duration = piece.end - piece.begin, u = (t - piece.begin) / duration;
  AxisStates states;
  for (std::size_t a = 0; a < 3; ++a) {
    const AnglePolynomial& p = piece.angle[a];
    double value = 0, first = 0, half_second = 0;  // Horner, with derivatives
    for (std::size_t k = p.size(); k-- > 0;) {
      half_second = half_second * u + first;
      first = first * u + value;
      value = value * u + p[k];
    }
    states[a] = {value, first / duration, 2 * half_second / (duration * duration)};
  }
  return states;
}

BodyState body_state(const RigMotion& motion, const MotionPiece& piece, double t) {
  const BodyState table = turntable_state(motion.axes, axis_states(piece, t), motion.C_nt);
  const Matrix3d C_bt = piece.C_tb.transpose();
  return {table.C_nb * piece.C_tb, C_bt * table.rate_nb_b, C_bt * table.angular_acceleration_nb_b};
}

BodyState body_state(const RigMotion& motion, double t) {
  const auto after = std::upper_bound(motion.pieces.begin(), motion.pieces.end(), t, [](double x, const MotionPiece& p) { return x < p.end; });
  return body_state(motion, after == motion.pieces.end() ? motion.pieces.back() : *after, t);
}

RigAxes ideal_axes() { return {Vector3d::UnitZ(), Vector3d::UnitY(), Vector3d::UnitX()}; }

BodyState turntable_state(const RigAxes& axes, const AxisStates& states, const Matrix3d& C_nt) {
  const auto& [outer, middle, inner] = states;
  const Matrix3d C_middle = rotation_about(axes[1], middle.angle), C_inner = rotation_about(axes[2], inner.angle);
  // The axes as the body sees them: an axis is fixed in the frame it carries, and turned back by the axes inside it.
  const Vector3d& l_inner = axes[2];
  const Vector3d l_middle = C_inner.transpose() * axes[1];
  const Vector3d l_outer = C_inner.transpose() * (C_middle.transpose() * axes[0]);
  const Vector3d rate_inner = inner.rate * l_inner, rate_middle = middle.rate * l_middle, rate_outer = outer.rate * l_outer;
  // l_middle turns in b with -rate_inner, l_outer with -(rate_middle + rate_inner).
  const Vector3d turning_axes = -rate_inner.cross(rate_middle) - (rate_middle + rate_inner).cross(rate_outer);
  return {C_nt * rotation_about(axes[0], outer.angle) * C_middle * C_inner, rate_outer + rate_middle + rate_inner,
          outer.acceleration * l_outer + middle.acceleration * l_middle + inner.acceleration * l_inner + turning_axes};
}

Motion sensed_motion(const BodyState& body, const Surroundings& surroundings) {
  const Vector3d rate_ie_b = body.C_nb.transpose() * surroundings.rate_ie_n;
  const Vector3d w = body.rate_nb_b + rate_ie_b;                                            // w_ib_b
  const Vector3d w_dot = body.angular_acceleration_nb_b - body.rate_nb_b.cross(rate_ie_b);  // Earth's rate turns in b with -w_nb_b
  return {.rate = w,
          .force = surroundings.gravity * body.C_nb.row(2).transpose() +  // C_bn (0, 0, g)
                   size_effect(w, w_dot, surroundings.lever_arm)};
}

}  // namespace imulab
