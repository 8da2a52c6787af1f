// The conclusion of a verb: the beginning of its JSON, page and table.
#pragma once

#include "imulab/calibration.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Returns the reached value in the unit of the requirement's text: "1.3 nmi/h"; "not determined".
std::string reached_text(const RequirementResult& requirement);
/// Returns "CEP 1.3 nmi/h; required: CEP <= 1 nmi/h", with its note.
std::string requirement_text(const RequirementResult& requirement);

/// Returns a row of a list: "CEP <= 1 nmi/h: not met (CEP: 1.3 nmi/h; by the bound)".
std::string judged_text(const RequirementResult& requirement);

/// Returns the verdict on requirements: met, not met, or doubtful if the measurement is, which meets none; without requirements the measured verdict.
Verdict verdict_about(Verdict measured, const std::vector<RequirementResult>& requirements);

struct Conclusion {
  Verdict verdict = Verdict::none;
  std::string headline;                              ///< one sentence
  std::vector<RequirementResult> requirements = {};  ///< for results that do not store them
};

/// Concludes with verdict_about, and a headline on the first unmet requirement or the met one with the smallest margin. If the verdict does not
/// concern requirements, the headline is that of the measurement.
Conclusion conclude(Verdict measured, std::string headline, std::vector<RequirementResult> requirements);

/// Returns the first line of a terminal's text: "not met: CEP 1.3 nmi/h; required: CEP <= 1 nmi/h". Without a verdict, returns only the headline.
std::string conclusion_text(const Conclusion& conclusion);

/// Returns true for good and met, which are displayed in green.
bool is_favorable(Verdict verdict);

/// Returns the unmet requirements as the reason for the exit code 1; empty if all are met.
std::string missed_requirements(const Conclusion& conclusion);

}  // namespace imulab
