#include "imulab/formats/recording/reader.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/parts.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/recording/repeated_rows.hpp"
#include "imulab/recording/unit_names.hpp"
#include "imulab/recording/validate.hpp"
#include "imulab/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

namespace imulab {
namespace {

using namespace recording_io;

/// Rounding to less of an interval than this moves no nominal interval by as much as two quoted rates may differ.
constexpr double said_of_rounding = 0.02;

/// No gap is reported where a recording stops between two of its steps: who records point by point leaves out the time between them.
bool between_steps(std::span<const Step> steps, double begin_s, double end_s, double interval_s) {
  const auto next = std::partition_point(steps.begin(), steps.end(), [&](const Step& step) { return step.end <= begin_s + interval_s; });
  return next != steps.begin() && next != steps.end() && next->start >= end_s - interval_s;
}

/// Declared, or the stamps' median. Throws Error where the stamps contradict what is declared.
double nominal_interval_s(std::span<const std::int64_t> time_ns, const std::string& file, const RecordingSource& source,
                          std::vector<std::string>& warnings) {
  if (time_ns.size() < 2) {
    if (source.rate_hz) return 1 / *source.rate_hz;
    throw Error(fmt::format("{}: has one row; expected at least two (or rate_hz in the session)", file));
  }
  const StampIntervals stamps = stamp_intervals(time_ns);
  if (source.rate_hz) {
    const double declared = 1 / *source.rate_hz;
    if (stamps.allow(declared)) return declared;
    throw Error(fmt::format("{}: rate_hz = {} is declared, but the stamps give {:.6g} Hz (median difference {:.6g} s); expected agreement within 2 %",
                            file, *source.rate_hz, 1 / stamps.median, stamps.median));
  }
  if (stamps.rounded_s && *stamps.rounded_s > said_of_rounding * stamps.median)
    warnings.push_back(fmt::format("{}: the stamps are rounded to {:g} s; an even clock of {:.4g} s ({:.4g} Hz) fits them, and gives its interval",
                                   file, *stamps.rounded_s, stamps.median, 1 / stamps.median));
  if (!same_interval(stamps.median, stamps.mean)) {
    const bool increments = source.gyro.output == Output::increment || source.accel.output == Output::increment;
    warnings.push_back(fmt::format(
        "{}: the stamps' differences are uneven (median {:.6g} s, mean {:.6g} s); the median is taken as the nominal interval{}", file, stamps.median,
        stamps.mean, increments ? ", which scales increments: declare rate_hz" : "; " + even_rows_advice(1 / stamps.mean)));
  }
  return stamps.median;
}

/// Reports the gaps that the steps do not explain. `table` gives the places of rows.
void warn_of_gaps(const RecordingView& recording, const TableRows& table, std::span<const Step> steps, std::vector<std::string>& warnings) {
  const double interval_s = recording.interval_s;
  std::size_t unexplained = 0, where = 0;
  std::int64_t largest = 0;
  for (const std::size_t i : recording.gaps) {
    if (between_steps(steps, recording.time_s(i - 1), recording.time_s(i) - interval_s, interval_s)) continue;
    ++unexplained;
    if (const std::int64_t step = recording.time_ns[i] - recording.time_ns[i - 1]; step > largest) largest = step, where = i;
  }
  if (unexplained > 0)
    warnings.push_back(
        fmt::format("{}: {} gap{} in time (more than 1.5 of the nominal {:.6g} s), the largest of {} s before {} s ({}); what "
                    "moved inside a gap is not seen",
                    table.file, unexplained, unexplained == 1 ? "" : "s", interval_s, text::seconds_text(largest),
                    text::seconds_text(recording.time_ns[where]), table.place(where)));
}

void warn_of_saturated(const RecordingView& recording, const TableRows& table, std::vector<std::string>& warnings) {
  const std::span<const std::size_t> saturated = recording.saturated;
  if (saturated.empty()) return;
  warnings.push_back(fmt::format("{}: {} sample{} at a limit, the first at {} s ({}): the true reading lies beyond, such samples are not used",
                                 table.file, saturated.size(), saturated.size() == 1 ? "" : "s", text::seconds_text(recording.time_ns[saturated[0]]),
                                 table.place(saturated[0])));
}

/// Throws Error for a reading that no sensor gives, named by its line.
void expect_plausible(const Columns3& triad, const ReadingOptions& options, Quantity quantity, double interval_s, const TableRows& table) {
  const char* const name = quantity == Quantity::gyro ? "gyro" : "accel";
  const std::string_view si = options.unit == "count" ? "count" : quantity == Quantity::gyro ? "rad/s" : "m/s^2";
  const double largest = largest_reading(si) / si_factor(options.unit) * options.counts_per_unit * (options.increment ? interval_s : 1);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < triad[axis].size(); ++i)
      if (!(std::abs(triad[axis][i]) <= largest))
        throw Error(fmt::format("{}: {}: {} {} is {:g} {}; expected a reading that a sensor can give", table.file, table.place(i), name, "xyz"[axis],
                                triad[axis][i], options.unit));
}

void expect_possible_temperature(const std::optional<ThermalSource>& source, const Columns3& readings, const TableRows& table) {
  if (!source || source->unit == "raw") return;
  constexpr double least_degC = -273.15, most_degC = 1000;  // absolute zero; every IMU has melted
  const double zero = source->unit == "K" ? -least_degC : 0;
  for (const auto& column : readings)
    for (std::size_t i = 0; i < column.size(); ++i)
      if (!(column[i] >= least_degC + zero && column[i] <= most_degC + zero))
        throw Error(fmt::format("{}: {}: the temperature is {:g} {}; expected {:g} to {:g}, or unit = \"raw\"", table.file, table.place(i), column[i],
                                source->unit, least_degC + zero, most_degC + zero));
}

/// Increments become rates by the declared interval, so a wrong one scales them.
void warn_of_rate(const RecordingSource& source, const RecordingView& recording, const TableRows& table, std::vector<std::string>& warnings) {
  if (!source.rate_hz || (source.gyro.output != Output::increment && source.accel.output != Output::increment)) return;
  const double by_stamps = 1 / clock_interval(recording.time_ns, recording.interval_s), error = *source.rate_hz / by_stamps - 1;
  if (std::abs(error) > 1e-3)  // oscillators agree to 1e-4
    warnings.push_back(
        fmt::format("{}: rate_hz = {} is declared, the stamps give {:.6g} Hz; increments are divided by the declared interval, so scales "
                    "are {:.2g} % off if the stamps are right",
                    table.file, *source.rate_hz, by_stamps, 100 * error));
}

void warn_of_repeated(const TableRows& table, std::vector<std::string>& warnings) {
  if (table.repeated > 0)
    warnings.push_back(fmt::format("{}: {} row{} equal to the row before dropped", table.file, table.repeated, table.repeated == 1 ? "" : "s"));
}

/// Rows that repeat the readings before are reported; those of both triads are returned, to be left out. One triad alone may repeat where a slow one
/// was logged with a fast one. `resampled`: the accelerometers were brought to the gyros' stamps, where those of a slower sensor repeat.
std::optional<RepeatedRows> to_leave_out(const RecordingView& recording, const std::string& file, bool resampled,
                                         std::vector<std::string>& warnings) {
  const std::size_t first = recording.has(gyro_columns) ? gyro_columns : accel_columns;
  const std::size_t end = recording.has(accel_columns) ? gyro_temperature_columns : accel_columns;
  std::optional<RepeatedRows> found = repeated_rows(recording, first, end);
  if (found) {
    warnings.push_back(fmt::format("{}: {}", file, said_of(*found, "rows", true)));
  } else if (end - first == 6) {
    for (const auto& [column, name] : {std::pair{gyro_columns, "gyros' readings"}, {accel_columns, "accelerometers' readings"}})
      if (const auto of_triad = resampled && column == accel_columns ? std::nullopt : repeated_rows(recording, column, column + 3))
        warnings.push_back(fmt::format("{}: {}", file, said_of(*of_triad, name, false)));
  }
  if (found && found->samples.empty()) found.reset();
  return found;
}

/// The tables' rows, or those of a piece, in SI or counts; each reading is one that a sensor can give.
Recording checked(RecordingParts& parts, const RecordingSource& source, std::optional<double> interval_s) {
  TableRows& reference = parts.reference();
  Readings readings = take_readings(parts, source);
  readings.options.interval_s = interval_s;
  expect_plausible(readings.gyro, readings.options.gyro, Quantity::gyro, interval_s.value_or(0), reference);
  expect_plausible(readings.accel, readings.options.accel, Quantity::accel, interval_s.value_or(0), parts.tables[parts.accel.table]);
  Recording recording = convert_readings(std::move(readings.gyro), std::move(readings.accel), std::move(readings.options));
  expect_possible_temperature(source.gyro_temperature, recording.gyro_temperature, reference);
  expect_possible_temperature(source.accel_temperature, recording.accel_temperature, reference);
  recording.time_ns = std::move(reference.time_ns);
  return recording;
}

/// Reports the findings in a recording that is complete. `table` gives the places of its rows.
void warn_of_findings(const RecordingView& recording, const TableRows& table, const Session& session, const RecordingSource& source,
                      std::vector<std::string>& warnings) {
  warn_of_rate(source, recording, table, warnings);
  warn_of_gaps(recording, table, session.steps_of(source), warnings);
  warn_of_saturated(recording, table, warnings);
}

std::string why_not_in_pieces(const RecordingFormat& format, const TableRequest& request, const std::vector<TableDescription>& tables,
                              const RecordingParts& parts, const RecordingSource& source) {
  if (!format.in_pieces) return fmt::format("{} is read as a whole; expected CSV, .npy or .npz for a log as long as this", format.name);
  if (!in_pieces(format, request, tables, parts.requests.front().columns))
    return "compressed arrays whose columns stand one after the other are read as a whole; expected rows, or arrays that are not compressed";
  if (parts.requests.size() > 1) return "its triads are in several tables, which are read as a whole";
  const bool increments = source.gyro.output == Output::increment || source.accel.output == Output::increment;
  if (increments && !source.rate_hz) return "increments without rate_hz are read as a whole; expected rate_hz in the session";
  return "";
}

/// Adds to `all` what the pieces have in common, and their lines.
void add_places(TableRows& all, std::size_t& rows, const TableRows& piece) {
  all.file = piece.file;
  all.row = piece.row;
  all.lines.append(piece.lines, rows, 0);
  all.repeated += piece.repeated;
  all.warnings.insert(all.warnings.end(), piece.warnings.begin(), piece.warnings.end());
  rows += piece.time_ns.size();
}

}  // namespace

