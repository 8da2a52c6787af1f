#include "imulab/recording/recording.hpp"

#include <algorithm>

namespace imulab {

double Recording::interval(std::size_t i, bool increment) const {
  if (increment || i == 0 || std::binary_search(gaps.begin(), gaps.end(), i)) return interval_s;
  return 1e-9 * static_cast<double>(time_ns[i] - time_ns[i - 1]);
}

}  // namespace imulab
