// A recording as its samples arrive, and when the next estimate of it is due.
#pragma once

#include "imulab/recording.hpp"
#include "imulab/recording/readings.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>

namespace imulab {

/// Estimates take longer the longer the recording is: together ten times the last one.
class GrowingRecording {
 public:
  explicit GrowingRecording(double least_s) : least_s_(least_s) {}

  /// Takes new samples up to the moment at which an estimate is due; returns those that it did not take; none if there was no such moment.
  std::optional<Range> add(const Recording& piece, const Range& samples) {
    const double start_s = all_.size() > 0 ? all_.time_s(0) : piece.time_s(samples.begin);
    std::size_t end = samples.begin;
    while (end < samples.end && piece.time_s(end) - start_s < next_s_) ++end;
    const bool due = end < samples.end;
    if (due) ++end;
    append(all_, piece, {samples.begin, end});
    time_s_ = all_.time_s(all_.size() - 1) - start_s;
    if (!due) return std::nullopt;
    next_s_ = time_s_ + std::max(least_s_, 0.1 * time_s_);
    return Range{end, samples.end};
  }
  const Recording& samples() const { return all_; }
  double time_s() const { return time_s_; }  ///< since the first sample

 private:
  Recording all_;
  double least_s_, time_s_ = 0, next_s_ = 10;
};

}  // namespace imulab
