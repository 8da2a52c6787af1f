#include "imulab/estimate/kernel/rests_found.hpp"

#include "imulab/recording/lost_rests.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

namespace imulab::kernel {

std::vector<Range> rests_found(const CalibrationInput& input, const Recording& recording, Findings& findings, const RestOptions& options) {
  if (input.rests) return *input.rests;
  LostRests lost;
  const Rests rests = imulab::rests_of(recording, input.session, lost, options);
  Findings searched;
  for (const std::string& note : rests.notes) searched.add<Code::rests_searched>(note);
  findings.prepend(searched);
  const std::size_t rejected = lost.moving + lost.shifted, all = rests.ranges.size() + rejected;
  if (rejected == 0) return rests.ranges;
  std::vector<std::string> causes;
  if (lost.shifted > 0)
    causes.push_back(fmt::format("in {} of them the gyros read another rate than in the others (shaken, restarted, or another unit)", lost.shifted));
  if (lost.moving > 0) causes.push_back(fmt::format("in {} of them {}", lost.moving, lost.motion));
  Finding& lost_rests = findings.add<Code::rests_rejected>(rejected, all, fmt::format("{}", fmt::join(causes, ", ")));
  if (5 * rejected > all) lost_rests.severity = Severity::doubt;
  return rests.ranges;
}

}  // namespace imulab::kernel
