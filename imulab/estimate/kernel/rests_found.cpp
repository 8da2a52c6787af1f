#include "imulab/estimate/kernel/rests_found.hpp"

#include "imulab/recording/lost_rests.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

namespace imulab::kernel {

std::vector<Range> rests_found(const CalibrationInput& input, const Recording& recording, Findings& findings) {
  if (input.rests) return *input.rests;
  LostRests lost;
  const Rests rests = imulab::rests_of(recording, input.session, lost);
  findings.notes.insert(findings.notes.begin(), rests.notes.begin(), rests.notes.end());
  const std::size_t rejected = lost.moving + lost.shifted, all = rests.ranges.size() + rejected;
  if (rejected == 0) return rests.ranges;
  std::vector<std::string> causes;
  if (lost.shifted > 0)
    causes.push_back(fmt::format("in {} of them the gyros read another rate than in the others (shaken, restarted, or another unit)", lost.shifted));
  if (lost.moving > 0) causes.push_back(fmt::format("in {} of them {}", lost.moving, lost.motion));
  const std::string what = fmt::format("{} of {} stretches that look like rests were rejected: {}", rejected, all, fmt::join(causes, ", "));
  findings.warn(what + "; nothing is taken from them; hold the IMU still, and record one unit without a pause");
  if (5 * rejected > all) findings.doubt(what);
  return rests.ranges;
}

}  // namespace imulab::kernel
