// How a turntable departs from its commands: every error source by name in one flat list, and the rig they make. The rig is a template of the
// sources' type, so that automatic differentiation gives the effect of each.
//
// - orthogonality: l_outer = (o1, o2, 1), l_middle = (m1, 1, m2), l_inner = (1, i1, i2) in n at zero angles, then normalised;
// - zero: a constant angle error of each axis (outer: north; middle and inner: the unit's level at zero angles);
// - tilt: the whole table leans, about east and about north;
// - angle: error of a stop. An axis has one from the start and draws a new one only when it is commanded to move;
// - timing: a commanded rotation lasts that much longer, and ends at its angle.
//
// A table with fewer axes is one whose procedure leaves the others alone: an axis that stands at zero throughout has neither orthogonality nor angle
// errors (its zero error remains: the unit's mounting).
#pragma once

#include "imulab/core/rotation.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/turntable.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace imulab {

/// The steps of one recording of a session: those that name it, or all where it is the only one. Throws Error for a rig that does not move
/// by axis angles (turntable and none do).
std::vector<Step> steps_of(const Session& session, const RecordingSource& source);

/// What a step tells the axes, by RigAxis [rad].
struct Command {
  std::array<double, 3> before{}, after{};
  std::array<bool, 3> moves{};  ///< in a hold: whole turns apart, the angles differ
};

/// The commands of these steps (of one recording). The rig begins at zero angles, or at those of a hold that begins at time 0.
std::vector<Command> commands_of(std::span<const Step> steps);

enum class RigErrorKind { orthogonality, zero, tilt, angle, timing };

struct RigErrorSource {
  static constexpr std::size_t at_start = static_cast<std::size_t>(-1);

  RigErrorKind kind = RigErrorKind::zero;
  std::size_t axis = 0;         ///< by RigAxis; of a tilt: 0 about east, 1 about north
  std::size_t element = 0;      ///< of an orthogonality: 0 or 1, as in i1, i2
  std::size_t step = at_start;  ///< of an angle or timing error: the step (of its recording) that draws it, from 0
  double known = 0;             ///< rad or s: what is exactly declared; the middle of the draws
  double sigma = 0;             ///< rad or s: of its draw; 0 where it is exactly known

  /// "orthogonality.inner.1", "zero.outer", "tilt.east", "angle.middle.start", "angle.middle.12", "timing.3": steps count from 1.
  std::string name() const;
  bool operator==(const RigErrorSource&) const = default;
};

/// Every error source of a recording's rig, as its [rig] declares them: of the table first, then by step. A hand (kind none) has none.
std::vector<RigErrorSource> rig_error_sources(const Session& session, const RecordingSource& source);

/// Error sources and their values. Empty: a rig without errors.
struct RigErrors {
  std::vector<RigErrorSource> sources;
  std::vector<double> values;  ///< rad or s
};

/// One draw. Recordings on one rig share its table errors; each has its own angle and timing errors.
RigErrors draw_rig_errors(const Session& session, const RecordingSource& source, std::uint64_t seed);

/// The rig as its errors make it.
template <class T>
struct ActualRig {
  std::array<Eigen::Matrix<T, 3, 1>, 3> axes;  ///< by RigAxis, unit vectors in the table's frame at zero angles
  Eigen::Matrix<T, 3, 3> C_nt;                 ///< how the table stands against n
  std::array<T, 3> start;                      ///< rad: actual less commanded angle, zero error included, at the start
  std::vector<std::array<T, 3>> angle;         ///< and from the end of each step's motion on
  std::vector<T> delay;                        ///< s: by how much each step's rotation takes longer
};

