// For tests of the turntable: Zhang's procedure (2010, section 2), an irregular one, and a table and a site for them.
#pragma once

#include "imulab/recording/turn.hpp"
#include "imulab/session.hpp"
#include "imulab/units.hpp"

#include <array>
#include <vector>

namespace imulab {

/// A hold from one time [s] to another at these angles [deg].
inline Step hold_between(double start, double end, double outer, double middle = 0, double inner = 0) {
  Step s;
  s.start = start, s.end = end, s.angles = {outer * unit::deg, middle * unit::deg, inner * unit::deg};
  return s;
}

/// A rotation from one time [s] to another; deg, deg/s.
inline Step rotation_between(double start, double end, RigAxis axis, double angle, double rate) {
  Step s;
  s.kind = StepKind::rotate, s.start = start, s.end = end, s.axis = axis, s.angle = angle * unit::deg, s.rate = rate * unit::deg;
  return s;
}

/// Places steps in time: rests, turns at 10 deg/s and 50 deg/s^2, and 10 s for reaching a hold.
class TableSteps {
 public:
  TableSteps& hold(double duration, std::array<double, 3> degrees) {
    Step step;
    std::array<double, 3> angles{};
    for (std::size_t a = 0; a < 3; ++a) angles[a] = degrees[a] * unit::deg;
    step.start = time_ + (angles == angles_ ? 0 : 10);
    step.end = step.start + duration;
    step.angles = angles_ = angles;
    return append(step);
  }
  TableSteps& turn(RigAxis axis, double degrees, double dps = 10) {
    Step step;
    step.kind = StepKind::rotate;
    step.axis = axis;
    step.angle = degrees * unit::deg;
    step.rate = dps * unit::deg;
    step.acceleration = 50 * unit::deg;
    step.start = time_;
    step.end = time_ + turn_duration(degrees, dps, 50);
    step.angles = angles_;
    angles_[static_cast<std::size_t>(axis)] += step.angle;
    return append(step);
  }
  const std::vector<Step>& steps() const { return steps_; }

 private:
  TableSteps& append(Step step) {
    step.recording = "recording.csv";
    time_ = step.end;
    steps_.push_back(step);
    return *this;
  }
  double time_ = 0;
  std::array<double, 3> angles_{};
  std::vector<Step> steps_;
};

/// Five turns forward and back about each axis with rests of 60 s, at zero angles; then six faces up with four headings each.
inline std::vector<Step> zhang_steps() {
  TableSteps steps;
  for (const RigAxis axis : {RigAxis::middle, RigAxis::outer, RigAxis::inner})
    steps.hold(60, {})
        .turn(axis, 1800)
        .hold(60, {axis == RigAxis::outer ? 1800.0 : 0, axis == RigAxis::middle ? 1800.0 : 0, axis == RigAxis::inner ? 1800.0 : 0})
        .turn(axis, -1800)
        .hold(60, {});
  // Inner and middle angle of x, y, z up and x, y, z down in Zhang's north-up-east axes.
  constexpr std::array<std::array<double, 2>, 6> faces{{{90, 0}, {0, 0}, {0, -90}, {-90, 0}, {0, 180}, {0, 90}}};
  for (const auto& [inner, middle] : faces)
    for (const double outer : {0.0, 90.0, 180.0, -90.0}) steps.hold(60, {outer, middle, inner});
  return steps.steps();
}

/// An irregular procedure: slanted attitudes, turns in different attitudes and through uneven angles, no turn reversed, one turn without a rest after
/// it.
inline std::vector<Step> odd_steps() {
  TableSteps steps;
  steps.hold(40, {10, 20, 30}).turn(RigAxis::inner, 1000).hold(30, {10, 20, 1030}).hold(50, {100, -70, 200}).turn(RigAxis::middle, -700, 25);
  steps.hold(20, {100, -770, 200}).turn(RigAxis::outer, 1234, 17).turn(RigAxis::inner, -500).hold(40, {1334, -770, -300}).hold(30, {0, 90, 0});
  steps.turn(RigAxis::inner, 720).hold(30, {0, 90, 720}).hold(30, {0, 0, 90}).hold(30, {0, 0, -90}).hold(30, {45, 180, 0}).hold(30, {45, -90, 45});
  steps.turn(RigAxis::outer, -900).hold(30, {-855, -90, 45});
  return steps.steps();
}

/// A table with this accuracy of angles, orthogonality and zero, and 10 ms.
inline RigDeclaration table_of(double sigma, double timing = 0.01) {
  RigDeclaration rig;
  rig.kind = RigKind::turntable;
  rig.angle.value = rig.orthogonality.value = rig.zero.value = sigma;
  rig.timing.value = timing;
  return rig;
}

inline Site table_site() {
  Site site;
  site.latitude = 28 * unit::deg;
  site.given_gravity = 9.79;
  return site;
}

}  // namespace imulab
