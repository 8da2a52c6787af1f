#include "imulab/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/recording/origin.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <system_error>

namespace imulab {
namespace {

std::optional<std::array<double, 2>> range_of(const Columns3& columns) {
  std::array<double, 2> range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const auto& column : columns)
    for (const double value : column) range = {std::min(range[0], value), std::max(range[1], value)};
  return range[0] <= range[1] ? std::optional(range) : std::nullopt;
}

/// The topic of the gyros, where a file is a bag that has them; of a session that names none the only one of an IMU.
std::string bag_topic(const Session& session, const RecordingSource& source, const std::string& file) {
  const std::filesystem::path path = session_path(session, file);
  if (file != source.gyro.file.value_or(source.file) || is_stream(path) || is_kept(path) || bag::bag_format(path) == nullptr) return "";
  const std::string named = source.gyro.topic.value_or(source.topic);
  return named.empty() ? bag::choose_topic(bag::open_bag(path)->topics(), "", path.string()).name : named;
}

}  // namespace

void add_provenance(Calibration& calibration, const Session& session, std::span<const Recording> recordings) {
  if (recordings.size() != session.recordings.size())
    throw Error(fmt::format("{} recordings were given; the session declares {}", recordings.size(), session.recordings.size()));
  for (const Recording& r : recordings)
    if (r.size() == 0) throw Error(r.name + ": no samples; expected at least one");
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