template <class T>
ActualRig<T> actual_rig(std::span<const RigErrorSource> sources, std::span<const T> values, std::size_t steps) {
  constexpr std::size_t component[3][2]{{0, 1}, {0, 2}, {1, 2}};
  ActualRig<T> rig;
  for (std::size_t a = 0; a < 3; ++a) rig.axes[a] = ideal_axes()[a].template cast<T>();
  std::array<T, 3> now{T(0), T(0), T(0)}, zero = now;
  std::array<T, 2> tilt{T(0), T(0)};
  rig.delay.assign(steps, T(0));
  rig.start = now;
  rig.angle.assign(steps, now);
  std::array<std::size_t, 3> filled{};  // steps whose error of this axis is set
  const auto fill = [&](std::size_t axis, std::size_t end) {
    for (; filled[axis] < end; ++filled[axis]) rig.angle[filled[axis]][axis] = now[axis];
  };
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const RigErrorSource& source = sources[i];
    const T& value = values[i];
    switch (source.kind) {
      case RigErrorKind::orthogonality:
        rig.axes[source.axis](component[source.axis][source.element]) = value;
        break;
      case RigErrorKind::zero:
        zero[source.axis] = value;
        break;
      case RigErrorKind::tilt:
        tilt[source.axis] = value;
        break;
      case RigErrorKind::timing:
        rig.delay[source.step] = value;
        break;
      case RigErrorKind::angle:
        if (source.step == RigErrorSource::at_start) {
          rig.start[source.axis] = value;
        } else {
          fill(source.axis, source.step);
        }
        now[source.axis] = value;
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    fill(a, steps);
    rig.axes[a] /= rig.axes[a].norm();
    rig.start[a] += zero[a];
    for (auto& angle : rig.angle) angle[a] += zero[a];
  }
  const Eigen::Matrix<T, 3, 1> east = Vector3d::UnitX().cast<T>(), north = Vector3d::UnitY().cast<T>();
  rig.C_nt = rotation_about<T>(north, tilt[1]) * rotation_about<T>(east, tilt[0]);
  return rig;
}

/// Actual angles before step k moves anything, and after.
template <class T>
std::array<T, 3> angles_before(const ActualRig<T>& rig, const Command& command, std::size_t k) {
  const std::array<T, 3>& error = k == 0 ? rig.start : rig.angle[k - 1];
  return {error[0] + command.before[0], error[1] + command.before[1], error[2] + command.before[2]};
}
template <class T>
std::array<T, 3> angles_after(const ActualRig<T>& rig, const Command& command, std::size_t k) {
  const std::array<T, 3>& error = rig.angle[k];
  return {error[0] + command.after[0], error[1] + command.after[1], error[2] + command.after[2]};
}

/// C_nb of hold k; after a rotation, where it ended.
template <class T>
Eigen::Matrix<T, 3, 3> hold_attitude(const ActualRig<T>& rig, const Command& command, std::size_t k) {
  return rig.C_nt * turntable_attitude<T>(rig.axes, angles_after(rig, command, k));
}

/// A rotation as the body has it: C_nb R(axis_b, angle so far) while it lasts.
template <class T>
struct Turn {
  Eigen::Matrix<T, 3, 3> C_nb;    ///< where it begins
  Eigen::Matrix<T, 3, 1> axis_b;  ///< constant in b: the axes inside it stand still
  T angle;                        ///< rad, signed: commanded, and end error less start error
  T delay;                        ///< s: longer than commanded
};

template <class T>
Turn<T> turn_of(const ActualRig<T>& rig, const Command& command, RigAxis axis, std::size_t k) {
  const auto moving = static_cast<std::size_t>(axis);
  const std::array<T, 3> before = angles_before(rig, command, k), after = angles_after(rig, command, k);
  Eigen::Matrix<T, 3, 1> axis_b = rig.axes[moving];
  for (std::size_t inside = moving + 1; inside < 3; ++inside) {
    const Eigen::Matrix<T, 3, 3> back = rotation_about<T>(rig.axes[inside], -before[inside]);
    axis_b = (back * axis_b).eval();
  }
  return {rig.C_nt * turntable_attitude<T>(rig.axes, before), axis_b, after[moving] - before[moving], rig.delay[k]};
}

}  // namespace imulab
