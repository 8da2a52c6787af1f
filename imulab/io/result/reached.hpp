// How well an IMU is known, in a line a triad.
#pragma once

#include "imulab/model/coefficient.hpp"

#include <functional>
#include <string>

namespace imulab {

/// The worst standard uncertainty of scales, misalignments and offsets, a line a triad. `sigma` gives a coefficient's, of matrices relative to the
/// row's scale; not finite where it is not known. Empty where none is.
std::string reached_text(const std::function<double(CoefficientIndex)>& sigma);

}  // namespace imulab
