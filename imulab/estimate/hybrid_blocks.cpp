#include "imulab/estimate/hybrid_blocks.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab {

namespace {

bool any_inside(const std::vector<std::size_t>& samples, const Range& range) {
  const auto found = std::lower_bound(samples.begin(), samples.end(), range.begin);
  return found != samples.end() && *found < range.end;
}

/// How far the rate at the end of sample i - 1 may be from the mean of its neighbours, from the change of slope about it.
double kink(const Recording& recording, std::size_t i) {
  double sum = 0;
  for (const std::vector<double>& rate : recording.gyro) {
    const double bend = rate[i + 1] - rate[i] - rate[i - 1] + rate[i - 2];
    sum += bend * bend;
  }
  return sum;
}

/// An accelerometer apart from the point that stays in its place moves with the rate: what a velocity says of its lever arm is as good as the rate at
/// that instant is known. So a motion's block ends where the rate is smoothest between half and three halves of its length.
std::size_t smooth_end(const Recording& recording, std::size_t begin, std::size_t length, std::size_t end) {
  std::size_t best = std::min(begin + length, end);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = begin + std::max<std::size_t>(2, (length + 1) / 2); i <= begin + 3 * length / 2 && i + 1 < end; ++i)
    if (const double bend = kink(recording, i); bend < least) {
      least = bend;
      best = i;
    }
  return best;
}

}  // namespace

HybridBlocks hybrid_blocks(const Recording& recording, const std::vector<Range>& rests, bool observe_motion) {
  HybridBlocks out;
  const auto samples_in = [&](double seconds) {
    return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(seconds / recording.interval_s)));
  };
  bool lost = false;
  const auto cut = [&](const Range& range, std::size_t length, bool at_rest) {
    for (std::size_t begin = range.begin; begin < range.end;) {
      std::size_t end = at_rest ? std::min(begin + length, range.end) : smooth_end(recording, begin, length, range.end);
      if (range.end - end < length / 2) end = range.end;  // no crumbs
      out.blocks.push_back({{begin, end}, at_rest, at_rest || observe_motion, std::exchange(lost, false)});
      begin = end;
    }
  };
  for (std::size_t k = 0; k < rests.size(); ++k) {
    if (k > 0 && rests[k].begin > rests[k - 1].end) {
      const Range motion{rests[k - 1].end, rests[k].begin};
      const bool gap = any_inside(recording.gaps, {motion.begin, motion.end + 1}), saturated = any_inside(recording.saturated, motion);
      if (gap || saturated) {
        lost = true;
        out.warnings.push_back(
            fmt::format("the motion from {:.2f} to {:.2f} s has {}: it is left out, and the attitude is found anew at the rest after it",
                        recording.time_s(motion.begin), recording.time_s(motion.end), gap ? "a gap" : "saturated samples"));
      } else {
        cut(motion, samples_in(0.2), false);
      }
    }
    cut(rests[k], samples_in(1), true);
  }
  return out;
}

}  // namespace imulab
