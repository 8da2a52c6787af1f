#include "imulab/rig/machine.hpp"

#include "imulab/core/error.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab::rig {

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
  for (std::size_t i = 0; i < errors.sources.size(); ++i) {
    const RigErrorSource& source = errors.sources[i];
    const auto axis = static_cast<Eigen::Index>(source.axis);
    const bool here = source.place == mount;
    if (source.kind == RigErrorKind::tilt) at.tilt[axis] = errors.values[i];
    if (source.kind == RigErrorKind::rate) at.rate = errors.values[i];
    if (source.kind == RigErrorKind::mount && here) at.mount[axis] = errors.values[i];
    if (source.kind == RigErrorKind::radius && here) at.radius = errors.values[i];
  }
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

double horizontal_remainder(const Step& step) {
  if (step.kind != StepKind::spin) return 0;
  const double half = 0.5 * step.rate * (step.end - step.start);
  return (half == 0 ? 1 : std::abs(std::sin(half) / half)) / std::numbers::sqrt2;
}

}  // namespace imulab::rig
