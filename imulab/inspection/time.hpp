// Which column of a recording is time, in which unit, and how good its stamps are.
#pragma once

#include "imulab/inspection/signals.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace imulab::inspection {

/// The time column as far as it is known, and the evidence.
struct TimeGuess {
  TimeSource source;                            ///< without a column where the rows have no stamps
  std::optional<std::size_t> column, fraction;  ///< indices of the signals
  bool even_on_average = false;                 ///< single steps of the column vary, sums of sixteen do not: late stamps, or two rows at once
  std::optional<std::size_t> replaced;          ///< that column, once the rows are taken at equal spacing
  double step = 0;                              ///< by which the column advances
  std::optional<double> rate_hz;                ///< of the samples; absent where it cannot be known
  std::string evidence;
  std::vector<std::string> others;  ///< columns that could be time as well
  bool by_rate_alone = false;       ///< whole numbers in the only usual unit that gives a rate of an IMU: they may as well be ticks
  Question open;
};

/// What is asked about a clock of ticks that nothing says the length of.
Question length_of_tick();

/// Finds the column whose numbers advance in even steps, and their unit by what the column states, its beginning (a date since 1970), its name, or
/// its maker. Where none of these tells, the only unit in which the steps are the interval of an IMU (10 Hz to 10 kHz) is taken: for whole numbers,
/// which may be ticks, that is `by_rate_alone`, and has to be confirmed.
TimeGuess recognize_time(const SignalTable& table);

/// Stamps [ns] of the rows by that clock; empty without a rate, and where a row has no stamp.
std::vector<std::int64_t> stamps_of(const SignalTable& table, const TimeGuess& time);

struct ClockQuality {
  double interval_s = 0;  ///< median
  double rate_hz = 0;     ///< by the mean, without gaps
  double scatter_s = 0;   ///< RMS about an even clock; 0 where there is none
  double largest_gap_s = 0;
  std::size_t gaps = 0, repeated = 0;  ///< stamps that follow after missing samples, or equal the one before
  std::size_t backward = 0, first_backward = 0;
};

/// Judges the stamps of all rows.
ClockQuality clock_quality(const std::vector<std::int64_t>& time_ns);

/// The stamps, each at least a nanosecond after the one before.
std::vector<std::int64_t> ascending(std::vector<std::int64_t> time_ns);

}  // namespace imulab::inspection
