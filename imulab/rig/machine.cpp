#include "imulab/rig/machine.hpp"

#include "imulab/core/error.hpp"
#include "imulab/earth/earth.hpp"

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

Place<double> place_of(const Site& site) { return {site.gravity(), site.latitude ? earth_rate_enu(*site.latitude) : Vector3d::Zero()}; }

Motion steady_motion(const Step& step, const Site& site) {
  const SteadyMotion<double> m = steady_motion<double>(step, {}, place_of(site));
  return {m.force, m.rate};
}

double horizontal_remainder(const Step& step) {
  if (step.kind != StepKind::spin) return 0;
  const double half = 0.5 * step.rate * (step.end - step.start);
  return (half == 0 ? 1 : std::abs(std::sin(half) / half)) / std::numbers::sqrt2;
}

Eigen::Matrix<double, 6, 6> spin_noise(const Step& step, double tilt, const Place<double>& place) {
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

}  // namespace imulab::rig
