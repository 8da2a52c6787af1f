#include "imulab/rig/motion.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab {

namespace {

using Angles = std::array<double, 3>;

constexpr double same_angle = 1e-9;    // rad: below what a decimal number of degrees in a file can mean
constexpr double same_time = 1e-9;     // s: rounding of a time in a file
constexpr double written_time = 1e-3;  // s: times and rates are often written by hand to the millisecond

/// Builds the pieces one after the other.
struct Builder {
  double time = 0;              // up to here
  Angles commanded{}, error{};  // where the axes were sent, and how far from there they are
  std::vector<MotionPiece> pieces{};

  double actual(std::size_t axis) const { return commanded[axis] + error[axis]; }

  MotionPiece resting_until(double end, std::optional<double> temperature) const {
    MotionPiece piece{.begin = time, .end = end, .angle = {}, .temperature = temperature};
    for (std::size_t a = 0; a < 3; ++a) piece.angle[a][0] = actual(a);
    return piece;
  }
  void append(const MotionPiece& piece) {
    if (piece.end <= piece.begin) return;
    pieces.push_back(piece);
    time = piece.end;
  }
  void rest(double end, std::optional<double> temperature) { append(resting_until(end, temperature)); }
};

std::string describe(const Step& step, std::size_t index) {
  return fmt::format("step {} ({} at {:g} s)", index + 1, to_string(step.kind), step.start);
}

/// The gap before a hold: rest, or the move to its angles.
void reach(Builder& build, const Step& step, std::size_t index, const Angles& error) {
  Angles change{};
  bool moves = false;
  for (std::size_t a = 0; a < 3; ++a) {
    change[a] = std::fmod(step.angles[a] - build.commanded[a], 2 * std::numbers::pi);
    if (std::abs(std::remainder(change[a], 2 * std::numbers::pi)) < same_angle) change[a] = 0;
    moves = moves || change[a] != 0;
  }
  if (moves && step.start - build.time < same_time)
    throw Error(fmt::format("{}: its angles differ from those before it, but no time is left to reach them: start_s later than {:g} was expected",
                            describe(step, index), build.time));
  MotionPiece move = build.resting_until(step.start, step.temperature);
  for (std::size_t a = 0; a < 3; ++a) {
    if (change[a] == 0) continue;
    const double whole = change[a] + error[a] - build.error[a];
    move.angle[a] = {build.actual(a), 0, 0, 10 * whole, -15 * whole, 6 * whole};
    build.error[a] = error[a];
  }
  build.append(move);
  build.commanded = step.angles;
}

/// Duration of each ramp of a rotation by `angle` (unsigned) at rate `rate`, and the whole rotation's.
struct Trapezoid {
  double ramp, duration;
};

Trapezoid trapezoid(const Step& step, std::size_t index) {
  const double angle = std::abs(step.angle), available = step.end - step.start;
  if (!(step.rate > 0)) throw Error(fmt::format("{}: rate_dps above 0 was expected", describe(step, index)));
  if (step.acceleration) {
    if (!(*step.acceleration > 0)) throw Error(fmt::format("{}: acceleration_dps2 above 0 was expected", describe(step, index)));
    const double ramp = std::min(step.rate / *step.acceleration, std::sqrt(angle / *step.acceleration));
    const double duration = ramp + (ramp > 0 ? angle / (ramp * *step.acceleration) : 0);
    if (duration > available + written_time)
      throw Error(fmt::format("{}: {:g} deg at {:g} deg/s and {:g} deg/s^2 take {:.9g} s, but the step lasts {:.9g} s", describe(step, index),
                              step.angle / unit::deg, step.rate / unit::deg, *step.acceleration / unit::deg, duration, available));
    return {ramp, std::min(duration, available)};
  }
  const double cruise = angle / step.rate;
  if (cruise > available + written_time || cruise < available / 2 - written_time)
    throw Error(
        fmt::format("{}: {:g} deg at {:g} deg/s take {:.9g} to {:.9g} s (with ramps), but the step lasts {:.9g} s; give acceleration_dps2 where the "
                    "axis waits",
                    describe(step, index), step.angle / unit::deg, step.rate / unit::deg, cruise, 2 * cruise, available));
  return {std::clamp(available - cruise, 0.0, available / 2), available};
}

void rotate(Builder& build, const Step& step, std::size_t index, const Angles& error) {
  const auto axis = static_cast<std::size_t>(step.axis);
  const auto [ramp, duration] = trapezoid(step, index);
  build.rest(step.start, step.temperature);
  const double whole = step.angle + error[axis] - build.error[axis];
  const double cruise = duration - 2 * ramp, rate = duration > ramp ? whole / (duration - ramp) : 0.0;
  double angle = build.actual(axis);
  const auto append = [&](double lasting, double linear, double quadratic) {
    MotionPiece piece = build.resting_until(build.time + lasting, step.temperature);
    piece.angle[axis] = {angle, linear, quadratic, 0, 0, 0};
    build.append(piece);
    angle += linear + quadratic;
  };
  append(ramp, 0, rate * ramp / 2);
  append(cruise, rate * cruise, 0);
  append(ramp, rate * ramp, -rate * ramp / 2);
  build.commanded[axis] += step.angle;
  build.error[axis] = error[axis];
}

}  // namespace

bool MotionPiece::at_rest() const {
  return std::all_of(angle.begin(), angle.end(),
                     [](const AnglePolynomial& p) { return std::all_of(p.begin() + 1, p.end(), [](double c) { return c == 0; }); });
}

RigMotion rig_motion(std::span<const Step> steps, const RigErrors& errors) {
  if (steps.empty()) throw Error("there are no steps: [[step]] says what the rig does");
  if (!errors.angle.empty() && errors.angle.size() != steps.size()) throw Error("one angle error for each step was expected");
  Builder build;
  const bool there_at_once = steps.front().kind == StepKind::hold && steps.front().start < same_time;
  if (there_at_once) build.commanded = steps.front().angles;
  if (there_at_once && !errors.angle.empty()) build.error = errors.angle.front();
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    const Angles error = errors.angle.empty() ? Angles{} : errors.angle[k];
    if (step.kind == StepKind::spin) throw Error(describe(step, k) + ": a turntable's or a hand's steps are hold and rotate");
    if (step.start < build.time - same_time || step.end <= step.start)
      throw Error(fmt::format("{}: a start_s from {:g} on and a later end_s were expected", describe(step, k), build.time));
    if (step.kind == StepKind::hold)
      reach(build, step, k, error);
    else
      rotate(build, step, k, error);
    build.rest(step.end, step.temperature);
  }
  return {errors.axes, std::move(build.pieces)};
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

BodyState body_state(const RigMotion& motion, double t) {
  const auto after = std::upper_bound(motion.pieces.begin(), motion.pieces.end(), t, [](double x, const MotionPiece& p) { return x < p.end; });
  return turntable_state(motion.axes, axis_states(after == motion.pieces.end() ? motion.pieces.back() : *after, t));
}

std::vector<Step> steps_of(const Session& session, const RecordingSource& source) {
  for (const RigDeclaration& rig : session.rigs)
    if ((source.rig.empty() || rig.name == source.rig) && rig.kind != RigKind::turntable && rig.kind != RigKind::none)
      throw Error(fmt::format("[rig] kind = \"{}\": motion by axis angles, \"turntable\" or \"none\" (a hand), was expected", to_string(rig.kind)));
  std::vector<Step> steps;
  for (const Step& step : session.steps)
    if (session.recordings.size() < 2 || step.recording == source.file) steps.push_back(step);
  return steps;
}

}  // namespace imulab
