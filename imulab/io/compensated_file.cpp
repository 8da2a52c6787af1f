#include "imulab/io/compensated_file.hpp"

#include "imulab/io/decimal.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <string_view>

namespace imulab {

namespace {

constexpr std::array<std::string_view, 8> flag_names{"",         "saturated",          "out_of_range",          "saturated|out_of_range",
                                                     "replaced", "saturated|replaced", "out_of_range|replaced", "saturated|out_of_range|replaced"};

/// One mark a sample: the place of its name above.
std::vector<std::uint8_t> marks_of(const CompensatedRecording& c) {
  std::vector<std::uint8_t> marks(c.recording.size(), 0);
  for (const std::size_t i : c.recording.saturated) marks[i] |= 1;
  for (const std::size_t i : c.out_of_range) marks[i] |= 2;
  for (const std::size_t i : c.replaced) marks[i] |= 4;
  return marks;
}

}  // namespace

std::string compensated_header(bool flags) { return flags ? "t,gx,gy,gz,ax,ay,az,flags\n" : "t,gx,gy,gz,ax,ay,az\n"; }

std::string compensated_rows(const CompensatedRecording& c, bool flags) {
  constexpr std::size_t longest_number = 32;  // a shortest round-trip double has at most 24 characters
  const Recording& r = c.recording;
  const std::vector<std::uint8_t> marks = flags ? marks_of(c) : std::vector<std::uint8_t>{};
  const double gyro_factor = r.gyro_increment ? r.interval_s : 1, accel_factor = r.accel_increment ? r.interval_s : 1;
  std::string out;
  out.reserve(r.size() * 160);  // six numbers of 20 characters, a time, flags
  std::array<char, 9 * longest_number> line;
  for (std::size_t i = 0; i < r.size(); ++i) {
    char* end = write_seconds(line.data(), r.time_ns[i]);
    const auto append = [&](double value) {
      *end++ = ',';
      end = std::to_chars(end, line.data() + line.size(), value).ptr;
    };
    for (const auto& column : r.gyro) append(column[i] * gyro_factor);
    for (const auto& column : r.accel) append(column[i] * accel_factor);
    if (flags) {
      *end++ = ',';
      end = std::copy(flag_names[marks[i]].begin(), flag_names[marks[i]].end(), end);
    }
    *end++ = '\n';
    out.append(line.data(), end);
  }
  return out;
}

std::string compensated_text(const CompensatedRecording& c) {
  const bool flags = !(c.recording.saturated.empty() && c.out_of_range.empty() && c.replaced.empty());
  return compensated_header(flags) + compensated_rows(c, flags);
}

}  // namespace imulab
