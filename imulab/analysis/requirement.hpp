// The inverse question: how coarse a table, how late its turns, how noisy a unit may be for a calibration to meet what is required of it.
#pragma once

#include "imulab/analysis/turntable_prediction.hpp"
#include "imulab/model/user_unit.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// "gyro.matrix.off_diagonal <= 5 arcsec": one sigma of each of these coefficients.
struct Requirement {
  std::string selector;
  std::vector<int> coefficients;  ///< table indices
  double limit;                   ///< SI
  UserUnit unit;
};

/// Requirements separated by commas. Throws Error naming what is no coefficient, no number, or a unit it cannot have.
std::vector<Requirement> parse_requirements(std::string_view text);

/// A requirement that is not met, by its worst coefficient.
struct Shortfall {
  Requirement requirement;
  int coefficient;
  double sigma;        ///< of it, SI
  std::string source;  ///< with the largest share of it
};
std::vector<Shortfall> shortfalls(const TurntablePlan& plan, const std::vector<Requirement>& requirements);

/// What can be made better or worse.
enum class Knob { table, timing, imu, all };
std::string_view to_string(Knob knob);

/// The plan with angle, orthogonality and zero, or the turns' timing, or the unit's noise times `factor`.
TurntablePlan scaled(TurntablePlan plan, Knob knob, double factor);

/// The coarsest that meets the requirements.
struct Tolerance {
  std::optional<double> factor;       ///< times what is declared; absent: not even a perfect one meets them
  bool unlimited = false;             ///< the factor is the largest that was tried: a table of 1 deg, turns late by 10 s, noise a million times the declared
  std::vector<Shortfall> shortfalls;  ///< where none meets them: with a perfect one
};

/// A knob's tolerance with the others as declared.
Tolerance tolerance(const TurntablePlan& plan, Knob knob, const std::vector<Requirement>& requirements);
/// A knob's tolerance with everything else perfect: the other knobs, g and latitude.
Tolerance tolerance_alone(const TurntablePlan& plan, Knob knob, const std::vector<Requirement>& requirements);

}  // namespace imulab
