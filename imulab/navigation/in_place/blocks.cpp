#include "imulab/navigation/in_place/blocks.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab::in_place {

namespace {

std::size_t samples_of(const Recording& recording, double seconds) { return static_cast<std::size_t>(std::lround(seconds / recording.interval_s)); }

/// A bound on the difference of the rate at the end of sample i - 1 from the mean of its neighbors, from the change of slope about it.
double kink(const Recording& recording, std::size_t i) {
  double sum = 0;
  for (const std::vector<double>& rate : recording.gyro) {
    const double bend = rate[i + 1] - rate[i] - rate[i - 1] + rate[i - 2];
    sum += bend * bend;
  }
  return std::sqrt(sum);
}

double rate_size(const Recording& recording, std::size_t i) { return std::hypot(recording.gyro[0][i], recording.gyro[1][i], recording.gyro[2][i]); }

/// An accelerometer with a lever arm moves with the rate, so a velocity determines the lever arm as well as the rate at that instant is known. A
/// motion's block therefore ends where the rate is smoothest between half and three halves of its length. A steady turn without noise, as predictions
/// have it, is equally smooth everywhere but for rounding, which does not decide: there the length stays.
std::size_t smooth_end(const Recording& recording, std::size_t begin, std::size_t length, std::size_t end) {
  constexpr double rounding = 1e-12;  // of the rate: above that of any way to compute it, far below a gyro's noise
  const std::size_t first = begin + std::max<std::size_t>(2, (length + 1) / 2);
  std::size_t best = std::min(begin + length, end);
  double least = best >= first && best + 1 < end ? kink(recording, best) : std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i <= begin + 3 * length / 2 && i + 1 < end; ++i)
    if (const double bend = kink(recording, i); bend + rounding * rate_size(recording, i) < least) {
      least = bend;
      best = i;
    }
  return best;
}

}  // namespace

std::vector<Range> still_parts(const Recording& recording, std::vector<Range> rests) {
  const std::size_t margin = samples_of(recording, settling_time);
  for (Range& rest : rests)
    if (rest.size() > 5 * margin) rest = {rest.begin + margin, rest.end - margin};
  return rests;
}

Blocks cut_into_blocks(const Recording& recording, const std::vector<Range>& rests, bool observe_motion) {
  Blocks out;
  bool lost = false;
  const auto cut = [&](const Range& range, double seconds, bool at_rest) {
    const std::size_t length = std::max<std::size_t>(1, samples_of(recording, seconds));
    for (std::size_t begin = range.begin; begin < range.end;) {
      std::size_t end = at_rest ? std::min(begin + length, range.end) : smooth_end(recording, begin, length, range.end);
      if (range.end - end < length / 2) end = range.end;  // no short remainders
      out.blocks.push_back({{begin, end}, at_rest, at_rest || observe_motion, std::exchange(lost, false)});
      begin = end;
    }
  };
  for (std::size_t k = 0; k < rests.size(); ++k) {
    if (k > 0 && rests[k].begin > rests[k - 1].end) {
      const Range motion{rests[k - 1].end, rests[k].begin};
      const bool gap = recording.gaps_in({motion.begin, motion.end + 1}) > 0;
      lost = gap || recording.saturated_in(motion) > 0;
      if (lost)
        out.warnings.push_back(
            fmt::format("the motion from {:.2f} to {:.2f} s has {}; it is not used, and the attitude is aligned anew at the next rest",
                        recording.time_s(motion.begin), recording.time_s(motion.end), gap ? "a gap" : "saturated samples"));
      else
        cut(motion, 0.2, false);
    }
    cut(rests[k], 1, true);
  }
  return out;
}

}  // namespace imulab::in_place