RecordingReading read_recording(const Session& session, const RecordingSource& source) {
  return read_recording(session, source, recording_formats());
}

RecordingReading read_recording(const Session& session, const RecordingSource& source, const std::vector<RecordingFormat>& formats) {
  RecordingParts parts = requested_parts(source);
  for (const PartRequest& part : parts.requests)
    parts.tables.push_back(read_table({session_path(session, part.file), part.topic, source.layout},
                                      {.columns = part.columns, .time = part.time, .rate_hz = source.rate_hz}, formats));
  RecordingReading reading;
  for (const TableRows& table : parts.tables) reading.warnings.insert(reading.warnings.end(), table.warnings.begin(), table.warnings.end());
  for (const TableRows& table : parts.tables) warn_of_repeated(table, reading.warnings);
  const double interval_s = nominal_interval_s(parts.reference().time_ns, parts.reference().file, source, reading.warnings);
  const bool resampled = join_by_time(parts, interval_s, source.accel.output == Output::increment, reading.warnings);
  match_rows(parts, interval_s, reading.warnings);
  reading.recording = checked(parts, source, interval_s);
  validate(reading.recording);  // rows without a partner are gone
  RecordingOptions options = recording_options(source);
  options.interval_s = interval_s;
  if (const auto repeated = to_leave_out(reading.recording, parts.reference().file, resampled, reading.warnings)) {
    leave_out_lines(parts.reference(), reading.recording.size(), repeated->samples);
    reading.recording = without_samples(std::move(reading.recording), *repeated);
    if (repeated->evenly) options.interval_s = stamp_intervals(reading.recording.time_ns).median;
  }
  reading.recording = completed(std::move(reading.recording), options);
  warn_of_findings(reading.recording, parts.reference(), session, source, reading.warnings);
  return reading;
}

