#include "imulab/io/compensated_file.hpp"

#include "imulab/io/decimal.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>

namespace imulab {

namespace {

constexpr std::uint8_t saturated = 1, out_of_range = 2;
constexpr std::array<const char*, 4> flag_names{"", "saturated", "out_of_range", "saturated|out_of_range"};

/// One mark a sample; empty where no sample has one.
std::vector<std::uint8_t> marks_of(const CompensatedRecording& c) {
  if (c.recording.saturated.empty() && c.out_of_range.empty()) return {};
  std::vector<std::uint8_t> marks(c.recording.size(), 0);
  for (const std::size_t i : c.recording.saturated) marks[i] |= saturated;
  for (const std::size_t i : c.out_of_range) marks[i] |= out_of_range;
  return marks;
}

}  // namespace

std::string compensated_text(const CompensatedRecording& c) {
  constexpr std::size_t longest_number = 32;  // a shortest round-trip double has at most 24 characters
  const Recording& r = c.recording;
  const std::vector<std::uint8_t> marks = marks_of(c);
  const double gyro_factor = r.gyro_increment ? r.interval_s : 1, accel_factor = r.accel_increment ? r.interval_s : 1;
  std::string out = marks.empty() ? "t,gx,gy,gz,ax,ay,az\n" : "t,gx,gy,gz,ax,ay,az,flags\n";
  std::array<char, 8 * longest_number> line;
  for (std::size_t i = 0; i < r.size(); ++i) {
    char* end = write_seconds(line.data(), r.time_ns[i]);
    const auto append = [&](double value) {
      *end++ = ',';
      end = std::to_chars(end, line.data() + line.size(), value).ptr;
    };
    for (const auto& column : r.gyro) append(column[i] * gyro_factor);
    for (const auto& column : r.accel) append(column[i] * accel_factor);
    out.append(line.data(), end);
    if (!marks.empty()) out.append(",").append(flag_names[marks[i]]);
    out += '\n';
  }
  return out;
}

}  // namespace imulab
