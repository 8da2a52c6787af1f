#include "imulab/recording/compensated_readings.hpp"

#include <algorithm>

namespace imulab {

void CompensatedReadings::take_part_with(std::size_t i) {
  constexpr std::size_t back = 8, most = 1024;
  begin_ = std::max(i, back) - back;
  const auto begin = static_cast<std::ptrdiff_t>(begin_), end = static_cast<std::ptrdiff_t>(std::min(begin_ + most, recording_.size()));
  Recording part;
  part.name = recording_.name, part.interval_s = recording_.interval_s;
  part.gyro_unit = recording_.gyro_unit, part.accel_unit = recording_.accel_unit;
  part.time_ns.assign(recording_.time_ns.begin() + begin, recording_.time_ns.begin() + end);
  for (const auto triad : {&Recording::gyro, &Recording::accel, &Recording::gyro_temperature, &Recording::accel_temperature})
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (const auto& column = (recording_.*triad)[axis]; !column.empty()) (part.*triad)[axis].assign(column.begin() + begin, column.begin() + end);
  part_ = compensate(model_, std::move(part)).recording;
}

}  // namespace imulab
