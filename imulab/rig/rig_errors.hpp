// The error sources of a turntable by name, in one flat list. Their effect on the attitude is in table_attitude.hpp, and over time in motion.hpp.
// Machines' errors are in the same list; their effect is in machine.hpp.
//
// - orthogonality: l_outer = (o1, o2, 1), l_middle = (m1, 1, m2), l_inner = (1, i1, i2) in n at zero angles, then normalized;
// - zero: a constant angle error of each axis (outer: north; middle and inner: the IMU's level at zero angles);
// - tilt: the whole table is tilted about east and about north;
// - angle: angle error of a stop. An axis has one from the start and draws a new one only when it is commanded to move;
// - timing: a commanded rotation lasts longer by this time, and ends at its angle.
//
// A table with fewer axes is one whose procedure does not use the others: an axis that stays at zero throughout has neither orthogonality nor angle
// errors (its zero error remains: the IMU's mounting).
#pragma once

#include "imulab/recording/session.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace imulab {

enum class RigErrorKind { orthogonality, zero, tilt, angle, timing, mount, rate, radius };

struct RigErrorSource {
  static constexpr std::size_t at_start = static_cast<std::size_t>(-1);

  RigErrorKind kind = RigErrorKind::zero;
  std::size_t axis = 0;         ///< by RigAxis; of a tilt: 0 about east, 1 about north; of a mount: the body axis it turns about
  std::size_t element = 0;      ///< of an orthogonality: 0 or 1, as in i1, i2
  std::size_t step = at_start;  ///< of an angle or timing error: the step (of its recording) that draws it, from 0
  Mount place{};                ///< of a mount or radius: which
  double known = 0;             ///< rad, s, m or relative: the declared value; the mean of the draws
  double sigma = 0;             ///< likewise: of its draw; 0 where it is known exactly

  /// "orthogonality.inner.1", "zero.outer", "tilt.east", "angle.middle.start", "angle.middle.12", "timing.3": steps count from 1; of machines "rate",
  /// "mount.+z+x.y", "radius.+z+x".
  std::string name() const;
  bool operator==(const RigErrorSource&) const = default;
};

/// Every error source of a recording's rig, as declared: of the table or machine first, then by step or mount. A hand (kind none)
/// has none.
std::vector<RigErrorSource> rig_error_sources(const Session& session, const RecordingSource& source);

/// Error sources and their values. Empty: a rig without errors.
struct RigErrors {
  std::vector<RigErrorSource> sources;
  std::vector<double> values;  ///< rad, s, m or relative
};

/// One draw. Recordings on one rig share its table errors; each has its own angle and timing errors.
RigErrors draw_rig_errors(const Session& session, const RecordingSource& source, std::uint64_t seed);

inline constexpr double same_time = 1e-9;   ///< s: rounding of a time in a file
inline constexpr double same_angle = 1e-9;  ///< rad: below what a decimal number of degrees in a file can mean

/// The commands of a step to the axes, by RigAxis [rad].
struct AxisCommand {
  std::array<double, 3> before{}, after{};
  std::array<bool, 3> moves{};  ///< in a hold: the angles differ by more than whole turns
};

/// The commands of these steps (of one recording). The rig begins at zero angles, or at those of a hold that begins at time 0.
std::vector<AxisCommand> commands_of(std::span<const Step> steps);

/// A source with its declared spread: a sigma, or a known value.
RigErrorSource declared(RigErrorKind kind, const Spread& spread);

/// Every error source of a turntable that does these steps.
std::vector<RigErrorSource> table_error_sources(const RigDeclaration& rig, std::span<const Step> steps);

/// The sources by their effect: indices into the sources, `none` where there is none.
struct RigErrorIndex {
  static constexpr int none = -1;
  std::array<std::array<int, 2>, 3> orthogonality{{{none, none}, {none, none}, {none, none}}};  ///< by RigAxis
  std::array<int, 3> zero{none, none, none};                                                    ///< by RigAxis
  std::array<int, 2> tilt{none, none};                                                          ///< about east, about north
  std::vector<std::array<int, 3>> angle_before, angle_after;  ///< by step: at the beginning of its motion, and from its end on
  std::vector<int> timing;                                    ///< by step
};
RigErrorIndex index_of(std::span<const RigErrorSource> sources, std::size_t steps);

// An error of a machine as a message names it.

struct ErrorInWords {
  std::string name;  ///< "rate", "mount +z+x, turned about y", "its axis, towards south", "radius of mount +z+x"
  double unit;       ///< in which it is stated, SI
  const char* unit_name;
  double largest;  ///< SI: beyond this its effect is not linear
};
/// A tilt, a rate, a mount or a radius in words.
ErrorInWords in_words(const RigErrorSource& source);

}  // namespace imulab
