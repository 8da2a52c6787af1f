#include "imulab/recording.hpp"

#include "imulab/error.hpp"
#include "imulab/recording/recording_view.hpp"

#include <algorithm>

namespace imulab {

std::size_t Recording::bytes() const {
  std::size_t numbers = time_ns.size();
  for (const Columns3* triad : {&gyro, &accel, &gyro_temperature, &accel_temperature})
    for (const auto& column : *triad) numbers += column.size();
  return 8 * numbers;
}

double Recording::interval(std::size_t i, bool increment) const {
  if (i >= size()) throw Error(name + ": sample " + std::to_string(i) + "; expected one of " + std::to_string(size()));
  if (increment || i == 0 || follows_gap(i)) return interval_s;
  return 1e-9 * static_cast<double>(time_ns[i] - time_ns[i - 1]);
}

bool Recording::follows_gap(std::size_t i) const { return std::binary_search(gaps.begin(), gaps.end(), i); }

Range Recording::samples_in(double begin_s, double end_s) const { return RecordingView(*this).samples_in(begin_s, end_s); }

std::size_t Recording::saturated_in(const Range& range) const { return RecordingView(*this).saturated_in(range); }

std::size_t Recording::gaps_in(const Range& range) const { return RecordingView(*this).gaps_in(range); }

}  // namespace imulab
