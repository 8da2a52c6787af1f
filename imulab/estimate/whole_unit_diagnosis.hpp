// What is wrong with a whole-unit session although it could be calibrated: machines that are not as declared, a chamber that had not settled,
// hysteresis.
#pragma once

#include "imulab/estimate/whole_unit_course.hpp"

#include <string>
#include <vector>

namespace imulab {

// Each finding with its consequence, as a sentence.
/// The one error of a machine that explains most of what the points scatter too much, if there is one.
std::vector<std::string> wrong_machines(const WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts);
std::vector<std::string> wrong_chamber(const WholeUnitProblem& problem);

}  // namespace imulab
