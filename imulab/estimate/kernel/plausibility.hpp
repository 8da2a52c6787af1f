// Is a calibration that of an IMU as it was declared? A wrong unit, axis or kind of output fits as well as the right one and shows in the result
// alone.
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

/// The unit that readings seem to be in where a triad's scale comes out as `scale` in the declared SI unit: "g", "mg", "m/s^2", "deg/s", "deg/h",
/// "rad/s"; empty where no known mistake explains it.
std::string_view mistaken_unit(Triad triad, double scale);

/// Why a triad's matrix is not that of a sensor in its declared unit, with the likely cause; empty where each scale is within 20 %.
std::string scale_contradiction(Triad triad, const Matrix3d& matrix, const Recording& recording);

/// A triad whose scales are not within 20 % of the declared unit, with the factor; empty where there is none, and of readings in counts.
std::string scale_far_from_unit(const SensorModel& model);

/// Are the axes of the gyros' coarse matrix far from right angles? Motion about too few axes, or gyros that do not turn with the accelerometers, give
/// any matrix; misalignments are below a few percent.
bool is_oblique(const Matrix3d& coarse);

/// Throws Error with the reason of scale_contradiction for the gyros' coarse matrix of SI readings, unless it is oblique.
void expect_gyro_scale(const Matrix3d& coarse, const Recording& recording);

/// Contradictions between model and declarations, each with its likely cause and the change that the session needs: a scale more than 20 % from its
/// declared unit, axes that are exchanged or reversed. Empty where all is as declared; for readings in counts only the order of the axes is judged.
Findings contradictions(const SensorModel& model, const Recording& recording);

/// Adds to a verdict where the stamps contradict the nominal interval: increments were divided by it, which is doubtful. Rates are integrated over
/// the stamps; of a rate that was `declared` a warning says what follows if these are wrong.
void judge_interval(const Recording& recording, bool declared, Quality& quality);

/// Which readings stand in the data twice, and what that does; empty where none do.
std::string repetition(std::span<const Recording> recordings);

/// Throws Error where two channels of a triad have the same reading in every sample.
void expect_different_channels(const Recording& recording);

}  // namespace imulab::kernel
