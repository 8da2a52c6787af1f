#include "imulab/tasks/fleet.hpp"

#include "imulab/core/shared_work.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet/store/part.hpp"
#include "imulab/fleet/store/store.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/tasks/calibrate.hpp"
#include "imulab/tasks/content.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <sys/stat.h>

namespace imulab {

namespace {

namespace fs = std::filesystem;

/// One session from its file to the store.
struct FleetItem {
  FleetSession hashed;
  std::optional<Session> session;
  std::optional<Calibration> calibration;
  FleetOccasion occasion;
  std::string failure;
  bool skipped = false, failed_before = false;
};

/// An exception of any step is the session's failure, unless the session is not its cause: a store that cannot be written, memory that ends.
template <class Work>
void attempt(FleetItem& item, const Work& work) {
  if (item.skipped || !item.failure.empty()) return;
  try {
    work();
  } catch (const fleet::DatabaseError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const Stopped&) {
    throw;
  } catch (const std::exception& e) {
    item.failure = e.what();
    if (item.failure.empty()) item.failure = "failed without a message";
  }
}

void calibrate_item(FleetItem& item, const FleetCalibrationTask& task) {
  Session session = std::move(*item.session);
  item.session.reset();
  expect_gravity(session, method(task.method));
  const SessionRecordings data = read_recordings(std::move(session));
  CalibrationResult result = calibrate(data, {.method = task.method, .terms = task.terms});
  Calibration& c = result.calibration;
  if (!c.quality.converged) throw Unsupported(shortcomings(result));
  add_provenance(c, data.session, data.recordings);
  for (const SourceFile& source : c.sources)
    for (const SourceFile& before : item.hashed.files)
      if (before.file == source.file && before.sha256 != source.sha256) throw Error(source.file + ": changed while it was read");
  c.options = {{"terms", task.terms}};
  c.quality.findings.prepend(Severity::warning, data.warnings);
  item.occasion = occasion_of(data.session, data.recordings, task.declared);
  item.calibration = std::move(c);
}

/// The task that parts of a fleet have in common: the options, and the list of all sessions by path and size. Each part opens and hashes its own
/// alone.
std::string identity_of(const std::vector<fs::path>& sessions, const FleetCalibrationTask& task) {
  std::string list;
  for (const fs::path& file : sessions) list += fmt::format("{}\n{}\n", file.string(), fs::file_size(file));
  return work_identity("fleet calibrate", {{"method", task.method},
                                           {"terms", task.terms},
                                           {"station", task.declared.station},
                                           {"operator", task.declared.operated_by},
                                           {"time", task.declared.time},
                                           {"sessions", fmt::format("{}", sessions.size())},
                                           {"list", sha256(list)}});
}

void store_item(FleetItem& item, const FleetRequest& request, FleetStore& store) {
  attempt(item, [&] { item.skipped = !store.add_calibration(*item.calibration, item.occasion, &item.hashed, &request); });
  if (!item.failure.empty()) store.add_failure(item.hashed, request, item.failure);
}

void count(const FleetItem& item, const FleetRequest& request, FleetCalibrationCounts& counts) {
  counts.failed_before += item.failed_before;
  counts.skipped += item.skipped && !item.failed_before;
  counts.calibrated += !item.skipped && item.failure.empty();
  if (item.failure.empty()) return;
  counts.failed += 1;
  counts.failures.push_back({item.hashed.file, request.method, request.options, item.failure, fleet::now()});
}

}  // namespace

namespace {

/// The session.toml of a folder and of all below it, also behind links. Each folder is entered once: behind a link only if no other way leads there.
std::vector<fs::path> sessions_in(const fs::path& place) {
  std::vector<fs::path> found, folders{place};
  std::set<fs::path> links, entered;  // in the order of their names; real paths
  std::error_code none;
  while (!folders.empty() || !links.empty()) {
    if (folders.empty()) folders.push_back(links.extract(links.begin()).value());
    const fs::path folder = folders.back();
    folders.pop_back();
    if (!entered.insert(fs::canonical(folder, none)).second) continue;
    for (const auto& entry : fs::directory_iterator(folder, fs::directory_options::skip_permission_denied)) {
      const bool below = entry.is_directory(none);
      if (below && entry.is_symlink(none))
        links.insert(entry.path());
      else if (below)
        folders.push_back(entry.path());
      else if (entry.path().filename() == "session.toml" && entry.is_regular_file(none))
        found.push_back(entry.path());
    }
  }
  return found;
}

}  // namespace

std::vector<fs::path> sessions_below(const std::vector<fs::path>& places) {
  std::vector<fs::path> out;
  std::set<fs::path> listed;  // by their folders' real paths: a link to one and the same session.toml may stand beside other recordings
  for (const fs::path& place : places) {
    std::vector<fs::path> found;
    if (fs::is_directory(place))
      found = sessions_in(place);
    else if (fs::exists(place))
      found = {place};
    if (found.empty()) throw Error(place.string() + ": no session; expected a folder with a session.toml in it or below it");
    for (fs::path& file : found) file = fs::absolute(file).lexically_normal();
    std::sort(found.begin(), found.end());
    std::ranges::copy_if(found, std::back_inserter(out),
                         [&](const fs::path& file) { return listed.insert(fs::canonical(file.parent_path()) / file.filename()).second; });
  }
  return out;
}

FleetSession fleet_session(const Session& session) {
  std::vector<std::pair<std::string, fs::path>> files;
  for (const RecordingSource& source : session.recordings)
    for (const std::string& file : source.files()) files.emplace_back(file, session_path(session, file));
  return hashed_session(session.file, session.sha256, files);
}

FleetOccasion occasion_of(const Session& session, const std::vector<Recording>& recordings, const FleetDeclaration& declared) {
  constexpr double earliest = 946684800, latest = 4102444800;  // of this century
  const auto said = [](const std::string& first, const std::optional<std::string>& other) { return first.empty() ? other.value_or("") : first; };
  FleetOccasion out{said(declared.station, session.station), said(session.operated_by.value_or(""), declared.operated_by), 0, "file"};
  if (const std::string time = said(declared.time, session.measured); !time.empty()) {
    out.time = parse_time(time);
    out.time_from = "declared";
    return out;
  }
  const bool clock = !recordings.empty() && !session.recordings.empty() && session.recordings.front().time.unit.ends_with('s');  // s, ms, us, ns
  if (clock && recordings.front().size() > 0) {
    const double stamp = 1e-9 * static_cast<double>(session.recordings.front().time.zero) + recordings.front().time_s(0);
    if (stamp >= earliest && stamp < latest) {
      out.time = stamp;
      out.time_from = "stamps";
      return out;
    }
  }
  struct stat status {};
  const fs::path file = session.recordings.empty() ? fs::path(session.file) : session_path(session, *session.recordings.front().files().begin());
  if (::stat(file.c_str(), &status) == 0) out.time = static_cast<double>(status.st_mtime);
  return out;
}

FleetCalibrationCounts calibrate_fleet(const std::vector<fs::path>& sessions, const FleetCalibrationTask& task, FleetStore& store) {
  const FleetRequest request{task.method, "terms=" + task.terms};
  if (!task.declared.time.empty()) errors_at("--measured", [&] { parse_time(task.declared.time); });
  FleetCalibrationCounts counts{.sessions = static_cast<std::int64_t>(sessions.size()), .failures = {}};
  std::mutex one;  // of the store
  const BlockRange range = task.part ? blocks_of(*task.part, sessions.size()) : BlockRange{0, sessions.size()};
  if (task.part)
    fleet::begin_part(store, *task.part, identity_of(sessions, task));
  else
    fleet::expect_no_part(store);
  std::vector<std::unique_ptr<FleetItem>> items(range.size());  // on their way into the store
  counts.sessions = static_cast<std::int64_t>(range.size());
  SharedWork own{.count = range.size(), .work = {}, .take = {}};
  own.work = [&](std::size_t at) -> std::string {
    FleetItem& item = *(items[at] = std::make_unique<FleetItem>());
    item.hashed.file = sessions[range.begin + at].string();
    attempt(item, [&] {
      item.session = read_session(item.hashed.file);
      item.hashed = fleet_session(*item.session);
      const std::lock_guard lock(one);
      const FleetStore::Known known = store.known(item.hashed, request);
      item.failed_before = known == FleetStore::Known::failed && !task.retry;
      item.skipped = known == FleetStore::Known::calibrated || item.failed_before;
    });
    attempt(item, [&] { calibrate_item(item, task); });
    return "";
  };
  own.take = [&](std::size_t at, const std::string&) {  // in the order of the sessions
    const std::unique_ptr<FleetItem> item = std::move(items[at]);
    const std::lock_guard lock(one);
    store_item(*item, request, store);
    count(*item, request, counts);
  };
  if (task.progress) own.progress = [&](std::size_t done) { task.progress(static_cast<double>(done), static_cast<double>(range.size())); };
  for_each(own);
  if (task.part) fleet::end_part(store);
  return counts;
}

std::string add_to_fleet(const fs::path& file, const std::string& unit, const FleetDeclaration& declared, FleetStore& store) {
  fleet::expect_no_part(store);
  const auto result = [](const char* what, bool added) { return std::string(what) + (added ? "" : " (known)"); };
  if (fs::is_directory(file) || file.extension() == ".toml") {
    const Session session = read_session(fs::absolute(file).lexically_normal());
    return errors_at(file.string(), [&] {
      return result("session",
                    store.add_session(fleet_session(session), session.imu.serial.value_or(""), session.imu.name, occasion_of(session, {}, declared)));
    });
  }
  const std::string name = input_name(file);
  const std::string text(MappedFile(file, Content::settings).text());
  FleetOccasion occasion{declared.station, declared.operated_by, fleet::now(), "added"};
  if (!declared.time.empty()) occasion.time = parse_time(declared.time), occasion.time_from = "declared";
  if (text.find("\"imulab.noise/1\"") != std::string::npos) {
    parse_noise(text, name);
    if (unit.empty()) throw Error(name + ": says nothing of its unit; expected --unit with a serial number");
    const FleetUnit of = store.unit(unit);
    return result("noise", store.add_noise(text, of.serial, of.name, occasion));
  }
  const Calibration calibration = parse_calibration(text, name);
  if (!calibration.operated_by.empty()) occasion.operated_by = calibration.operated_by;
  if (occasion.station.empty()) occasion.station = calibration.station;
  if (declared.time.empty() && !calibration.measured.empty())
    errors_at(name + ": measured", [&] { occasion.time = parse_time(calibration.measured), occasion.time_from = "declared"; });
  else if (declared.time.empty() && !calibration.created.empty())
    errors_at(name + ": created", [&] { occasion.time = parse_time(calibration.created), occasion.time_from = "created"; });
  return errors_at(name, [&] { return result("calibration", store.add_calibration(calibration, occasion)); });
}

}  // namespace imulab
