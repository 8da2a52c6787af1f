// The clock of a recording: the numbers that files have for time become nanoseconds; stamps have an interval, gaps and a phase, despite rounding and
// single late stamps.
#pragma once

#include "imulab/session.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Turns the stamps of a table, one after the other, into nanoseconds less the zero.
class Clock {
 public:
  /// `rate_hz`: of the samples, which count time where the source has no stamps or numbers of samples. Throws Error without it there.
  Clock(const TimeSource& source, std::optional<double> rate_hz);

  /// A column's number becomes the integer that next() takes when multiplied by 10^exponent(): nanoseconds, or whole ticks or samples.
  int exponent() const { return exponent_; }
  int fraction_exponent() const { return fraction_exponent_; }

  /// True if a stamp's time does not depend on those before.
  bool is_independent() const { return modulus_ == 0; }

  /// The stamp of the next row; nothing where it is more than 146 years from the zero, so that differences would not fit.
  std::optional<std::int64_t> next(std::int64_t stamp, std::int64_t fraction_ns = 0);
  /// The stamp of the next row of a table without stamps.
  std::optional<std::int64_t> next() { return next(row_++); }

 private:
  int exponent_ = 9, fraction_exponent_ = 0;
  std::int64_t zero_ = 0, modulus_ = 0, wrapped_ = 0, row_ = 1;  // a sample's stamp is the end of its interval
  std::optional<std::int64_t> last_;
  std::optional<double> per_second_;  // of ticks or samples
};

/// A column's number as the integer that a clock takes, times 10^exponent; nothing where it does not fit or is none.
std::optional<std::int64_t> scaled_stamp(double number, int exponent);
std::optional<std::int64_t> scaled_stamp(std::int64_t number, int exponent);

/// True if two intervals agree within 2 % of the second. Oscillators agree to 1e-4 and a quoted rate is often rounded by a percent; a wrong one
/// (unit, decimation, another logger setting) differs by a tenth or more.
bool same_interval(double a_s, double b_s);

/// True if more than half of the stamps' differences, so also their median, agree with the interval.
bool mostly_spaced(std::span<const std::int64_t> time_ns, double interval_s);

/// Throws Error, naming the sample, where stamps go back or repeat. `name` stands for the recording.
void expect_increasing(std::string_view name, std::span<const std::int64_t> time_ns);

/// The differences of stamps [s]; zero if there is none.
struct StampIntervals {
  double median = 0;
  double mean = 0;                  ///< of the differences of at most one and a half medians: gaps do not count
  std::optional<double> rounded_s;  ///< of stamps that were rounded to so much: median and mean are then the interval of their clock

  /// Where stamps scatter, the median or the mean is right: an interval is contradicted where both differ from it.
  bool allow(double interval_s) const { return same_interval(median, interval_s) || same_interval(mean, interval_s); }
};
/// The intervals of ascending stamps, without the differences that end at a sample in `without` (ascending). Where `without` is empty, many stamps
/// take little memory, as in clock_interval and find_gaps.
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

/// The difference of rank k, from 0, among those of stamps `apart` samples apart: in four passes and half a megabyte, however many there are.
std::int64_t difference_of_rank(std::span<const std::int64_t> time_ns, std::size_t apart, std::size_t k);

/// Stamps of an even clock that were written with few digits: 400 Hz in whole milliseconds advance by 2 and by 3 ms.
struct RoundedStamps {
  double step_s = 0;      ///< the stamps are whole multiples of it
  double interval_s = 0;  ///< of the clock: between the two differences that there are
};

/// The rounding of ascending stamps; nothing where they are not rounded, or not those of an even clock. Samples may be missing.
std::optional<RoundedStamps> rounded_stamps(std::span<const std::int64_t> time_ns);

/// What to type where stamps cannot be used, and a sensor's rows are to be taken at equal spacing. Without a rate, HZ stands for it.
std::string even_rows_advice(std::optional<double> rate_hz = std::nullopt);

/// A sensor samples evenly; a serial line, a busy computer or a coarse clock stamps its samples late: stamp i = first_ns + i * interval_s, late by up
/// to a few intervals.
struct EvenClock {
  double first_ns = 0, interval_s = 0;
  double scatter_s = 0;  ///< RMS of the stamps about it

  std::int64_t stamp_ns(std::size_t i) const;
};

/// The clock along the earliest stamps (a stamp can be late, not early); empty where the stamps do not support it: fewer than 200, samples missing,
/// or earliest stamps of fifty that stray by more than a quarter of an interval from one line (a clock that wanders).
std::optional<EvenClock> even_clock(std::span<const std::int64_t> time_ns);

}  // namespace imulab
