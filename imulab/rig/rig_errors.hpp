// How a turntable departs from its commands: every error source by name in one flat list. What the errors do to the attitude is in
// table_attitude.hpp, and over time in motion.hpp. Machines' errors are in the same list; what they do is in machine.hpp.
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

#include "imulab/recording/session.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace imulab {

/// The rig of one recording of a session: the one it names, or the only one; null where there is none.
const RigDeclaration* rig_of(const Session& session, const RecordingSource& source);

/// The steps of one recording of a session: those that name it, or all where it is the only one.
std::vector<Step> steps_of(const Session& session, const RecordingSource& source);

/// What a step tells the axes, by RigAxis [rad].
struct Command {
  std::array<double, 3> before{}, after{};
  std::array<bool, 3> moves{};  ///< in a hold: whole turns apart, the angles differ
};

/// The commands of these steps (of one recording). The rig begins at zero angles, or at those of a hold that begins at time 0.
std::vector<Command> commands_of(std::span<const Step> steps);

enum class RigErrorKind { orthogonality, zero, tilt, angle, timing, mount, rate, radius };

struct RigErrorSource {
  static constexpr std::size_t at_start = static_cast<std::size_t>(-1);

  RigErrorKind kind = RigErrorKind::zero;
  std::size_t axis = 0;         ///< by RigAxis; of a tilt: 0 about east, 1 about north; of a mount: the body axis it turns about
  std::size_t element = 0;      ///< of an orthogonality: 0 or 1, as in i1, i2
  std::size_t step = at_start;  ///< of an angle or timing error: the step (of its recording) that draws it, from 0
  Mount place{};                ///< of a mount or radius: which
  double known = 0;             ///< rad, s, m or relative: what is exactly declared; the middle of the draws
  double sigma = 0;             ///< likewise: of its draw; 0 where it is exactly known

  /// "orthogonality.inner.1", "zero.outer", "tilt.east", "angle.middle.start", "angle.middle.12", "timing.3": steps count from 1; of machines "rate",
  /// "mount.+z+x.y", "radius.+z+x".
  std::string name() const;
  bool operator==(const RigErrorSource&) const = default;
};

/// A source with what a spread declares: a sigma, or a known value.
RigErrorSource declared(RigErrorKind kind, const Spread& spread);

/// Every error source of a recording's rig, as its [rig] declares them: of the table or machine first, then by step or mount. A hand (kind none)
/// has none.
std::vector<RigErrorSource> rig_error_sources(const Session& session, const RecordingSource& source);
/// Of a turntable that does these steps.
std::vector<RigErrorSource> rig_error_sources(const RigDeclaration& rig, std::span<const Step> steps);

/// Error sources and their values. Empty: a rig without errors.
struct RigErrors {
  std::vector<RigErrorSource> sources;
  std::vector<double> values;  ///< rad, s, m or relative
};

/// One draw. Recordings on one rig share its table errors; each has its own angle and timing errors.
RigErrors draw_rig_errors(const Session& session, const RecordingSource& source, std::uint64_t seed);

/// Which source acts where: indices into the sources, `none` where there is none.
struct RigErrorIndex {
  static constexpr int none = -1;
  std::array<std::array<int, 2>, 3> orthogonality{{{none, none}, {none, none}, {none, none}}};  ///< by RigAxis
  std::array<int, 3> zero{none, none, none};                                                    ///< by RigAxis
  std::array<int, 2> tilt{none, none};                                                          ///< about east, about north
  std::vector<std::array<int, 3>> angle_before, angle_after;  ///< by step: in force when it begins to move, and from its end on
  std::vector<int> timing;                                    ///< by step
};
RigErrorIndex index_of(std::span<const RigErrorSource> sources, std::size_t steps);

}  // namespace imulab
