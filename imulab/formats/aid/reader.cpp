// Aids of a session -> records on the recording's clock.
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/recording/aid_clock.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {
namespace {

using namespace aid_io;

namespace fs = std::filesystem;

/// The file of an aid, or "FILE:TOPIC", or a topic of the recording's own log.
AidRequest request_of(const Aid& aid, const Session& session, const RecordingSource& source) {
  if (aid.file.empty())
    throw Error(fmt::format("[[aid]] of kind {} names no file; expected file = \"drive.pos\", or a topic of the recording", to_string(aid.kind)));
  std::error_code none;
  if (const fs::path file = session_path(session, aid.file); fs::exists(file, none)) return {file, aid.kind};
  if (const std::size_t colon = aid.file.find(':'); colon != std::string::npos)
    if (const fs::path file = session_path(session, aid.file.substr(0, colon)); fs::exists(file, none))
      return {file, aid.kind, aid.file.substr(colon + 1)};
  return {session_path(session, source.file), aid.kind, aid.file};
}

const AidFormat& aid_format_of(const AidRequest& request, const Aid& aid) {
  if (is_several_files(request.file)) {
    for (const AidFormat& format : aid_formats())
      if (format.recognizes_path != nullptr && format.recognizes_path(request.file)) return format;
  } else {
    const MappedFile file(request.file);
    for (const AidFormat& format : aid_formats())
      if (format.recognizes(file.text().substr(0, 4096)) && (request.topic.empty() || format.has_topics)) return format;
  }
  std::vector<std::string_view> names;
  for (const AidFormat& format : aid_formats()) names.push_back(format.name);
  throw Error(request.topic.empty() ? fmt::format("{}: unknown format of an aid; expected {}", input_name(request.file), text::listed(names))
                                    : fmt::format("{}: is no file beside the session, and {} has no topics; expected the aid's file", aid.file,
                                                  input_name(request.file)));
}

/// True for the recording's own log.
bool is_own_log(const AidRequest& request, const Session& session, const RecordingSource& source) {
  std::error_code none;
  return fs::equivalent(request.file, session_path(session, source.file), none);
}

/// With several recordings a file that is none of theirs has to say to which it belongs.
void expect_assigned(const Aid& aid, const AidRequest& request, const Session& session, const RecordingSource& source) {
  if (session.recordings.size() < 2 || !aid.recording.empty() || is_own_log(request, session, source)) return;
  throw Error(fmt::format("{}: goes with which of the {} recordings? expected recording = \"{}\" or another in its [[aid]]", aid.file,
                          session.recordings.size(), source.file));
}

/// Throws Error for a receiver that is somewhere else than the session says, where swapping its latitude and longitude brings it there.
void expect_at_site(const Aid& aid, const Session& session) {
  if (aid.record.position.empty()) return;
  const std::optional<double> latitude = session.initial ? std::optional(session.initial->latitude) : session.site.latitude;
  const std::optional<double> longitude = session.initial ? std::optional(session.initial->longitude) : session.site.longitude;
  if (!latitude || !longitude) return;
  constexpr double near = 2 * unit::deg;  // the length of a drive, but not of the way between two numbers that could be mistaken
  const Eigen::Vector3d& at = aid.record.position.front();
  const auto apart = [](double a, double b) { return std::abs(std::remainder(a - b, 360 * unit::deg)); };
  if (std::hypot(apart(at.x(), *latitude), apart(at.y(), *longitude)) > near &&
      std::hypot(apart(at.y(), *latitude), apart(at.x(), *longitude)) < near)
    throw Error(
        fmt::format("{}: begins at latitude {:.6f} deg and longitude {:.6f} deg, which the session has the other way round; expected them swapped",
                    aid.file, at.x() / unit::deg, at.y() / unit::deg));
}

/// The aids that go with a recording, with their records as they are stamped.
AidsReading stamped_aids(const Session& session, const RecordingSource& source) {
  AidsReading out;
  for (const Aid& declared : session.aids) {
    if (!declared.recording.empty() && declared.recording != source.file) continue;
    Aid& aid = out.aids.emplace_back(declared);
    if (!has_record(aid.kind) || !aid.record.time.empty()) continue;
    const AidRequest request = request_of(aid, session, source);
    expect_assigned(aid, request, session, source);
    const AidFormat& format = aid_format_of(request, aid);
    AidRows rows = format.read(request);
    aid.scale = rows.scale;
    if (format.has_topics && is_own_log(request, session, source)) {  // stamped by the clock of the recording's readings
      aid.scale = TimeScale::recording;
      for (AidRow& row : rows.rows) row.time -= source.time.zero;
    }
    AidReading reading = make_record(std::move(rows));
    aid.record = std::move(reading.record);
    out.warnings.insert(out.warnings.end(), reading.warnings.begin(), reading.warnings.end());
    expect_at_site(aid, session);
    if (session.recordings.size() > 1) aid.recording = source.file;
  }
  return out;
}

}  // namespace

AidsReading read_aids(const Session& session, const RecordingSource& source, const Recording& recording) {
  AidsReading out = stamped_aids(session, source);
  for (Aid& aid : out.aids) aid = on_recording_clock(std::move(aid), recording, source, out.warnings);
  return out;
}

std::optional<std::int64_t> gps_time_ahead(const Session& session, const RecordingSource& source, const Recording& recording) {
  std::vector<std::string> notes;
  for (const Aid& stamped : stamped_aids(session, source).aids) {
    if (stamped.record.time.empty() || (stamped.scale != TimeScale::gps && stamped.scale != TimeScale::utc)) continue;
    const Aid moved = on_recording_clock(stamped, recording, source, notes);
    if (moved.scale != TimeScale::recording) continue;
    const std::int64_t time = stamped.record.time.front(), second_ns = 1'000'000'000;
    const std::int64_t leap = stamped.scale == TimeScale::gps ? 0 : leap_seconds(1e-9 * static_cast<double>(time)) * second_ns;
    return time + leap - moved.record.time.front();
  }
  return std::nullopt;
}

}  // namespace imulab
