// The increments of a recording one by one, with those that bridge its gaps, without a copy of them.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/recording.hpp"

#include <cstddef>
#include <vector>

namespace imulab {

/// Element i is what for_each_increment gives as the i-th of the whole recording, which has to outlive the view. Safe on any thread.
class IncrementView {
 public:
  IncrementView() = default;
  explicit IncrementView(const Recording& recording);

  std::size_t size() const { return size_; }
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
