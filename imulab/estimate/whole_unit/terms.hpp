// The optional terms of a whole-unit calibration, by triad: cubic, quadratic, second-order thermal, and the gyros' g-sensitivity.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"

#include <vector>

namespace imulab::whole_unit {

/// Tests the optional terms for significance. Without effects, insignificant ones are left out; with effects, which may hide a term, all stay.
std::vector<TermTest> choose_terms(PointProblem& problem, double significance);

}  // namespace imulab::whole_unit
