// Calibrations that may be compared, and their comparison.
#pragma once

#include "imulab/results/compare_results.hpp"
#include "imulab/results/comparison.hpp"
#include "imulab/results/summary.hpp"
#include "imulab/tasks/verb.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct CompareOptions : ShowOptions {
  std::vector<std::string> files;
  std::optional<std::string> tolerance;
  bool different_imus = false;
};
/// The verb `compare`, which sets these.
Verb& declare(Verb& command, CompareOptions& o);

/// Compares the others with the first; an agreement of all where there are three or more that state uncertainties. `tolerance`: requirements on the
/// differences (parse_requirements). The warnings name frames that are not known, and doubtful calibrations. Throws Error for a singular matrix,
/// readings in different units, and serial numbers that differ unless `different_imus`; OptionError for a wrong tolerance.
AnswerOf<ComparisonSummary> comparison_answer(std::vector<NamedCalibration> calibrations, bool different_imus = false,
                                              const std::optional<std::string>& tolerance = {});

/// Results of one kind: budgets, noise, predictions or navigations, each with the name of its file. Throws Error for a mix, and for fewer than two.
AnswerOf<ResultComparison> result_comparison_answer(const std::vector<NamedResult>& results);

}  // namespace imulab
