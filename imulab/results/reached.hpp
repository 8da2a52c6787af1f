// How well an IMU is known, in a line a triad.
#pragma once

#include "imulab/model/calibration.hpp"

#include <functional>
#include <string>
#include <string_view>

namespace imulab {

/// The standard uncertainty by which people judge a calibration: of matrices relative to the row's scale; of readings in counts that of the output
/// where it is zero, since their offset is that of a reading far away. Not finite where the coefficient was not estimated.
double judged_uncertainty(const Calibration& calibration, CoefficientIndex index);

/// The worst standard uncertainty of a selector's coefficients in user units, "83 ppm"; empty where none is known. `sigma` gives a coefficient's; not
/// finite where it is not known.
std::string worst_text(std::string_view selector, const std::function<double(CoefficientIndex)>& sigma);

/// The worst of scales, misalignments and offsets, a line a triad; empty where none is known.
std::string reached_text(const std::function<double(CoefficientIndex)>& sigma);

}  // namespace imulab
