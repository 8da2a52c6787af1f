// The clock of a recording from its stamps: the interval between samples, missing samples, and the clock's phase despite single late stamps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Whether two intervals agree within 2 % of the second. Oscillators agree to 1e-4 and a quoted rate is often rounded by a percent; a wrong one
/// (unit, decimation, another logger setting) differs by a tenth or more.
bool same_interval(double a_s, double b_s);

/// Whether more than half of the stamps' differences, so also their median, agree with the interval.
bool mostly_spaced(std::span<const std::int64_t> time_ns, double interval_s);

/// Throws Error, naming the sample, where stamps go back or repeat. `name` stands for the recording.
void expect_increasing(std::string_view name, std::span<const std::int64_t> time_ns);

/// The stamps' differences [s]; zero if there is none.
struct StampIntervals {
  double median = 0;
  double mean = 0;                  ///< of the differences of at most one and a half medians: gaps do not count
  std::optional<double> rounded_s;  ///< of stamps that were rounded to so much: median and mean are then the interval of their clock

  /// Of stamps that scatter the median or the mean is right: an interval is contradicted where both differ from it.
  bool allow(double interval_s) const { return same_interval(median, interval_s) || same_interval(mean, interval_s); }
};
/// Of ascending stamps, without the differences that end at a sample in `without` (ascending).
/// Of many stamps in little memory, as clock_interval and find_gaps, where `without` is empty.
StampIntervals stamp_intervals(std::span<const std::int64_t> time_ns, std::span<const std::size_t> without = {});

/// The samples before which others are missing, ascending: more than one and a half intervals after the previous sample, and the clock is later from
/// there on. A late stamp, as a busy computer gives it, is not a gap.
std::vector<std::size_t> find_gaps(std::span<const std::int64_t> time_ns, double interval_s);

/// The samples' true interval [s] near the nominal one, by medians over sixteen samples: an error of a hundredth is not visible in one sample, but is
/// a sixth of an interval in sixteen.
double clock_interval(std::span<const std::int64_t> time_ns, double nominal_s);

/// By how many intervals the clock is later from sample i on than the samples before predict: 0 for a late stamp, 1 for a lost sample. Estimated from
/// at most sixteen samples on either side, not before `begin` nor from `end` on.
double clock_step(std::span<const std::int64_t> time_ns, std::size_t i, double interval_s, std::size_t begin, std::size_t end);

/// The one of rank k, from 0, among the differences of stamps `apart` samples apart: in four passes and half a megabyte, however many there are.
std::int64_t difference_of_rank(std::span<const std::int64_t> time_ns, std::size_t apart, std::size_t k);

}  // namespace imulab
