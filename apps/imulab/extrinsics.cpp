// imulab extrinsics RECORDING...
#include "imulab/tasks/extrinsics.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/tasks/inspect.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <utility>

namespace imulab::command {
namespace {

/// The IMUs of a session: a recording each.
void add_imus_of_session(std::vector<BodyImu>& imus, const std::string& path, const ExtrinsicsOptions& o) {
  const Session session = open_session(path, {o.declarations}, numbers_inspected, Purpose::compensation);
  for (const RecordingSource& source : session.recordings) {
    const std::string name = !source.imu.empty() ? source.imu : std::filesystem::path(source.file).stem().string();
    imus.push_back(body_imu(session, source, name, o, warn));
  }
}

/// The IMUs of a log: one, or one for each of its topics.
void add_imus_of_log(std::vector<BodyImu>& imus, const std::string& path, const ExtrinsicsOptions& o) {
  std::vector<std::vector<std::string>> topics = imus_of(path);
  const bool several = !topics.empty();
  if (!several) topics.emplace_back();
  for (const std::vector<std::string>& own : topics) {
    const Session session = open_session(path, {o.declarations, own}, numbers_inspected, Purpose::compensation);
    const std::string name = several ? fmt::format("{}", fmt::join(own, " and ")) : std::filesystem::path(path).stem().string();
    imus.push_back(body_imu(session, session.recordings.front(), name, o, warn));
  }
}

/// Files of one name in several folders are told apart by their folders.
void make_names_different(std::vector<BodyImu>& imus, const std::vector<std::string>& paths) {
  std::map<std::string, int> count;
  for (const BodyImu& imu : imus) ++count[imu.name];
  if (imus.size() != paths.size()) return;
  for (std::size_t k = 0; k < imus.size(); ++k)
    if (count[imus[k].name] > 1) imus[k].name = paths[k];
}

void run(const ExtrinsicsOptions& o) {
  std::vector<BodyImu> imus;
  const std::vector<std::string> paths = recordings_named(o.recordings);
  for (const std::string& path : paths) declares_itself(path) ? add_imus_of_session(imus, path, o) : add_imus_of_log(imus, path, o);
  make_names_different(imus, paths);
  take_calibrations(imus, o);
  const auto answer = [&] {
    Progress progress("finding extrinsics");
    return extrinsics_answer(imus, [&progress](double part) { progress.report(part); });
  }();
  if (!o.output.empty()) write_whole(o.output, answer.document());
  show(answer, o, "\n" + written_text(o.output) + "\n");
}

}  // namespace

void add_extrinsics(Verb& app) { add<ExtrinsicsOptions>(app, run); }

}  // namespace imulab::command
