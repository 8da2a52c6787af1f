// The increments of a recording one by one, including those that bridge its gaps, without a copy.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/recording.hpp"

#include <cstddef>
#include <vector>

namespace imulab {

/// Element i is the i-th increment that for_each_increment gives for the whole recording, which must outlive the view. Safe on any thread.
class IncrementView {
 public:
  IncrementView() = default;
  explicit IncrementView(const Recording& recording);

  std::size_t size() const { return size_; }
  /// True if the angles are the recording's own, false if they are rates over the intervals of the stamps.
  bool angles_recorded() const { return recording_ != nullptr && recording_->gyro_increment; }
  TimedIncrement operator[](std::size_t i) const;

 private:
  struct Bridge {
    std::size_t first = 0, row = 0;  // element, and the row after the gap
    std::vector<TimedIncrement> steps;
  };
  const Recording* recording_ = nullptr;
  std::size_t size_ = 0;
  std::vector<Bridge> bridges_;
};

}  // namespace imulab
