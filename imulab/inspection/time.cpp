#include "imulab/inspection/time.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/inspection/makers.hpp"
#include "imulab/inspection/names.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/resampling.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab::inspection {

namespace {

constexpr std::size_t looked_at = 200'000;            // rows: enough to know a clock
constexpr double slowest_hz = 10, fastest_hz = 10e3;  // of an IMU; a thousand apart, so that one unit of time fits
constexpr double usual_hz = 1000.5;                   // above, the same step is more often ticks or the slow rate of a larger unit: asked for
constexpr std::array<const char*, 4> time_units{"s", "ms", "us", "ns"};

/// The steps by which the numbers of a column advance.
struct Steps {
  double typical = 0;        ///< median of those above 0
  double even = 0;           ///< part of the steps that are within half of it
  bool whole = false;        ///< all numbers are whole
  double scatter = 0;        ///< mean distance of a step from a multiple of the typical one, part of it
  bool on_average = false;   ///< the steps are not even, but sums of sixteen are
  bool ones = false;         ///< nearly every step is exactly 1
  std::optional<int> bits;   ///< the numbers begin again after 2^bits
  std::size_t backward = 0;  ///< steps back that are no such beginning
  double first = 0;
};

constexpr std::size_t rows_a_backward = 100;  // that are out of order
constexpr double even_enough = 0.6;           // part of the steps
constexpr double no_multiples = 0.02;         // of the typical step: where rows are lost, steps are multiples of it

/// Takes the mean step of sixteen as the typical one, where these hardly differ while the steps do, or are no multiples of the typical one.
void take_average(const std::vector<double>& values, Steps& s) {
  constexpr std::size_t several = 16;
  std::vector<double> sums;
  for (std::size_t i = several; i < std::min(values.size(), looked_at); i += several) sums.push_back(values[i] - values[i - several]);
  if (sums.size() < 4) return;
  const double typical = median(sums);
  double even = 0, mean = 0;
  for (const double sum : sums)
    if (std::abs(sum - typical) < 0.1 * typical) ++even, mean += sum;
  if (!(typical > 0 && even > 0.9 * static_cast<double>(sums.size()))) return;
  mean /= even * several;
  constexpr double far_apart = 0.25;  // else they are rounded, or jitter, which reading settles
  s.on_average = s.even <= even_enough || (s.scatter > no_multiples && std::abs(mean - s.typical) > far_apart * mean);
  if (s.on_average || s.scatter > no_multiples) s.typical = mean;
}

std::optional<Steps> steps_of(const std::vector<double>& values) {
  Steps s;
  std::vector<double> forward, backward;
  std::size_t missing = 0, ones = 0;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  s.whole = true;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      ++missing;
      continue;
    }
    s.whole = s.whole && values[i] == std::floor(values[i]);
    least = std::min(least, values[i]), most = std::max(most, values[i]);
    const double step = i == 0 || !std::isfinite(values[i - 1]) ? 0 : values[i] - values[i - 1];
    ones += step == 1;
    if (step > 0 && forward.size() < looked_at) forward.push_back(step);
    if (step < 0) backward.push_back(step);
  }
  const std::size_t n = std::min(values.size(), looked_at);
  if (n < 3 || forward.size() * 2 < n || missing * 100 > values.size()) return std::nullopt;
  s.first = values.front();
  s.typical = median(forward);
  s.ones = s.whole && s.typical == 1 && ones * 10 > 9 * values.size();
  for (const double step : forward) s.even += std::abs(step - s.typical) < 0.5 * s.typical ? 1.0 / static_cast<double>(forward.size()) : 0.0;
  for (const int bits : {16, 24, 32}) {  // a counter's numbers, with a sign or without, jump back by its range
    const double range = std::ldexp(1, bits);
    const bool fits =
        s.whole && !backward.empty() && ((least >= 0 && most < range) || (least >= -range / 2 && most < range / 2)) &&
        std::all_of(backward.begin(), backward.end(), [&](double step) { return std::abs(step + range) < std::min(20 * s.typical, range / 4); });
    if (fits && !s.bits) s.bits = bits;
  }
  s.backward = s.bits ? 0 : backward.size();
  for (const double step : forward)
    s.scatter += std::abs(step / s.typical - std::max(1.0, std::round(step / s.typical))) / static_cast<double>(forward.size());
  if (backward.empty()) take_average(values, s);
  return s;
}

