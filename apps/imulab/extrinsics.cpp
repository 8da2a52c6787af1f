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
#include "imulab/tasks/usable.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <utility>

namespace imulab::command {
namespace {

/// An IMU, its path on the command line, and what declares its recording.
struct GivenImu {
  BodyImu imu;
  std::string path;
  RecordingSource source;
};

void add(std::vector<GivenImu>& all, const Session& session, const RecordingSource& source, const std::string& name, const std::string& path,
         const ExtrinsicsOptions& o) {
  RecordingReading reading = read_recording(session, source);
  for (const std::string& warning : reading.warnings) warn(name + ": " + warning);
  all.push_back({{.name = name,
                  .recording = std::move(reading.recording),
                  .grade = o.grade.value_or(session.imu.grade.value_or("mems")),
                  .clock_zero_ns = source.time.zero_ns()},
                 path,
                 source});
}

/// The IMUs of a session, a recording each; or of a log, one or one for each of its topics.
void add_imus(std::vector<GivenImu>& all, const std::string& path, const ExtrinsicsOptions& o) {
  const auto open = [&](const std::vector<std::string>& topics) {
    return open_session(path, {o.declarations, topics}, numbers_inspected, Purpose::compensation);
  };
  const auto stem = [](const std::string& file) { return std::filesystem::path(file).stem().string(); };
  if (declares_itself(path)) {
    const Session session = open({});
    for (const RecordingSource& source : session.recordings) add(all, session, source, source.imu.empty() ? stem(source.file) : source.imu, path, o);
    return;
  }
  const std::vector<std::vector<std::string>> topics = imus_of(path);
  for (const std::vector<std::string>& own : topics.empty() ? std::vector<std::vector<std::string>>{{}} : topics) {
    const Session session = open(own);
    add(all, session, session.recordings.front(), own.empty() ? stem(path) : fmt::format("{}", fmt::join(own, " and ")), path, o);
  }
}

/// Equal names, of files in several folders or of topics in several logs, are told apart by their paths.
void make_names_different(std::vector<GivenImu>& all) {
  std::map<std::string, int> names, paths;
  for (const GivenImu& given : all) ++names[given.imu.name], ++paths[given.path];
  for (GivenImu& given : all)
    if (names[given.imu.name] > 1) given.imu.name = paths[given.path] > 1 ? given.path + ": " + given.imu.name : given.path;
}

/// One calibration for each IMU, in their order, or the word none.
void take_calibrations(std::vector<GivenImu>& all, const std::vector<std::string>& files) {
  if (files.empty()) return;
  std::vector<std::string> names;
  for (const GivenImu& given : all) names.push_back(given.imu.name);
  if (files.size() != all.size())
    throw OptionError("calibration", fmt::format("given {} times; expected one for each of {} IMUs, in the order of {}; none: without one",
                                                 files.size(), all.size(), fmt::join(names, ", ")));
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (files[k] == "none") continue;
    all[k].imu.calibration = read_usable(files[k], false, "--calibration none").calibration;
    check_thermal_units(*all[k].imu.calibration, all[k].source);
  }
}

void run(const ExtrinsicsOptions& o) {
  std::vector<GivenImu> given;
  for (const std::string& path : recordings_named(o.recordings)) add_imus(given, path, o);
  make_names_different(given);
  take_calibrations(given, o.calibrations);
  if (given.size() == 1 && !(o.output.empty() && o.report.empty()))
    throw Error("--output, --report: belong to several IMUs; of one, extrinsics predicts uncertainties alone");
  std::vector<BodyImu> imus;
  for (GivenImu& each : given) imus.push_back(std::move(each.imu));
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
