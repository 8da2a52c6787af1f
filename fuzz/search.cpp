// Any header over columns of one motion, in any order: what the search for sensors takes for them is them.
#include "imulab/error.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include "fuzz/targets.hpp"
#include "tests/simulated_session.hpp"
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace imulab::fuzz {

namespace {

const Recording& searched_motion() {
  static const Recording cached = [] {
    HandHeldOptions options;
    options.poses = 10, options.first_rest = 4, options.rest = 2, options.move = 1, options.rate_hz = 50;
    return simulate_session(options, 62).recording;
  }();
  return cached;
}

/// 0 time, 1 to 3 force, 4 to 6 rate, 7 the direction of gravity's x, 8 a constant, 9 a number of the row.
double value_of(char kind, std::size_t i, double scale) {
  const Recording& r = searched_motion();
  const auto axis = static_cast<std::size_t>((kind - '1') % 3);
  const Vector3d force(r.accel[0][i], r.accel[1][i], r.accel[2][i]);
  if (kind == '0') return 1e-9 * static_cast<double>(r.time_ns[i] - r.time_ns[0]);
  if (kind >= '1' && kind <= '3') return scale * r.accel[axis][i];
  if (kind >= '4' && kind <= '6') return scale * r.gyro[axis][i];
  return kind == '7' ? force.normalized().x() : kind == '8' ? scale : static_cast<double>(i);
}

/// The kinds of three columns.
std::set<char> kinds_of(const SignalTable& table, const inspection::SignalTriad& triad, const std::string& kinds) {
  std::set<char> found;
  for (const std::size_t i : triad)
    if (i < table.signals.size()) found.insert(kinds[i]);
  return found;
}

}  // namespace

/// The first line is the header, between commas; a digit of the second tells what a column holds, a letter before it the scale of those that follow.
void search(std::string_view bytes) {
  constexpr std::size_t most_columns = 12;
  const std::size_t end = std::min(bytes.find('\n'), bytes.size());
  std::string_view head = bytes.substr(0, end), how = bytes.substr(std::min(end + 1, bytes.size()));
  SignalTable table;
  table.file = "fuzzed";
  std::string kinds;
  double scale = 1;
  for (const char c : how) {
    if (c >= 'a' && c <= 'd') scale = c == 'a' ? 1 : c == 'b' ? 1 / unit::g : c == 'c' ? 1 / unit::deg : 1000;
    if (c < '0' || c > '9' || kinds.size() == most_columns) continue;
    const std::size_t comma = std::min(head.find(','), head.size());
    Signal signal;
    signal.name = head.substr(0, comma), head.remove_prefix(std::min(comma + 1, head.size()));
    signal.column = static_cast<int>(kinds.size()) + 1;
    for (std::size_t i = 0; i < searched_motion().size(); ++i) signal.values.push_back(value_of(c, i, scale));
    table.signals.push_back(std::move(signal));
    kinds.push_back(c);
  }
  if (kinds.empty()) return;
  try {
    const Inspection found = inspect(table);
    if (!found.complete() || !found.triads || !found.triads->explained()) return;
    if (kinds_of(table, found.triads->accel, kinds) != std::set{'1', '2', '3'})
      finding("other columns than the accelerometers' are understood as them");
    if (kinds_of(table, found.triads->gyro, kinds) != std::set{'4', '5', '6'}) finding("other columns than the gyros' are understood as them");
  } catch (const Error&) {
  }
}

}  // namespace imulab::fuzz