std::optional<StoredReading> read_stored(const Session& session, const RecordingSource& source, std::uint64_t most_bytes, std::string& why,
                                         const std::vector<RecordingFormat>& formats) {
  RecordingParts parts = requested_parts(source);
  const PartRequest& part = parts.requests.front();
  const TableRequest request{session_path(session, part.file), part.topic, source.layout};
  const RecordingFormat& format = format_of(request, formats);
  const std::string file = request.file.string();
  if (!format.in_pieces && bytes_of(request.file) < most_bytes) return std::nullopt;
  const std::vector<TableDescription> tables = format.describe(request);
  const std::uint64_t bytes = 8 * (part.columns.size() + 1) * rows_of(tables, request.topic);
  if (bytes <= most_bytes) return std::nullopt;
  if (const std::string reason = why_not_in_pieces(format, request, tables, parts, source); !reason.empty()) {
    why = fmt::format("{}: its columns take {:.2g} GB, the analysis two to three times as much memory: {}", file, 1e-9 * static_cast<double>(bytes),
                      reason);
    return std::nullopt;
  }
  expect_room(bytes + bytes / 10);
  StoredReading reading{StoredRecording(source), {}};
  TableRows all;
  std::size_t rows = 0;
  read_pieces(request, {.columns = part.columns, .in_pieces = true, .time = part.time, .rate_hz = source.rate_hz}, format, [&](TableRows&& piece) {
    add_places(all, rows, piece);
    parts.tables.clear();
    parts.tables.push_back(std::move(piece));
    reading.recording.append(checked(parts, source, recording_options(source).interval_s));
  });
  reading.recording.end_of_pieces();
  reading.warnings = all.warnings;
  warn_of_repeated(all, reading.warnings);
  double interval_s = nominal_interval_s(reading.recording.time_ns(), all.file, source, reading.warnings);
  if (const auto repeated = to_leave_out(reading.recording.view(), all.file, false, reading.warnings)) {
    leave_out_lines(all, rows, repeated->samples);
    reading.recording.leave_out(*repeated);
    if (repeated->evenly) interval_s = stamp_intervals(reading.recording.time_ns()).median;
  }
  reading.recording.complete(interval_s, recording_options(source));
  warn_of_findings(reading.recording.view(), all, session, source, reading.warnings);
  reading.recording.let_go();
  return reading;
}

}  // namespace imulab
