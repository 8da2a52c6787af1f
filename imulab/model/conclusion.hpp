// What a verb concludes about what was asked: the begin of its JSON, its page and its table.
#pragma once

#include "imulab/calibration.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// What was reached, in the unit of the requirement's text: "1.3 nmi/h"; "not determined".
std::string reached_text(const RequirementResult& requirement);
/// "CEP 1.3 nmi/h; required: CEP <= 1 nmi/h", with its note.
std::string requirement_text(const RequirementResult& requirement);

/// "CEP <= 1 nmi/h: not met (CEP: 1.3 nmi/h; by the bound)": a row of a list.
std::string judged_text(const RequirementResult& requirement);

/// The verdict about requirements by that of the measurement: met, not met, or doubtful, with which none is met; without requirements what it was.
Verdict verdict_about(Verdict measured, const std::vector<RequirementResult>& requirements);

struct Conclusion {
  Verdict verdict = Verdict::none;
  std::string headline;                              ///< one sentence
  std::vector<RequirementResult> requirements = {};  ///< of results that do not keep them themselves
};

/// About requirements: verdict_about, with a headline of the first that is not met, or of the one that is met with the least to spare. Where the
/// verdict is not about them, the headline of the measurement.
Conclusion conclude(Verdict measured, std::string headline, std::vector<RequirementResult> requirements);

/// "not met: CEP 1.3 nmi/h; required: CEP <= 1 nmi/h": the line with which a terminal's text begins. Without a verdict the headline alone.
std::string conclusion_text(const Conclusion& conclusion);

/// True of good and met: shown in green.
bool is_favorable(Verdict verdict);

/// Why the exit code is 1 by the conclusion: the requirements that are not met. Empty: none was missed.
std::string missed_requirements(const Conclusion& conclusion);

}  // namespace imulab