/// True if the numbers advance as a clock's do: in even steps, forward but for a few rows out of order.
bool is_clock(const Steps& s, std::size_t rows) { return (s.even > even_enough || s.on_average) && s.backward * rows_a_backward < rows; }

double in_seconds(const char* unit) { return std::pow(10.0, time_exponent(unit) - 9); }

bool is_date(double first, const char* unit) {
  const double seconds = first * in_seconds(unit);
  return seconds > 9.5e8 && seconds < 2.5e9;  // 2000 to 2049
}

/// Seconds in one column and their fraction in another: the second falls back where the first goes on by one.
std::optional<std::pair<std::size_t, std::size_t>> split_clock(const SignalTable& table, const char*& unit) {
  for (std::size_t a = 0; a < table.signals.size(); ++a) {
    const std::vector<double>& seconds = table.signals[a].values;
    const std::size_t n = std::min(seconds.size(), looked_at);
    std::size_t turns = 0, back = 0;
    bool whole = n > 2;
    for (std::size_t i = 1; i < n && whole; ++i) {
      const double step = seconds[i] - seconds[i - 1];
      whole = step == std::floor(step) && seconds[i] == std::floor(seconds[i]);
      turns += step > 0, back += step < 0;
    }
    if (!whole || turns == 0 || turns * 4 > n || back * rows_a_backward >= n) continue;
    for (std::size_t b = 0; b < table.signals.size(); ++b) {
      if (b == a) continue;
      const std::vector<double>& fraction = table.signals[b].values;
      std::size_t falls = 0, together = 0;
      double largest = 0;
      for (std::size_t i = 1; i < n; ++i) {
        const bool falling = fraction[i] < fraction[i - 1];
        falls += falling && seconds[i] >= seconds[i - 1];
        together += falling && seconds[i] > seconds[i - 1];
        largest = std::max(largest, fraction[i]);
      }
      if (falls == 0 || falls != together || falls + 1 < turns || fraction[0] != std::floor(fraction[0])) continue;
      for (const auto& [name, full] : {std::pair{"ms", 1e3}, {"us", 1e6}, {"ns", 1e9}})
        if (largest < full && largest > 0.5 * full) {
          unit = name;
          return std::pair{a, b};
        }
    }
  }
  return std::nullopt;
}

