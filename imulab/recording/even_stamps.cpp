#include "imulab/recording/even_stamps.hpp"

#include "imulab/core/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace imulab {

namespace {

struct Early {
  double index, late_ns;
};

/// The earliest stamp of each block, less the even clock of the whole.
std::vector<Early> earliest(std::span<const std::int64_t> time_ns, std::size_t block, double interval_ns) {
  std::vector<Early> out;
  for (std::size_t begin = 0; begin + block <= time_ns.size(); begin += block) {
    Early best{0, HUGE_VAL};
    for (std::size_t i = begin; i < begin + block; ++i) {
      const double late = static_cast<double>(time_ns[i] - time_ns[0]) - interval_ns * static_cast<double>(i);
      if (late < best.late_ns) best = {static_cast<double>(i), late};
    }
    out.push_back(best);
  }
  return out;
}

/// Straight line by least squares: late = a + b index.
std::array<double, 2> line_through(const std::vector<Early>& points) {
  double n = static_cast<double>(points.size()), mean_i = 0, mean_l = 0, si = 0, sl = 0;
  for (const Early& p : points) mean_i += p.index / n, mean_l += p.late_ns / n;
  for (const Early& p : points) si += (p.index - mean_i) * (p.index - mean_i), sl += (p.index - mean_i) * (p.late_ns - mean_l);
  const double slope = si > 0 ? sl / si : 0;
  return {mean_l - slope * mean_i, slope};
}

}  // namespace

std::int64_t EvenClock::stamp_ns(std::size_t i) const { return std::llround(first_ns + 1e9 * interval_s * static_cast<double>(i)); }

std::optional<EvenClock> even_clock(std::span<const std::int64_t> time_ns) {
  constexpr std::size_t fewest = 200, block = 50;
  if (time_ns.size() < fewest) return std::nullopt;
  const double mean_ns = static_cast<double>(time_ns.back() - time_ns.front()) / static_cast<double>(time_ns.size() - 1);
  const std::vector<Early> early = earliest(time_ns, block, mean_ns);
  const auto [late, slope] = line_through(early);
  const double interval_ns = mean_ns + slope;
  for (const Early& p : early)
    if (!(std::abs(p.late_ns - late - slope * p.index) < 0.25 * interval_ns)) return std::nullopt;
  EvenClock clock{static_cast<double>(time_ns[0]) + late, 1e-9 * interval_ns, 0};
  double square = 0;
  for (std::size_t i = 0; i < time_ns.size(); ++i) square += std::pow(static_cast<double>(time_ns[i] - clock.stamp_ns(i)), 2);
  clock.scatter_s = 1e-9 * std::sqrt(square / static_cast<double>(time_ns.size()));
  return clock;
}

std::optional<EvenClock> replacing_clock(const Recording& r, Stamps wanted) {
  if (wanted == Stamps::recorded) return std::nullopt;
  std::optional<EvenClock> clock = even_clock(r.time_ns);
  // A recording with pauses has a mean interval far from its nominal one; a serial line's stamps are a few percent off.
  if (clock && std::abs(clock->interval_s / r.interval_s - 1) > 0.2) clock.reset();
  if (!clock && wanted == Stamps::uniform)
    throw Error(fmt::format(
        "{}: its stamps are not those of an even clock (samples are missing, or the clock wanders); expected the recorded stamps to be kept",
        r.name));
  return clock && (wanted == Stamps::uniform || clock->scatter_s > 0.05 * clock->interval_s) ? clock : std::nullopt;
}

Recording with_even_stamps(Recording r, const EvenClock& clock, bool interval_declared) {
  for (std::size_t i = 0; i < r.size(); ++i) r.time_ns[i] = clock.stamp_ns(i);
  if (!interval_declared) {
    for (const auto& [triad, increment] : {std::pair{&r.gyro, r.gyro_increment}, {&r.accel, r.accel_increment}})
      for (std::vector<double>& column : *triad)
        for (double& reading : column) reading *= increment ? r.interval_s / clock.interval_s : 1;
    r.interval_s = clock.interval_s;
  }
  if (!r.gyro_increment && !r.accel_increment) r.interval_s = clock.interval_s;
  r.gaps.clear();
  return r;
}

}  // namespace imulab
