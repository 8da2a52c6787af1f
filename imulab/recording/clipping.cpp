#include "imulab/recording/clipping.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace imulab {

namespace {

struct Level {
  double value;
  std::size_t count;
};

/// Calls a function with one block of a channel after the other.
using Channel = std::function<void(const std::function<void(std::span<const double>)>&)>;

/// The four outermost distinct values at each end, from the extreme inward, with their counts; fewer where there are no more.
class OuterLevels {
 public:
  void add(std::span<const double> readings) {
    for (const double reading : readings) {
      add(high_, reading);
      add(low_, -reading);
    }
  }
  /// The values times `sign`.
  std::vector<Level> at(int sign) const {
    std::vector<Level> found;
    for (const Level& level : sign > 0 ? high_ : low_)
      if (level.count > 0) found.push_back(level);
    return found;
  }

 private:
  using Levels = std::array<Level, 4>;
  static void add(Levels& levels, double value) {
    if (value < levels.back().value) return;
    std::size_t k = 0;
    while (k < levels.size() && value < levels[k].value) ++k;
    if (k < levels.size() && value == levels[k].value) {
      ++levels[k].count;
    } else if (k < levels.size()) {
      std::move_backward(levels.begin() + static_cast<std::ptrdiff_t>(k), levels.end() - 1, levels.end());
      levels[k] = {value, 1};
    }
  }
  static constexpr Level none{-HUGE_VAL, 0};
  Levels high_{none, none, none, none}, low_ = high_;
};

/// Longest run of samples at this value, and of samples between both extremes; of the latter, those that repeat the one before.
struct Runs {
  std::size_t at = 0, elsewhere = 0;
  std::size_t between = 0, repeating = 0;
  std::size_t samples = 0, changes = 0;
  double step = HUGE_VAL;     ///< the least change
  std::vector<double> jumps;  ///< to this value, and from it

  /// A sensor without noise, or with steps far above it: it repeats itself wherever the motion does, not only at a limit.
  bool repeat_everywhere() const { return 2 * repeating > between; }
  /// At a limit a reading is cut off while it changes. One that rests there came to rest: by the sensor's steps, where these are far above its noise.
  bool came_to_rest() const {
    constexpr double nearly_all = 0.8;
    const auto single = std::count_if(jumps.begin(), jumps.end(), [&](double jump) { return jump < 1.5 * step; });
    return 2 * changes < samples && static_cast<double>(single) >= nearly_all * static_cast<double>(jumps.size());
  }
};

Runs longest_runs(const Channel& channel, double value, double least, double most) {
  Runs runs;
  double last = 0;
  std::size_t length = 0;
  const auto end_run = [&] {
    if (length > 0 && last == value) runs.at = std::max(runs.at, length);
    if (length == 0 || !(last > least && last < most)) return;
    runs.elsewhere = std::max(runs.elsewhere, length);
    runs.between += length, runs.repeating += length - 1;
  };
  channel([&](std::span<const double> readings) {
    runs.samples += readings.size();
    for (const double reading : readings) {
      if (length > 0 && reading == last) {
        ++length;
        continue;
      }
      end_run();
      if (length > 0) {
        const double jump = std::abs(reading - last);
        ++runs.changes, runs.step = std::min(runs.step, jump);
        if (last == value || reading == value) runs.jumps.push_back(jump);
      }
      last = reading, length = 1;
    }
  });
  end_run();
  return runs;
}

bool clips(const Channel& channel, const OuterLevels& outer, int sign) {
  const std::vector<Level> levels = outer.at(sign);
  if (levels.size() < 4 || levels[0].count < 3) return false;  // a constant channel is stuck, not clipped
  const std::size_t beside = std::max({levels[1].count, levels[2].count, levels[3].count});
  if (levels[0].count < 3 * beside) return false;
  const Runs runs = longest_runs(channel, sign * levels[0].value, -outer.at(-1)[0].value, outer.at(1)[0].value);
  if (runs.came_to_rest()) return false;
  return runs.elsewhere == 1 || runs.at >= (runs.repeat_everywhere() ? 10 : 3) * runs.elsewhere;
}

void for_each_clipped(const Channel& channel, const std::function<void(std::size_t)>& each) {
  OuterLevels outer;
  channel([&](std::span<const double> readings) { outer.add(readings); });
  const bool high = clips(channel, outer, 1), low = clips(channel, outer, -1);
  if (!high && !low) return;
  const double most = high ? outer.at(1)[0].value : HUGE_VAL, least = low ? -outer.at(-1)[0].value : -HUGE_VAL;
  std::size_t i = 0;
  channel([&](std::span<const double> readings) {
    for (const double reading : readings) {
      if (reading == most || reading == least) each(i);
      ++i;
    }
  });
}

}  // namespace

std::vector<std::size_t> clipped_samples(const std::vector<double>& channel) {
  std::vector<std::size_t> samples;
  for_each_clipped([&](const auto& each) { each(channel); }, [&](std::size_t i) { samples.push_back(i); });
  return samples;
}

void for_each_clipped(const RecordingView& recording, std::size_t column, const Range& range, const std::function<void(std::size_t)>& each) {
  for_each_clipped([&](const auto& of) { for_each_block(recording, column, range, usual_block, of); }, each);
}

}  // namespace imulab
