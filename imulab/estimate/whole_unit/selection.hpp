// Selection of coefficients and points: determined coefficients, significant terms, outliers.
#pragma once

#include "imulab/estimate/whole_unit/problem.hpp"
#include "imulab/model/calibration.hpp"

#include <string>
#include <vector>

namespace imulab::whole_unit {

/// Estimated coefficients that the data do not determine become considered.
void consider_undetermined(Problem& problem);

/// Choice among optional terms (cubic, quadratic, second-order thermal, g-sensitivity, by triad): one is fixed at its starting value if it is not
/// significant and points left out (ten parts) are not predicted worse without it beyond chance.
std::vector<TermTest> choose_terms(Problem& problem, double significance);

/// Drops points one by one while chance explains them with less than `level` shared among all; returns their names. Where that is more than one in
/// fifty, the points are not outliers, and all stay.
std::vector<std::string> drop_bad_points(Problem& problem, double level);

}  // namespace imulab::whole_unit
