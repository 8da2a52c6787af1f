// Checks whether a calibration agrees with the declarations. Only the result reveals a wrong unit, axis or kind of output, which fits equally well.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/recording.hpp"
#include "imulab/sensor_model.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::kernel {

/// Returns the unit that explains `scale` of a triad in the declared SI unit: "g", "mg", "m/s^2", "deg/s", "deg/h" or "rad/s"; empty if no known
/// mistake explains it.
std::string_view mistaken_unit(Triad triad, double scale);

/// Explains why a triad's matrix is implausible in its declared unit, with the likely cause; empty if each scale is within 20 %.
std::string scale_contradiction(Triad triad, const Matrix3d& matrix, const Recording& recording);

/// Names a triad whose scales are not within 20 % of the declared unit, with the factor; empty if there is none, or for readings in counts.
std::string scale_far_from_unit(const SensorModel& model);

/// Returns true if the axes of the gyros' coarse matrix are far from orthogonal. Motion about too few axes, or gyros that do not move with the
/// accelerometers, give an arbitrary matrix, whereas real misalignments are below a few percent.
bool is_oblique(const Matrix3d& coarse);

/// Throws Error with the reason of scale_contradiction for the gyros' coarse matrix of SI readings, unless the matrix is oblique.
void expect_gyro_scale(const Matrix3d& coarse, const Recording& recording);

/// Returns contradictions between model and declarations, with the likely cause and the required change of the session: scales more than 20 % from
/// the declared unit, or exchanged or reversed axes. For readings in counts, only the order of the axes is checked.
Findings contradictions(const SensorModel& model, const Recording& recording);

/// Adds a finding if the stamps contradict the nominal interval. For increments, which were divided by it, this is a doubt. Rates are integrated with
/// the stamps: for a `declared` rate, a warning states the consequence of wrong stamps.
void judge_interval(const Recording& recording, bool declared, Quality& quality);

/// Describes readings that occur twice in the data, and the consequence; empty if there are none.
std::string repetition(std::span<const Recording> recordings);

/// Throws Error if two channels of a triad have identical readings in all samples.
void expect_different_channels(const Recording& recording);

}  // namespace imulab::kernel
