// Calibrations that may be compared, and their comparison.
#pragma once

#include "imulab/results/comparison.hpp"
#include "imulab/results/summary.hpp"
#include "imulab/tasks/verb.hpp"

#include <string>
#include <vector>

namespace imulab {

struct CompareOptions : ShowOptions {
  std::vector<std::string> files;
  bool different_imus = false;
};
/// The verb `compare`, which sets these.
Verb& declare(Verb& command, CompareOptions& o);

/// Compares the others with the first; an agreement of all where there are three or more that state uncertainties. The warnings name frames that are
/// not known. Throws Error for a singular matrix, readings in different units, and serial numbers that differ unless `different_imus`.
AnswerOf<ComparisonSummary> comparison_answer(std::vector<NamedCalibration> calibrations, bool different_imus = false);

}  // namespace imulab
