#include "imulab/recording/stuck_readings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace imulab {
namespace {

constexpr std::size_t samples_beside = 32;  // samples on each side
constexpr double most_chance = 1e-4;        // of a stretch as long anywhere in the column

std::size_t repeats_in(std::span<const double> readings, std::size_t begin, std::size_t end) {
  std::size_t count = 0;
  for (std::size_t i = std::max<std::size_t>(begin, 1); i < end; ++i) count += readings[i] == readings[i - 1];
  return count;
}

/// Those beside a stretch, without other stretches that are nearly as long: these may be stuck, too, and coarse readings also repeat in shorter ones.
std::size_t repeats_beside(std::span<const double> readings, std::size_t begin, std::size_t end, std::size_t length) {
  std::size_t count = 0;
  for (std::size_t i = begin; i < end;) {
    std::size_t next = i + 1;
    while (next < end && readings[next] == readings[i]) ++next;
    if (4 * (next - i) < 3 * length) count += next - i - 1;
    i = next;
  }
  return count;
}

/// The chance of so long a stretch, by how often the readings beside it repeat. A repeat more than there are: none among few is no proof of none.
double chance_of(std::span<const double> readings, const Range& stretch) {
  const std::size_t begin = stretch.begin - std::min(stretch.begin, samples_beside), end = std::min(readings.size(), stretch.end + samples_beside);
  const std::size_t repeats =
      repeats_beside(readings, begin, stretch.begin, stretch.size()) + repeats_beside(readings, stretch.end, end, stretch.size());
  const double pairs = static_cast<double>(stretch.begin - begin + end - stretch.end);
  const double share = std::min(1.0, static_cast<double>(repeats + 1) / std::max(pairs, 1.0));
  return static_cast<double>(readings.size()) * std::pow(share, static_cast<double>(stretch.size() - 1));
}

}  // namespace

std::vector<Range> stuck_stretches(std::span<const double> readings) {
  if (10 * repeats_in(readings, 1, readings.size()) > readings.size() || readings.empty()) return {};
  const auto [least, most] = std::minmax_element(readings.begin(), readings.end());
  std::vector<Range> out;
  for (Range stretch{0, 1}; stretch.begin < readings.size(); stretch = {stretch.end, stretch.end + 1}) {
    const double reading = readings[stretch.begin];
    while (stretch.end < readings.size() && readings[stretch.end] == reading) ++stretch.end;
    if (stretch.size() > 3 && reading != *least && reading != *most && chance_of(readings, stretch) < most_chance) out.push_back(stretch);
  }
  return out;
}

std::string said_of_stuck(const std::vector<Range>& stretches) {
  std::size_t longest = 0;
  for (const Range& stretch : stretches) longest = std::max(longest, stretch.size());
  const std::size_t n = stretches.size();
  return fmt::format("repeats one reading for up to {} samples, {} time{}, while those before and after change", longest, n, n == 1 ? "" : "s");
}

std::string said_of_stuck(const Recording& r) {
  std::string said;
  for (const auto& [name, triad] : {std::pair{"gyro", &r.gyro}, std::pair{"accel", &r.accel}})
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (const std::vector<Range> stretches = stuck_stretches((*triad)[axis]); !stretches.empty())
        said += fmt::format("{}{}.{} {}, the first at {:.2f} s", said.empty() ? "" : ", ", name, "xyz"[axis], said_of_stuck(stretches),
                            r.time_s(stretches.front().begin));
  return said.empty() ? said : fmt::format("{}: {}: the sensor or its driver hangs, and motion meanwhile is not measured", r.name, said);
}

}  // namespace imulab
