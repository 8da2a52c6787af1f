// Which of a recording's saturated samples have a gyro at its limit: their turn was not measured. In the others the accelerometers alone clip, as in
// the knocks of a unit that is put down.
#pragma once

#include "imulab/recording.hpp"

#include <cstddef>
#include <vector>

namespace imulab {

class GyroSaturation {
 public:
  /// A gyro at its limit reads more than in any sample that is not saturated. One pass over the gyros, where samples are saturated at all.
  explicit GyroSaturation(const Recording& recording);

  const std::vector<std::size_t>& samples() const { return samples_; }  ///< ascending
  std::size_t in(const Range& range) const;

 private:
  std::vector<std::size_t> samples_;
};

}  // namespace imulab
