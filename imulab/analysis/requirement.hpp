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
/// Throws Error where a coefficient is not among those that the plan's calibration estimates.
void expect_estimated(const std::vector<Requirement>& requirements, const TurntablePlan& plan);

/// A requirement that is not met, by its worst coefficient.
struct Shortfall {
  Requirement requirement;
  int coefficient;
  double sigma;        ///< of it, SI; infinite: the procedure does not determine it
  std::string source;  ///< with the largest share of it
};
std::vector<Shortfall> shortfalls(const TurntablePlan& plan, const std::vector<Requirement>& requirements);

/// What can be made better or worse.
enum class Knob { table, timing, imu, all };
std::string_view to_string(Knob knob);

/// What the knobs turn: sigmas of the table, noise of the unit; SI. 0: none, or known exactly.
struct TableSetting {
  double angle = 0, orthogonality = 0, zero = 0, timing = 0;
  double gyro_noise = 0, accel_noise = 0, gyro_turn_on = 0, accel_turn_on = 0;
};
TableSetting setting_of(const TurntablePlan& plan);

/// The plan with the sigmas of angle, orthogonality and zero, or of the turns' timing, or the unit's noise times `factor`.
TurntablePlan scaled(TurntablePlan plan, Knob knob, double factor);

/// The coarsest that meets the requirements.
struct Tolerance {
  std::optional<double> factor;       ///< times what is declared (1 arcsec, 1 ms where nothing is); absent: not even a perfect one meets them
  bool unlimited = false;             ///< the factor is the largest that was tried (`largest_factor`)
  TableSetting setting;               ///< at this factor
  std::vector<Shortfall> shortfalls;  ///< where none meets them: with a perfect one
};

/// The factor that counts as perfect: a millionth of the table's errors or of the timing; a hundredth of the noise (weights need some) and of all.
double perfect(Knob knob);
/// The largest factor tried, at least 1: a table of 10 arcmin (beyond, the third order counts), turns late by 10 s or so much that five sigmas are a quarter of the shortest hold, noise a
/// million times the declared.
double largest_factor(const TurntablePlan& plan, Knob knob);

/// A knob's tolerance with the others as declared.
Tolerance tolerance(const TurntablePlan& plan, Knob knob, const std::vector<Requirement>& requirements);
/// A knob's tolerance with everything else perfect: the other knobs, g and latitude.
Tolerance tolerance_alone(const TurntablePlan& plan, Knob knob, const std::vector<Requirement>& requirements);

}  // namespace imulab
