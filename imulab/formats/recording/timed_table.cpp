#include "imulab/formats/recording/timed_table.hpp"

#include <algorithm>
#include <iterator>

namespace imulab::recording_io {

std::size_t LineNumbers::operator[](std::size_t row) const {
  const auto after = std::upper_bound(jumps_.begin(), jumps_.end(), row, [](std::size_t r, const auto& jump) { return r < jump.first; });
  if (after == jumps_.begin()) return 0;
  return row + (std::prev(after)->second - std::prev(after)->first);
}

void LineNumbers::append(const LineNumbers& next, std::size_t row, std::size_t line) {
  for (const auto& [own_row, own_line] : next.jumps_) add(row + own_row, line + own_line);
}

std::string TimedTable::place(std::size_t index) const {
  const std::size_t line = lines[index];
  return line > 0 ? "line " + std::to_string(line) : row + " " + std::to_string(first + index + 1);
}

}  // namespace imulab::recording_io
