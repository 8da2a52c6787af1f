#include "imulab/recording/origin.hpp"

#include <array>
#include <ctime>
#include <optional>

namespace imulab {
namespace {

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::array<char, 32> text;
  std::tm utc{};
  gmtime_r(&now, &utc);  // calibrations run in several threads
  const std::size_t size = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return {text.data(), size};
}

RecordedAs recorded_as(const TriadSource& source, double interval_s) {
  RecordedAs out{source.unit, source.counts_per_unit.value_or(1), source.output == Output::increment ? interval_s : 0};
  if (source.axes)
    for (std::size_t i = 0; i < 3; ++i) out.axes[i] = {(*source.axes)[i].sign > 0 ? '+' : '-', "xyz"[(*source.axes)[i].index]};
  return out;
}

/// The form that all recordings share, or nothing: a program for the IMU has one kind of readings. A live stream is declared without being a
/// recording.
std::optional<RecordedAs> recorded_as(const Session& session, std::span<const Recording> recordings, TriadSource RecordingSource::*triad) {
  std::optional<RecordedAs> common;
  for (std::size_t k = 0; k < session.recordings.size(); ++k) {
    const RecordingSource& source = session.recordings[k];
    const bool gyro = triad == &RecordingSource::gyro;
    if (k < recordings.size() && (gyro ? recordings[k].gyro : recordings[k].accel)[0].empty()) return std::nullopt;  // it has no such triad
    const double interval_s = k < recordings.size() ? recordings[k].interval_s : source.rate_hz ? 1 / *source.rate_hz : 0;
    if ((source.*triad).output == Output::increment && !(interval_s > 0)) return std::nullopt;
    const RecordedAs one = recorded_as(source.*triad, interval_s);
    if (common && one != *common) return std::nullopt;
    common = one;
  }
  return common;
}

}  // namespace

std::string software() { return "imulab " IMULAB_VERSION; }

void add_declared_origin(Calibration& calibration, const Session& session, std::span<const Recording> recordings) {
  calibration.serial = session.imu.serial.value_or("");
  calibration.operated_by = session.operated_by.value_or("");
  calibration.station = session.station.value_or("");
  calibration.measured = session.measured.value_or("");
  calibration.firmware = session.imu.firmware.value_or("");
  calibration.filter = session.imu.filter.value_or("");
  calibration.valid_until = session.valid_until.value_or("");
  calibration.warm_up = session.warm_up.value_or("");
  calibration.power_cycles = session.power_cycles.value_or("");
  calibration.references = session.references;
  calibration.created = utc_now();
  calibration.software = software();
  calibration.session_file = session.file;
  calibration.session_sha256 = session.sha256;
  calibration.recorded_accel = recorded_as(session, recordings, &RecordingSource::accel);
  calibration.recorded_gyro = recorded_as(session, recordings, &RecordingSource::gyro);
}

}  // namespace imulab
