#include "imulab/io/recording_columns.hpp"

#include "imulab/io/unit_names.hpp"

#include <utility>

namespace imulab {
namespace {

/// Marks the samples at or beyond the limits, in the file's unit.
void mark_saturated(const Columns3& triad, const TriadSource& source, std::vector<bool>& saturated) {
  if (!source.limits) return;
  const auto [low, high] = *source.limits;
  if (saturated.empty()) saturated.resize(triad[0].size());
  for (const auto& column : triad)
    for (std::size_t i = 0; i < column.size(); ++i)
      if (column[i] <= low || column[i] >= high) saturated[i] = true;
}

void to_si(Columns3& triad, const TriadSource& source, double interval_s) {
  const double factor = si_factor(source.unit);
  const bool increment = source.output == Output::increment;
  if (factor == 1 && !increment) return;
  for (auto& column : triad)
    for (double& value : column) value = increment ? value * factor / interval_s : value * factor;
}

Columns3 three_columns(std::vector<std::vector<double>> columns) {
  if (columns.empty()) return {};
  if (columns.size() == 1) return {columns[0], columns[0], columns[0]};
  return {std::move(columns[0]), std::move(columns[1]), std::move(columns[2])};
}

}  // namespace

Recording recording_of(const RecordingSource& source, double interval_s, FileColumns columns) {
  Recording recording;
  recording.name = source.file;
  recording.interval_s = interval_s;
  recording.gyro = three_columns(std::move(columns.gyro));
  recording.accel = three_columns(std::move(columns.accel));
  recording.gyro_temperature = three_columns(std::move(columns.gyro_temperature));
  recording.accel_temperature = three_columns(std::move(columns.accel_temperature));
  std::vector<bool> saturated;
  mark_saturated(recording.gyro, source.gyro, saturated);
  mark_saturated(recording.accel, source.accel, saturated);
  for (std::size_t i = 0; i < saturated.size(); ++i)
    if (saturated[i]) recording.saturated.push_back(i);
  recording.gyro_increment = source.gyro.output == Output::increment;
  recording.accel_increment = source.accel.output == Output::increment;
  recording.gyro_unit = source.gyro.unit == "count" ? "count" : "rad/s";
  recording.accel_unit = source.accel.unit == "count" ? "count" : "m/s^2";
  to_si(recording.gyro, source.gyro, interval_s);
  to_si(recording.accel, source.accel, interval_s);
  return recording;
}

}  // namespace imulab
