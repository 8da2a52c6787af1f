#include "imulab/tasks/inspect.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/memory.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/join.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

namespace imulab {

Inspection inspect_files(const InspectionTask& task) {
  inspection::check_declarations(task.declared);
  for (const std::string& file : task.files)
    if (std::filesystem::path(file).extension() == ".toml")
      throw Error(file + ": is a session or other settings; expected a recording, as a session names one");
  std::vector<SignalTable> tables;
  for (const std::string& file : task.files)
    for (const std::string& topic : task.topics.empty() ? std::vector<std::string>{""} : task.topics)
      tables.push_back(read_signals(file, topic, recording_formats(), task.longest_s, task.most_numbers));
  return inspect(inspection::joined(std::move(tables), task.declared), task.declared);
}

InspectedRecording inspect_and_read(const InspectionTask& task) {
  const Site site = declared_site(task.declared);
  Inspection found = inspect_files(task);
  Session session = inspected_session(found, site);
  session.file = task.files.front();  // its folder is that of the recording
  InspectedRecording out{std::move(found), std::move(session), {}};
  if (!out.inspection.complete() || is_stream(out.session.file)) return out;
  out.session.sha256 = file_sum(out.session.file).sha256;
  give_back_freed_memory();  // of the tables that were inspected
  try {
    RecordingReading reading = read_recording(out.session, out.session.recordings.front());
    for (std::string& text : reading.warnings) out.inspection.evidence.push_back(std::move(text));
    out.recording = std::move(reading.recording);
    const Recording& whole = *out.recording;  // of a long one only the first rows were inspected
    out.inspection.rows = std::max(out.inspection.rows, whole.size());
    out.inspection.duration_s = std::max(out.inspection.duration_s, whole.time_s(whole.size() - 1) - whole.time_s(0));
  } catch (const Error& e) {
    out.inspection.problems.emplace_back(e.what());
  }
  return out;
}

Session session_for(const Inspection& inspection, const InspectionTask& task, const std::string& hint) {
  const std::string& file = task.files.front();
  if (!inspection.problems.empty()) throw Error(fmt::format("{}: {}", file, inspection.problems.front()));
  if (!inspection.complete())
    throw Unsupported(
        fmt::format("{}: the data do not answer every question about it; {}:\n  {}", file, hint, fmt::join(inspection.ambiguous, "\n  ")));
  Session session = inspected_session(inspection, declared_site(task.declared));
  session.file = file;
  session.sha256 = file_sum(file).sha256;
  return session;
}

std::string assumed_gravity(const Session& session) {
  if (session.site.latitude || !session.site.given_gravity_sigma) return "";
  return fmt::format("gravity {} +/- {} m/s^2, as anywhere on Earth", *session.site.given_gravity, *session.site.given_gravity_sigma);
}

}  // namespace imulab
