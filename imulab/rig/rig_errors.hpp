// The commands of steps to a table's axes, and its error sources by their effect. Their effect on the attitude is in table_attitude.hpp, and over
// time in motion.hpp; that of machines' errors in machine.hpp.
#pragma once

#include "imulab/session.hpp"
#include "imulab/simulate.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace imulab {

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

/// What is wrong with a source made in memory, for a recording of so many steps; empty: nothing.
std::string problem_of(const RigErrorSource& source, std::size_t steps);

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