/// The unit of a clock's column: nothing in `unit` where the data do not tell.
void choose_unit(TimeGuess& guess, const Signal& signal, const Steps& steps) {
  const NameHint hint = hint_of(signal.name);
  const std::string stated = !signal.unit.empty() ? signal.unit : hint.unit;
  std::vector<const char*> fit, dated;
  for (const char* unit : time_units) {
    const double rate = 1 / (steps.typical * in_seconds(unit));
    if (rate >= slowest_hz * 0.999 && rate < fastest_hz * 0.999) fit.push_back(unit);
    if (is_date(steps.first, unit) && rate > 0.5 && rate < 100e3) dated.push_back(unit);
  }
  const std::string name = signal.name.empty() ? fmt::format("column {}", std::get<int>(signal.column)) : signal.name;
  const auto decide = [&](const std::string& unit, const std::string& why) {
    guess.source.unit = unit;
    guess.rate_hz = 1 / (steps.typical * in_seconds(unit.c_str()));
    guess.evidence = fmt::format("{} advances by {:.6g}: {} ({}), {:.5g} Hz", name, steps.typical, unit, why, *guess.rate_hz);
  };
  if (!hint.unknown.empty() && signal.unit.empty()) {
    guess.open = {"time.unit",
                  fmt::format("{} advances by {:.6g} of a unit that is not known here; expected s, ms, us, ns, tick or sample", name, steps.typical)};
    return;
  }
  if (const auto clock = makers_clock(signal.name, steps.typical); clock && signal.unit.empty()) {
    guess.source.unit = "tick";
    guess.source.ticks_per_s = clock->ticks_per_s;
    for (const char* unit : time_units)
      if (in_seconds(unit) * clock->ticks_per_s == 1) guess.source.unit = unit, guess.source.ticks_per_s.reset();
    guess.rate_hz = clock->ticks_per_s / steps.typical;
    guess.evidence = fmt::format("{} advances by {:.6g}: {:g} a second ({}'s clock of that name), {:.5g} Hz", name, steps.typical, clock->ticks_per_s,
                                 clock->maker, *guess.rate_hz);
    return;
  }
  if (hint.ticks) {
    guess.source.unit = "tick";
    guess.evidence = fmt::format("{} advances by {:.6g}: ticks, by its name", name, steps.typical);
    guess.open = length_of_tick();
    return;
  }
  if (!stated.empty() && std::find(time_units.begin(), time_units.end(), stated) != time_units.end()) {
    decide(stated, signal.unit.empty() ? "its name" : "the format");
    if (*guess.rate_hz < 0.5 || *guess.rate_hz > 100e3)
      guess.open = {"time.unit", fmt::format("{} is named {}, which gives {:.3g} Hz, implausible for an IMU", name, stated, *guess.rate_hz)};
    return;
  }
  if (dated.size() == 1) return decide(dated[0], "it begins at a date since 1970");
  if (steps.ones && hint.role != Role::time) {
    guess.source.unit = "sample";
    guess.evidence = fmt::format("{} advances by 1: it numbers the samples", name);
    guess.open = {"rate_hz", "samples are numbered, not timed"};
    return;
  }
  if (steps.ones || fit.size() != 1) {
    guess.source.unit = "s";
    guess.evidence = fmt::format("{} advances by {:.6g}", name, steps.typical);
    guess.open = {"time.unit", fmt::format("{} advances by {:.6g}; {}", name, steps.typical,
                                           steps.ones ? "a number of the sample, or ms" : "no unit of time gives a rate from 10 Hz to 10 kHz")};
    return;
  }
  guess.by_rate_alone = steps.whole;
  decide(fit[0],
         steps.whole ? "of the usual units the only one with a rate from 10 Hz to 10 kHz" : "in no other unit the rate is from 10 Hz to 10 kHz");
  if (*guess.rate_hz > usual_hz)
    guess.open = {"time.unit", fmt::format("{} advances by {:.6g}: {} would make {:.5g} Hz", name, steps.typical, fit[0], *guess.rate_hz)};
}

}  // namespace

Question length_of_tick() { return {"time.ticks_per_s", "how many ticks are a second (or how long a tick is: --set time.unit=us, ms or ns)"}; }

