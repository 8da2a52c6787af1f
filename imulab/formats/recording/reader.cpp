#include "imulab/formats/recording/checks.hpp"
#include "imulab/formats/recording/file.hpp"
#include "imulab/formats/recording/parts.hpp"
#include "imulab/recording/make_recording.hpp"

#include <utility>

namespace imulab {

RecordingReading read_recording(const Session& session, const RecordingSource& source, const std::vector<RecordingFormat>& formats) {
  using namespace recording_io;
  RecordingParts parts = read_parts(session, source, formats);
  RecordingReading reading;
  TimedTable& reference = parts.tables[parts.gyro.table];
  for (const TimedTable& table : parts.tables) reading.warnings.insert(reading.warnings.end(), table.warnings.begin(), table.warnings.end());
  for (const TimedTable& table : parts.tables) warn_of_repeated(table, reading.warnings);

  const double interval_s = nominal_interval_s(reference.time_ns, reference.file, source, reading.warnings);
  join_by_time(parts, interval_s, source.accel.output == Output::increment, reading.warnings);
  match_rows(parts, interval_s, reading.warnings);
  RecordingOptions options = recording_options(source);
  options.interval_s = interval_s;
  options.gyro.temperature = take_columns(parts, parts.gyro_temperature);
  options.accel.temperature = take_columns(parts, parts.accel_temperature);
  Columns3 gyro = three_columns(take_columns(parts, parts.gyro)), accel = three_columns(take_columns(parts, parts.accel));
  expect_plausible(gyro, options.gyro, Quantity::gyro, interval_s, reference);
  expect_plausible(accel, options.accel, Quantity::accel, interval_s, parts.tables[parts.accel.table]);
  reading.recording = make_recording(std::move(reference.time_ns), std::move(gyro), std::move(accel), std::move(options));
  expect_possible_temperature(source.gyro_temperature, reading.recording.gyro_temperature, reference);
  expect_possible_temperature(source.accel_temperature, reading.recording.accel_temperature, reference);
  warn_of_rate(source, reading.recording, reference, reading.warnings);
  warn_of_gaps(reading.recording, reference, session.steps_of(source), reading.warnings);
  warn_of_saturated(reading.recording, reference, reading.warnings);
  return reading;
}

}  // namespace imulab
