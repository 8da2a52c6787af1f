#include "imulab/rig/machine.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab {

namespace {

Vector3d axis_vector(const BodyAxis& axis) { return axis.sign * Vector3d::Unit(axis.index); }

}  // namespace

bool is_machine(RigKind kind) { return kind == RigKind::rate_table || kind == RigKind::centrifuge || kind == RigKind::chamber; }

std::string mount_name(const Mount& mount) {
  const auto name = [](const BodyAxis& axis) { return fmt::format("{}{}", axis.sign > 0 ? '+' : '-', "xyz"[axis.index]); };
  return name(mount.up) + name(mount.outward);
}

Matrix3d mount_attitude(const Mount& mount) {
  const Vector3d up = axis_vector(mount.up), north = axis_vector(mount.outward);
  Matrix3d C_nb;  // rows: east, north, up in body axes
  C_nb << north.cross(up).transpose(), north.transpose(), up.transpose();
  return C_nb;
}

Mount mount_of(const Step& step) { return step.mount.value_or(Mount{}); }

std::vector<RigErrorSource> machine_error_sources(const RigDeclaration& rig, std::span<const Step> steps) {
  std::vector<RigErrorSource> sources;
  for (std::size_t direction = 0; direction < 2; ++direction) {
    sources.push_back(declared(RigErrorKind::tilt, rig.zero));
    sources.back().axis = direction;
  }
  const bool turns = rig.kind != RigKind::chamber;
  if (turns) sources.push_back(declared(RigErrorKind::rate, rig.rate));
  std::vector<Mount> mounts;
  for (const Step& step : steps) {
    const Mount mount = mount_of(step);
    if (std::find(mounts.begin(), mounts.end(), mount) != mounts.end()) continue;
    mounts.push_back(mount);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sources.push_back(declared(RigErrorKind::mount, rig.mount));
      sources.back().axis = axis, sources.back().place = mount;
    }
    if (!turns) continue;
    sources.push_back(declared(RigErrorKind::radius, rig.radius));
    sources.back().place = mount;
  }
  return sources;
}

MachineErrors<double> errors_at(const RigErrors& errors, const Mount& mount) {
  MachineErrors<double> at;
  for (std::size_t i = 0; i < errors.sources.size(); ++i)
    if (double* const element = element_of(at, errors.sources[i], mount)) *element = errors.values[i];
  return at;
}

std::string machine_step_name(const Step& step, std::size_t index) {
  return (step.recording.empty() ? "" : step.recording + ": ") + step_name(step, index);
}

void expect_possible(const RigDeclaration& rig, std::span<const Step> steps) {
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    const auto refuse = [&](const std::string& why) { throw Error(fmt::format("{}: {}", machine_step_name(step, k), why)); };
    if (step.kind == StepKind::rotate)
      refuse(
          fmt::format("a {} does not rotate step by step; expected {}", to_string(rig.kind), rig.kind == RigKind::chamber ? "hold" : "hold or spin"));
    if (step.kind == StepKind::hold) {
      if (step.angles[1] != 0 || step.angles[2] != 0)
        refuse("the machine has one axis, the outer; expected 0 for the angles of the middle and the inner axis");
      continue;
    }
    if (rig.kind == RigKind::chamber) refuse("a chamber does not turn; expected hold");
    if (!step.mount) refuse("no mount; expected the body axes that point up and outward");
    if (step.rate == 0) refuse("the rate is 0; expected another rate, or hold");
    for (const double radius : step.radius)
      if (rig.kind == RigKind::centrifuge && !(radius > 0)) refuse("no arm; expected a radius above 0 to each accelerometer of a centrifuge");
  }
}

MachinePlace<double> place_of(const Site& site) { return {site.gravity(), site.latitude ? earth_rate_enu(*site.latitude) : Vector3d::Zero()}; }

Motion steady_motion(const Step& step, const Site& site) {
  const SteadyMotion<double> m = steady_motion<double>(step, {}, place_of(site));
  return {.rate = m.rate, .force = m.force};
}

double horizontal_remainder(const Step& step) {
  if (step.kind != StepKind::spin) return 0;
  const double half = 0.5 * step.rate * (step.end - step.start);
  return (half == 0 ? 1 : std::abs(std::sin(half) / half)) / std::numbers::sqrt2;
}

Eigen::Matrix<double, 6, 6> spin_noise(const Step& step, double tilt, const MachinePlace<double>& place) {
  Eigen::Matrix<double, 6, 6> noise = Eigen::Matrix<double, 6, 6>::Zero();
  const double kept = horizontal_remainder(step);
  if (!(kept > 0)) return noise;
  const Vector3d up = mount_attitude(mount_of(step)).row(2);
  const Matrix3d vertical = up * up.transpose(), horizontal = Matrix3d::Identity() - vertical;
  const double earth = place.rate_ie_n.head<2>().norm(), radius = *std::max_element(step.radius.begin(), step.radius.end());
  const double tilted = kept * place.gravity * tilt * std::numbers::sqrt2, coriolis = kept * 2 * step.rate * radius * earth;
  noise.topLeftCorner<3, 3>() = tilted * tilted * horizontal + coriolis * coriolis * vertical;
  noise.bottomRightCorner<3, 3>() = kept * kept * earth * earth * horizontal;
  return noise;
}