TimeGuess recognize_time(const SignalTable& table) {
  TimeGuess guess;
  guess.source.column.reset();
  guess.source.unit = "sample";
  const char* fraction_unit = "ns";
  if (const auto split = split_clock(table, fraction_unit)) {
    guess.column = split->first;
    guess.fraction = split->second;
    guess.source.column = table.signals[split->first].column;
    guess.source.unit = "s";
    guess.source.fraction_column = table.signals[split->second].column;
    guess.source.fraction_unit = fraction_unit;
    const std::vector<std::int64_t> stamps = stamps_of(table, guess);
    std::vector<double> steps;
    for (std::size_t i = 1; i < std::min(stamps.size(), looked_at); ++i) steps.push_back(1e-9 * static_cast<double>(stamps[i] - stamps[i - 1]));
    guess.rate_hz = 1 / median(steps);
    guess.evidence = fmt::format("whole seconds in one column, {} in another that falls back with each: {:.5g} Hz", fraction_unit, *guess.rate_hz);
    return guess;
  }
  struct Candidate {
    std::size_t index;
    Steps steps;
    int merit;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < table.signals.size(); ++i) {
    auto steps = steps_of(table.signals[i].values);
    if (!steps || !is_clock(*steps, table.rows())) continue;
    const Role role = hint_in(table, i).role;
    steps->ones = steps->ones || (steps->whole && steps->typical == 1 && role == Role::sample_number);  // with rows left out
    if (role == Role::gyro || role == Role::accel || role == Role::other || role == Role::temperature) continue;
    const bool time = role == Role::time || !table.signals[i].unit.empty();
    if (steps->on_average && steps->even <= even_enough && !time) continue;
    const bool ticks = hint_in(table, i).ticks || steps->on_average;
    candidates.push_back({i, *steps, (time ? 4 : 0) + (steps->ones ? 0 : 2) - (ticks ? 1 : 0)});
  }
  if (candidates.empty() && table.rate_hz) {
    guess.rate_hz = table.rate_hz;
    guess.evidence = fmt::format("no column advances in even steps: the rows are at equal spacing, {:.6g} Hz, as {} of the file says", *table.rate_hz,
                                 table.rate_name);
    return guess;
  }
  if (candidates.empty()) {
    guess.evidence = "no column advances in even steps: the rows have no stamps";
    guess.open = {"rate_hz", "the rows have no stamps that advance in even steps; declare the rate of the rows"};
    return guess;
  }
  const auto best = std::max_element(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    const bool evener = b.steps.scatter < a.steps.scatter / 3 && a.steps.scatter > 0.01;  // than stamps of receipt are those of a sensor
    return a.merit < b.merit || (a.merit == b.merit && evener);
  });
  for (const Candidate& c : candidates)
    if (&c != &*best && !table.signals[c.index].name.empty()) guess.others.push_back(table.signals[c.index].name);
  const Signal& signal = table.signals[best->index];
  guess.column = best->index;
  guess.source.column = signal.column;
  guess.source.wrap_bits = best->steps.bits;
  guess.even_on_average = best->steps.on_average;
  guess.step = best->steps.typical;
  choose_unit(guess, signal, best->steps);
  if (best->steps.bits) guess.evidence += fmt::format("; begins again after 2^{}", *best->steps.bits);
  return guess;
}

std::vector<std::int64_t> stamps_of(const SignalTable& table, const TimeGuess& time) {
  const bool counted = !time.column || time.source.unit == "sample";
  if ((counted && !time.rate_hz) || (time.source.unit == "tick" && !time.source.ticks_per_s)) return {};
  Clock clock(time.source, time.rate_hz);
  std::vector<std::int64_t> stamps;
  stamps.reserve(table.rows());
  for (std::size_t i = 0; i < table.rows(); ++i) {
    std::optional<std::int64_t> ns;
    if (!time.column) {
      ns = clock.next();
    } else {
      const auto stamp = scaled_stamp(table.signals[*time.column].values[i], clock.exponent());
      const auto fraction = time.fraction ? scaled_stamp(table.signals[*time.fraction].values[i], clock.fraction_exponent()) : 0;
      if (stamp && fraction) ns = clock.next(*stamp, *fraction);
    }
    if (!ns) return {};
    stamps.push_back(*ns);
  }
  return stamps;
}

ClockQuality clock_quality(const std::vector<std::int64_t>& time_ns) {
  ClockQuality quality;
  for (std::size_t i = 1; i < time_ns.size(); ++i) {
    quality.repeated += time_ns[i] == time_ns[i - 1];
    if (time_ns[i] < time_ns[i - 1] && quality.backward++ == 0) quality.first_backward = i;
  }
  if (quality.backward > 0 || time_ns.size() < 3) return quality;
  std::vector<std::int64_t> stamps = ascending(time_ns);
  for (std::int64_t& stamp : stamps) stamp -= time_ns.front();
  const StampIntervals intervals = stamp_intervals(stamps);
  quality.interval_s = intervals.median;
  quality.rate_hz = intervals.mean > 0 ? 1 / intervals.mean : 0;
  const std::vector<std::size_t> gaps = find_gaps(stamps, intervals.mean);
  quality.gaps = gaps.size();
  for (const std::size_t i : gaps) quality.largest_gap_s = std::max(quality.largest_gap_s, 1e-9 * static_cast<double>(stamps[i] - stamps[i - 1]));
  if (const auto even = even_clock(stamps)) quality.scatter_s = even->scatter_s;
  return quality;
}

std::vector<std::int64_t> ascending(std::vector<std::int64_t> time_ns) {
  for (std::size_t i = 1; i < time_ns.size(); ++i) time_ns[i] = std::max(time_ns[i], time_ns[i - 1] + 1);
  return time_ns;
}

}  // namespace imulab::inspection
