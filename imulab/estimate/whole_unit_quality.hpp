// What a whole-unit calibration says of itself: residuals, what stayed open and why, what was dropped, what was found of the machines.
#pragma once

#include "imulab/estimate/whole_unit_course.hpp"
#include "imulab/model/calibration.hpp"

#include <string>
#include <vector>

namespace imulab {

/// What became of a session: the problem where the fit stands, and how it came there.
struct WholeUnitOutcome {
  std::vector<Part> parts;
  Solution solution;   ///< chi2 against the noise as measured
  double scatter = 1;  ///< by which the uncertainties are enlarged
  std::vector<TermTest> tests;
  std::vector<std::string> dropped, wrong_machines, warnings;
};

Quality whole_unit_quality(const WholeUnitProblem& problem, const WholeUnitOutcome& outcome);

}  // namespace imulab
