#include "imulab/files.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/several_files.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <limits>
#include <set>
#include <system_error>

namespace imulab {
namespace {

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::array<char, 32> text;
  const std::size_t size = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&now));
  return {text.data(), size};
}

std::optional<std::array<double, 2>> range_of(const Columns3& columns) {
  std::array<double, 2> range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const auto& column : columns)
    for (const double value : column) range = {std::min(range[0], value), std::max(range[1], value)};
  return range[0] <= range[1] ? std::optional(range) : std::nullopt;
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

/// The topic of the gyros, where a file is a bag that has them; of a session that names none the only one of an IMU.
std::string bag_topic(const Session& session, const RecordingSource& source, const std::string& file) {
  const std::filesystem::path path = session_path(session, file);
  if (file != source.gyro.file.value_or(source.file) || is_stream(path) || is_kept(path) || bag::bag_format(path) == nullptr) return "";
  const std::string named = source.gyro.topic.value_or(source.topic);
  return named.empty() ? bag::choose_topic(bag::open_bag(path)->topics(), "", path.string()).name : named;
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

void add_provenance(Calibration& calibration, const Session& session, std::span<const Recording> recordings) {
  add_declared_origin(calibration, session, recordings);
  calibration.sources.clear();
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const Recording& r = recordings[k];
    for (const std::string& file : session.recordings[k].files()) {
      const FileSum sum = file_sum(session_path(session, file));
      calibration.sources.push_back({file, sum.sha256, sum.bytes, r.time_s(0), r.time_s(r.size() - 1), range_of(r.accel_temperature),
                                     range_of(r.gyro_temperature), bag_topic(session, session.recordings[k], file)});
    }
  }
}

std::vector<VerifiedFile> verify_sources(const Calibration& calibration, const std::filesystem::path& session) {
  std::vector<VerifiedFile> out;
  const auto check = [&](const std::filesystem::path& file, const std::string& recorded) {
    std::error_code none;
    if (!is_several_files(file) && !std::filesystem::exists(file, none)) {
      out.push_back({file, FileState::missing});
      return;
    }
    out.push_back({file, file_sum(file).sha256 == recorded ? FileState::unchanged : FileState::changed});
  };
  check(session, calibration.session_sha256);
  for (const SourceFile& source : calibration.sources) {
    const bool own_session = source.sha256 == calibration.session_sha256;  // a recording that was inspected
    check(own_session ? session : session.parent_path() / source.file, source.sha256);
  }
  return out;
}

}  // namespace imulab
