#include "imulab/recording/rounded_stamps.hpp"

#include "imulab/recording/stamps.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace imulab {

namespace {

constexpr std::size_t near = 16, far = 1024;  // samples
constexpr double nearly_all = 0.9;            // of the stamps: the others are near lost samples

/// The middle one of the differences of stamps that far apart [ns].
double middle_difference(std::span<const std::int64_t> time_ns, std::size_t apart) {
  return static_cast<double>(difference_of_rank(time_ns, apart, (time_ns.size() - apart) / 2));
}

/// The largest number that all differences are multiples of [ns]; 0 where it is less than a thousandth of `usual`: what is rounded so finely moves no
/// result.
std::int64_t common_step(std::span<const std::int64_t> time_ns, std::int64_t usual) {
  std::int64_t step = usual;
  for (std::size_t i = 1; i < time_ns.size() && 1000 * step >= usual; ++i) step = std::gcd(step, time_ns[i] - time_ns[i - 1]);
  return 1000 * step >= usual ? step : 0;
}

/// Whether stamps that many samples apart differ by what an even clock's do: by that, less or more the rounding of both.
bool is_even(std::span<const std::int64_t> time_ns, std::size_t apart, double interval_ns, double rounding_ns) {
  std::size_t even = 0;
  for (std::size_t i = apart; i < time_ns.size(); ++i)
    even += std::abs(static_cast<double>(time_ns[i] - time_ns[i - apart]) - static_cast<double>(apart) * interval_ns) <= rounding_ns;
  return static_cast<double>(even) >= nearly_all * static_cast<double>(time_ns.size() - apart);
}

/// Of the stretches without a lost sample.
double mean_interval(std::span<const std::int64_t> time_ns, double interval_ns) {
  double time = 0, intervals = 0;
  std::size_t begin = 0;
  const auto add = [&](std::size_t end) {  // of short ones the rounding would count
    if (end - begin > near) time += static_cast<double>(time_ns[end - 1] - time_ns[begin]), intervals += static_cast<double>(end - 1 - begin);
    begin = end;
  };
  for (const std::size_t gap : find_gaps(time_ns, 1e-9 * interval_ns)) add(gap);
  add(time_ns.size());
  return intervals > 0 ? time / intervals : interval_ns;
}

}  // namespace

std::optional<RoundedStamps> rounded_stamps(std::span<const std::int64_t> time_ns) {
  if (time_ns.size() < 4 * near) return std::nullopt;
  const std::int64_t usual = difference_of_rank(time_ns, 1, time_ns.size() / 2), step = common_step(time_ns, usual);
  if (step == 0) return std::nullopt;
  const auto rounding = static_cast<double>(step);
  double interval = middle_difference(time_ns, near) / static_cast<double>(near);
  if (step == usual && interval < 1.1 * rounding) return std::nullopt;  // the clock itself advances by whole steps, of which a few are lost
  if (!is_even(time_ns, 1, interval, rounding) || !is_even(time_ns, near, interval, 2 * rounding)) return std::nullopt;
  // The rounding of two stamps is a sixteenth of it in the interval over sixteen samples, and less over more, as long as few windows lost one.
  std::size_t apart = near;
  for (; 16 * apart <= time_ns.size() && apart < far; apart *= 4) {
    const double longer = middle_difference(time_ns, 4 * apart) / static_cast<double>(4 * apart);
    if (!is_even(time_ns, 4 * apart, longer, 2 * rounding)) break;
    interval = longer;
  }
  return RoundedStamps{1e-9 * rounding, 1e-9 * mean_interval(time_ns, interval)};
}

}  // namespace imulab
