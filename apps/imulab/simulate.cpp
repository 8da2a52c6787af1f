// imulab simulate PROCEDURE -o FOLDER
#include "imulab/tasks/simulate.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/formats/text/json.hpp"

#include <fmt/core.h>

#include <memory>

namespace imulab::command {

namespace {

struct Arguments {
  std::string procedure, folder;
  std::optional<std::string> unit, grade;
  std::uint64_t seed = 1;
  bool json = false;
};

void simulate(const Arguments& a) {
  Session procedure = session_at(a.procedure);
  const std::string file = procedure.file;
  SimulationTask task{.seed = a.seed, .unit = {}, .grade = a.grade};
  if (a.unit) task.unit = read_calibration(*a.unit);
  const Simulation simulated = [&] {
    const Progress progress("simulating");
    Simulation done = errors_at(file, [&] { return simulate_session(std::move(procedure), task); });
    write_simulated(a.folder, done);
    return done;
  }();
  std::string report;
  std::vector<JsonFields> files;
  for (const Recording& recording : simulated.recordings) {
    const double duration = recording.time_s(recording.size() - 1);
    report += fmt::format("  {:<14} {} samples, {:g} s\n", recording.name, recording.size(), duration);
    files.push_back({{{"file", recording.name}, {"samples", std::uint64_t{recording.size()}}, {"duration_s", duration}}});
  }
  if (a.json) return print_json(fields_json({{{"folder", a.folder}, {"seed", a.seed}, {"recordings", files}, {"truth", std::string("truth.json")}}}));
  print(fmt::format("{} (seed {})\n{}  {:<14} what a calibration of this session should find\n  session.toml\n", a.folder, a.seed, report,
                    "truth.json"));
}

}  // namespace

void add_simulate(Verb app) {
  const auto a = std::make_shared<Arguments>();
  Verb verb = app.verb("simulate", "Simulate a procedure: write a session folder with recordings and truth.json");
  verb.option("procedure", a->procedure, "the procedure or session to carry out").required().reads();
  verb.option("-o,--output FOLDER", a->folder, "the folder to create").required().creates();
  verb.option("--unit FILE", a->unit, "truth.json or calibration.json of the IMU to simulate, in place of the procedure's");
  verb.option("--grade GRADE", a->grade, "a grade by its name, or noise.json: the noise of a log at rest, in place of the procedure's");
  verb.option("--seed", a->seed, "random seed; the same seed gives the same result").show_default();
  verb.flag("--json", a->json, "print what was written as JSON");
  verb.example("imulab simulate procedure.toml -o session --seed 7");
  verb.does([a] { simulate(*a); });
}

}  // namespace imulab::command