namespace {

constexpr auto spun = static_cast<std::size_t>(RigAxis::outer);

/// The polynomial in u in (0, 1) with a value and rate at either end, and no acceleration there.
AnglePolynomial between(double angle_0, double rate_0, double angle_1, double rate_1) {
  const double way = angle_1 - angle_0;
  return {angle_0, rate_0, 0, 10 * way - 6 * rate_0 - 4 * rate_1, -15 * way + 8 * rate_0 + 7 * rate_1, 6 * way - 3 * rate_0 - 3 * rate_1};
}

/// The state of the machine at a time.
struct State {
  double time = 0, angle = 0, rate = 0;
};

/// The mount of the IMU in a step: C_tb, and the positions of its accelerometers.
MotionPiece mounted(const Step& step, const RigErrors& errors) {
  MotionPiece piece;
  const Mount mount = mount_of(step);
  const MachineErrors<double> error = errors_at(errors, mount);
  const Matrix3d C_mount = mount_attitude(mount);
  piece.C_tb = C_mount * rotation_exp(error.mount);
  const Vector3d outward_b = piece.C_tb.transpose() * Vector3d::UnitY();  // north at zero angle
  if (step.kind == StepKind::spin)
    for (int i = 0; i < 3; ++i) piece.arm.row(i) = (step.radius[static_cast<std::size_t>(i)] + error.radius) * outward_b;
  return piece;
}

double spin_rate(const Step& step, const RigErrors& errors) {
  return step.kind == StepKind::spin ? step.rate * (1 + errors_at(errors, mount_of(step)).rate) : 0;
}

/// The state at the end of the gap before a step: a spin's angle follows from half the change of the rate, a hold's is the nearest to that.
State reached(const State& from, const Step& step, double rate) {
  const double natural = from.angle + 0.5 * (from.rate + rate) * (step.start - from.time);
  const bool spins = step.kind == StepKind::spin;
  return {step.start, spins ? natural : step.angles[spun] + 2 * std::numbers::pi * std::round((natural - step.angles[spun]) / (2 * std::numbers::pi)),
          rate};
}

void expect_gap(const State& from, const State& to, bool mounted_anew, std::size_t index, const Step& step) {
  if (to.time < from.time - same_time || step.end <= step.start)
    throw Error(fmt::format("{}: wrong times; expected a start from {} s on and a later end", machine_step_name(step, index), stamp_text(from.time)));
  if (to.time - from.time >= same_time) return;
  const char* const what = mounted_anew ? "mount" : to.rate != from.rate ? "rate" : std::abs(to.angle - from.angle) >= same_angle ? "angle" : nullptr;
  if (what != nullptr)
    throw Error(fmt::format("{}: its {} differs from that of the previous step, without time to reach it; expected a start later than {} s",
                            machine_step_name(step, index), what, stamp_text(from.time)));
}

}  // namespace

RigMotion machine_motion(const RigDeclaration& rig, std::span<const Step> steps, const RigErrors& errors) {
  if (steps.empty()) throw Error("no steps; expected at least one");
  expect_possible(rig, steps);
  const Vector3d tilt{errors_at(errors, {}).tilt[0], errors_at(errors, {}).tilt[1], 0};
  RigMotion motion;
  motion.C_nt = rotation_exp(tilt);
  State now;
  const Step& first = steps.front();
  if (first.start < same_time) now = {0, first.kind == StepKind::hold ? first.angles[spun] : 0, spin_rate(first, errors)};
  motion.rate_before = now.rate;
  MotionPiece piece = mounted(first, errors);
  const auto append = [&](const State& to) {
    const double lasting = to.time - now.time;
    piece.begin = now.time, piece.end = to.time;
    piece.angle[spun] = between(now.angle, now.rate * lasting, to.angle, to.rate * lasting);
    if (now.rate == to.rate && to.angle == now.angle + to.rate * lasting) piece.angle[spun] = {now.angle, to.rate * lasting};
    if (lasting > 0) motion.pieces.push_back(piece);
    now = {to.time, std::remainder(to.angle, 2 * std::numbers::pi), to.rate};
  };
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const Step& step = steps[k];
    const State begin = reached(now, step, spin_rate(step, errors));
    expect_gap(now, begin, k > 0 && mount_of(step) != mount_of(steps[k - 1]), k, step);
    const MotionPiece own = mounted(step, errors);
    if (k > 0 && step.kind == StepKind::spin && mount_of(step) == mount_of(steps[k - 1])) piece.arm = own.arm;  // a hold has none
    piece.temperature = step.temperature;
    append(begin);
    piece = own;
    piece.temperature = step.temperature;
    append({step.end, now.angle + now.rate * (step.end - now.time), now.rate});
  }
  return motion;
}

RigMotion recorded_motion(const Session& session, const RecordingSource& source, const RigErrors& errors) {
  const RigDeclaration* const rig = session.rig_of(source);
  const std::vector<Step> steps = session.steps_of(source);
  return rig != nullptr && is_machine(rig->kind) ? machine_motion(*rig, steps, errors) : rig_motion(steps, errors);
}

}  // namespace imulab
