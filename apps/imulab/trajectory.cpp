// imulab trajectory MISSION -o FOLDER
#include "imulab/tasks/trajectory.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/session/mission.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/results/navigation.hpp"

#include <fmt/core.h>

#include <memory>

namespace imulab::command {

namespace {

struct Arguments {
  std::string mission, folder;
  std::optional<std::string> unit;
  bool errors = false, json = false;
  std::uint64_t seed = 1;
};

void make(const Arguments& a) {
  const MissionFile file = read_mission(a.mission);
  for (const std::filesystem::path& named : file.files) will_read(named);
  TrajectoryTask task{.mission = a.mission, .errors = a.errors, .seed = a.seed};
  if (a.unit) task.unit = read_calibration(*a.unit);
  const FlownMission flown = [&] {
    Progress progress("flying");
    task.progress = [&progress](double part) { progress.report(part); };
    return fly(file, task);
  }();
  for (const std::string& text : flown.warnings) warn(text);
  write_flown(a.folder, flown);
  const Recording& recording = flown.recording;
  const Solution& solution = flown.truth;
  if (a.json)
    return print_json(fields_json({{{"folder", a.folder},
                                    {"samples", std::uint64_t{recording.size()}},
                                    {"duration_s", solution.time.back()},
                                    {"rate_hz", file.mission.rate},
                                    {"truth_rows", std::uint64_t{solution.size()}}}}));
  print(fmt::format("{}\n", a.folder));
  print(fmt::format("  recording.csv  {} samples, {:.10g} s at {:g} Hz\n", recording.size(), solution.time.back(), file.mission.rate));
  print(fmt::format("  truth.csv      {} rows\n  session.toml\n", solution.size()));
  print(motion_table(recording, solution));
}

}  // namespace

void add_trajectory(Verb app) {
  const auto a = std::make_shared<Arguments>();
  Verb verb = app.verb("trajectory", "Simulate an ideal IMU on a mission: write a session folder with truth.csv");
  verb.option("mission", a->mission, "the mission file: segments, or a recorded track").required().reads();
  verb.option("-o,--output FOLDER", a->folder, "the folder to create").required().creates();
  const Option errors = verb.flag("--errors", a->errors, "give the IMU the errors of the mission's [errors] table");
  verb.option("--unit FILE", a->unit, "truth.json or calibration.json of an IMU: write its raw readings, with the noise of [errors]")
      .reads()
      .excludes(errors);
  verb.option("--seed", a->seed, "random seed of errors and noise; the same seed gives the same result").show_default();
  verb.flag("--json", a->json, "print what was written as JSON");
  verb.example("imulab trajectory flight.toml -o flight");
  verb.does([a] { make(*a); });
}

}  // namespace imulab::command
