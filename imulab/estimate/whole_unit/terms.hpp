// The optional terms of a whole-unit calibration, by triad: cubic, quadratic, second-order thermal, and the gyros' g-sensitivity.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"

#include <vector>

namespace imulab::whole_unit {

/// Which optional terms are seen. Without effects, those that are not are left out; an effect may hide one that is there, so that with effects all
/// stay.
std::vector<TermTest> choose_terms(PointProblem& problem, double significance);

}  // namespace imulab::whole_unit
