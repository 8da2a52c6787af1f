// The six figures that say how well an IMU is known, or will be.
#pragma once

#include "imulab/model/coefficient.hpp"
#include "imulab/report/page.hpp"

#include <functional>
#include <string>
#include <vector>

namespace imulab::report {

/// The worst standard uncertainty of scales, misalignments and offsets of each triad, where one is known. `sigma` gives a coefficient's [SI]; not
/// finite where it is not known.
std::vector<KeyFigure> key_figures(const std::function<double(CoefficientIndex)>& sigma);

/// What these figures are, as a paragraph; empty where there are none.
std::string worst_axis_note(const std::vector<KeyFigure>& figures);

}  // namespace imulab::report
