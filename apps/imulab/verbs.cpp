// The verbs whose work is one task: they read their files, call the task, write its files and show its answer.
#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/report/imus_page.hpp"
#include "imulab/results/calibration.hpp"
#include "imulab/results/conclusion.hpp"
#include "imulab/tasks/budget.hpp"
#include "imulab/tasks/calibrate.hpp"
#include "imulab/tasks/compare.hpp"
#include "imulab/tasks/drive_plan.hpp"
#include "imulab/tasks/inspect.hpp"
#include "imulab/tasks/plan.hpp"
#include "imulab/tasks/predict.hpp"
#include "imulab/tasks/procedures.hpp"
#include "imulab/tasks/simulate.hpp"
#include "imulab/tasks/trajectory.hpp"
#include "imulab/tasks/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

namespace imulab::command {

namespace {

/// Shows the progress of work, which reports the fraction done to the function that it gets.
template <class Work>
auto with_progress(const char* label, const Work& work) {
  Progress progress(label);
  return work([&progress](double part) { progress.report(part); });
}

/// Shows the answer of a verb whose output is a folder or files: standard output is for the answer.
void show_besides_files(const Answer& answer, ShowOptions o) {
  o.output.clear();
  show(answer, o);
}

/// Does the work of a verb, or a part of it: that is written to -o in place of the answer.
template <class Work>
void by_part(const SharingOptions& shared, const ShowOptions& o, const Work& work) {
  std::filesystem::path file = o.output;
  const bool automatic = shared.part.starts_with("auto");
  if (!shared.part.empty()) {
    if (file.empty() || file == "-") throw OptionError("part", shared.part + "; expected -o with the file of the part");
    if (o.json || !o.report.empty()) throw OptionError("part", shared.part + "; --json and --report are of imulab join, which has the whole");
    if (automatic) std::filesystem::create_directories(file);
  }
  try {
    work();
  } catch (const PartIsDone& done) {
    if (automatic) file /= done.part->name();
    write_whole(file, done.part->bytes());
    print(fmt::format("{}\nwritten: {}\n", done.part->summary(), one_line(file.string())));
  }
}

/// A procedure's name stands for no file.
void expect_file_of_procedure(const std::string& name) {
  std::error_code none;
  if (std::filesystem::exists(name, none)) return;
  for (const StandardProcedure& standard : standard_procedures())
    if (standard.name == name)
      throw Error(fmt::format("{0}: is a procedure's name; expected its file, which imulab procedure {0} -o {0}.toml writes", name));
}

// imulab calibrate SESSION

/// One of several IMUs: its topics in a log, or its name in a session.
struct OneOfSeveral {
  std::vector<std::string> topics;
  std::string imu = {};

  std::string name() const { return imu.empty() ? fmt::format("{}", fmt::join(topics, " and ")) : imu; }
};

/// Reads and calibrates one IMU. `imu`: of a session's recordings those of this IMU, if they are named.
CalibratedImu calibrated(const CalibrateOptions& o, CalibrationTask task, const std::vector<std::string>& paths, const std::string& imu = "") {
  Session session = open_sessions(paths, {o.declarations, o.topics});
  if (!imu.empty()) {
    std::erase_if(session.recordings, [&](const RecordingSource& source) { return source.imu != imu && source.imu != o.reference.value_or(imu); });
    session.imu.name = imu;
  }
  expect_gravity(session, method(o.method));
  if (!o.recording.empty()) named_recording(session, o.recording);
  const auto data = with_progress("reading", [&](const auto&) {
    return std::make_shared<const SessionRecordings>(read_recordings(std::move(session), o.recording, task.reference.has_value()));
  });
  warn_each(data->warnings);
  return with_progress("calibrating", [&](const auto& report) {
    task.progress = report;
    return calibrated_imu(data, o, task, true);
  });
}

/// Writes an IMU's files, and shows its result. Returns its verdict.
Verdict write_and_show(CalibratedImu imu, const CalibrateOptions& o) {
  const auto answer = calibration_answer(std::move(imu));
  if (!o.output.empty()) write_whole(o.output, answer.json());
  if (!o.curves.empty()) write_whole(o.curves, curves_csv(*answer.data));
  show(answer, o, "\n" + written_text(o.output) + "\n");
  return answer.conclusion.verdict;
}

/// "c-1.json" of c.json.
std::string numbered(const std::string& file, std::size_t n) {
  if (file.empty()) return file;
  const std::filesystem::path path(file);
  return (path.parent_path() / fmt::format("{}-{}{}", path.stem().string(), n, path.extension().string())).string();
}

/// The IMUs that a session's recordings name, if they name several.
std::vector<OneOfSeveral> imus_of_session(const std::string& path) {
  std::vector<OneOfSeveral> out;
  for (const RecordingSource& source : session_at(path).recordings)
    if (std::ranges::find(out, source.imu, &OneOfSeveral::imu) == out.end()) out.push_back({{}, source.imu});
  if (out.size() > 1 && std::ranges::find(out, "", &OneOfSeveral::imu) != out.end())
    throw Error(path + ": some recordings name their IMU and others do not; expected imu = \"NAME\" in all of them, or in none");
  return out.size() > 1 ? out : std::vector<OneOfSeveral>{};
}

/// Each IMU of one log or session: a calibration each, jointly where they are on one body, and one page.
void calibrate_each(const CalibrateOptions& o, const CalibrationTask& task, const std::string& log, const std::vector<OneOfSeveral>& imus) {
  const std::string_view choice = imus.front().imu.empty() ? "--topic" : "--recording";
  if (o.json || o.output == "-") throw Error(fmt::format("{}: has {} IMUs, and --json and -o - are for one; expected {}", log, imus.size(), choice));
  note(fmt::format("{}: has {} IMUs; {} takes one alone", log, imus.size(), choice));
  struct Attempt {
    CalibrateOptions options;
    std::optional<CalibratedImu> done;
    std::string problem = {};
  };
  std::vector<Attempt> attempts;
  bool failed = false, short_of = false;
  for (std::size_t k = 0; k < imus.size(); ++k) {
    Attempt& attempt = attempts.emplace_back(Attempt{o, {}});
    CalibrateOptions& own = attempt.options;
    own.topics = imus[k].topics, own.report.clear(), own.output = numbered(o.output, k), own.curves = numbered(o.curves, k);
    for (const auto& [option, file] : {std::pair{"--output", own.output}, {"--curves", own.curves}})
      if (!file.empty()) expect_free(option, file), will_write(option, file);
    try {
      attempt.done = calibrated(own, task, {log}, imus[k].imu);
    } catch (const Unsupported& e) {
      attempt.problem = e.what(), short_of = true;
    } catch (const Error& e) {
      attempt.problem = e.what(), failed = true;
    }
  }
  std::vector<std::pair<std::string, CalibratedImu*>> several;
  for (std::size_t k = 0; k < imus.size(); ++k)
    if (attempts[k].done) several.emplace_back(imus[k].name(), &*attempts[k].done);
  const std::size_t jointly = with_progress("estimating jointly", [&](const auto& report) { return estimate_jointly(several, report); });

  std::vector<NamedCalibration> all;
  std::vector<std::string> missing, unlike;
  for (std::size_t k = 0; k < imus.size(); ++k) {
    Attempt& attempt = attempts[k];
    const std::string name = imus[k].name();
    print(fmt::format("{}IMU {} of {}: {}\n\n", k == 0 ? "" : "\n", k, imus.size(), one_line(name)));
    if (attempt.done) all.push_back({name, attempt.done->result.calibration});
    if (!attempt.done) missing.push_back(name), complain(attempt.problem);
    bool good = false;
    try {
      good = attempt.done && is_favorable(write_and_show(std::move(*attempt.done), attempt.options));
    } catch (const Unsupported& e) {
      complain(e.what());
      short_of = true;
    } catch (const Error& e) {
      complain(e.what());
      failed = true;
    }
    if (!good) unlike.push_back(name);
  }
  if (!o.report.empty()) write_whole(o.report, imus_page(log, all, missing));
  const std::string together = jointly == imus.size() ? ", estimated jointly"
                               : jointly > 0          ? fmt::format(", {} of them estimated jointly", jointly)
                                                      : "";
  const std::string those = unlike.empty() ? "all good" : fmt::format("not good: {}", fmt::join(unlike, ", "));
  print("\n" + text::wrapped("", fmt::format("{} IMUs{}: {}", imus.size(), together, those)));
  if (failed) throw Error(fmt::format("not every IMU of {} could be calibrated", log));
  if (short_of) throw Unsupported(fmt::format("not every IMU of {} has the calibration that was asked for", log));
}

void run(const CalibrateOptions& o) {
  const CalibrationTask task = task_of(o);  // wrong options are reported before anything is read
  std::vector<std::string> paths{o.session};
  paths.insert(paths.end(), o.more.begin(), o.more.end());
  paths = recordings_named(paths);
  if (paths.size() == 1 && o.topics.empty() && o.recording.empty() && paths.front() != "-") {
    std::vector<OneOfSeveral> imus;
    if (declares_itself(paths.front()))
      imus = imus_of_session(paths.front());
    else
      for (std::vector<std::string>& topics : imus_of(paths.front())) imus.push_back({std::move(topics)});
    if (o.reference && std::erase_if(imus, [&](const OneOfSeveral& each) { return each.name() == *o.reference; }) == 0)
      throw OptionError("reference", fmt::format("{}: {} has no IMU of this name; expected imu = \"{}\" in a [[recording]] of a session",
                                                 *o.reference, paths.front(), *o.reference));
    if (o.reference && imus.size() == 1) return static_cast<void>(write_and_show(calibrated(o, task, paths, imus.front().imu), o));
    if (!imus.empty()) return calibrate_each(o, task, paths.front(), imus);
  }
  write_and_show(calibrated(o, task, paths), o);
}

// imulab compare CALIBRATION CALIBRATION|TRUTH...

bool same_file(const std::string& a, const std::string& b) {
  std::error_code none;  // a file that does not exist is refused when it is read
  return a == b || std::filesystem::equivalent(a, b, none);
}

void check_files_differ(const std::vector<std::string>& files) {
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (same_file(files[i], files[j]))
        throw Error(fmt::format("{}: the same file as {}; a comparison takes the errors as independent; expected different calibrations", files[i],
                                files[j]));
}

/// A fleet's statistics use the calibrations of one unit over time, and say what drifts.
constexpr std::size_t many_calibrations = 10;

void run(const CompareOptions& o) {
  check_files_differ(o.files);
  std::vector<NamedResult> results;
  for (const std::string& file : o.files) results.push_back({input_name(file), read_answer(file).result});
  const auto is_calibration = [](const NamedResult& r) { return std::holds_alternative<Calibration>(r.result); };
  if (std::none_of(results.begin(), results.end(), is_calibration)) {
    if (o.tolerance || o.different_imus) throw Error("--tolerance, --different-imus: belong to calibrations");
    return show(result_comparison_answer(results), o);
  }
  std::vector<NamedCalibration> inputs;
  for (NamedResult& r : results) {
    if (!is_calibration(r)) throw Error(fmt::format("{}: is a {}; expected calibrations alone, or other results alone", r.name, kind_name(r.result)));
    inputs.push_back({std::move(r.name), std::get<Calibration>(std::move(r.result))});
  }
  if (inputs.size() > many_calibrations)
    note(fmt::format("{} calibrations: imulab fleet keeps them in a store, with drift, spread and outliers (imulab fleet add FILE...)",
                     inputs.size()));
  show(comparison_answer(std::move(inputs), o.different_imus, o.tolerance), o);
}

// imulab verify CALIBRATION

void run(const VerifyOptions& o) {
  const auto answer = with_progress("verifying", [&](const auto&) { return verify(o); });
  show(answer, o);
}

// imulab simulate PROCEDURE -o FOLDER

void run(const SimulateOptions& o) {
  expect_file_of_procedure(o.procedure);
  Session procedure = session_at(o.procedure);
  SimulationTask task{.seed = o.seed, .unit = {}, .grade = o.grade};
  if (o.unit) task.unit = read_calibration(*o.unit);
  const auto answer = with_progress("simulating", [&](const auto&) { return simulation_answer(std::move(procedure), task, o.output); });
  show_besides_files(answer, o);
}

// imulab predict PROCEDURE

void run(const PredictOptions& o) {
  PredictionOptions task = task_of(o);
  expect_file_of_procedure(o.procedure);
  const ReadProcedure read = read_procedure(o.procedure, o.method);
  will_read_files_of(read.session);
  warn_each(read.warnings);
  task.motion = read.motion;
  const auto prior = read_prior(o.prior);
  by_part(o.shared, o, [&] {
    const auto answer = with_progress("Monte Carlo", [&](const auto& report) {
      task.progress = report;
      return prediction_answer(o.method, read.session, o.procedure, task, prior);
    });
    show(answer, o);
  });
}

// imulab plan --require ...

std::string written_after(const std::string& file) { return file.empty() ? "" : "\n" + written_text(file) + "\n"; }

void run(const PlanOptions& o) {
  if (o.json && o.output == "-") throw Error("--json: standard output has the procedure; expected -o FILE");
  if (o.mission) {
    const auto answer = with_progress("planning", [&](const auto& report) { return drive_plan_answer(o, report); });
    if (!o.output.empty()) write_whole(o.output, answer.data->mission);
    return show(answer, o, written_after(o.output));
  }
  PlanTask task = task_of(o);
  by_part(o.shared, o, [&] {
    const auto answer = with_progress("planning", [&](const auto& report) {
      task.progress = report;
      return plan_answer(task, o.output == "-" ? "" : o.output);
    });
    if (!o.output.empty()) write_whole(o.output, procedure_text(answer.data->procedure));
    show(answer, o, written_after(o.output));
  });
}

// imulab trajectory MISSION -o FOLDER

void run(const TrajectoryOptions& o) {
  const MissionFile file = read_mission(o.mission);
  for (const std::filesystem::path& named : file.files) will_read(named);
  TrajectoryTask task{.mission = o.mission, .errors = o.errors, .seed = o.seed};
  if (o.unit) task.unit = read_calibration(*o.unit);
  const auto answer = with_progress("flying", [&](const auto& report) {
    task.progress = report;
    return flight_answer(file, task, o.output);
  });
  show_besides_files(answer, o);
}

// imulab budget MISSION

void run(const BudgetVerbOptions& o) {
  if (o.catalogue) return print(grade_catalogue());
  if (o.mission.empty()) throw Error("mission: expected the file of a mission, or --catalogue");
  const MissionFile file = read_mission(o.mission);
  for (const std::filesystem::path& named : file.files) will_read(named);
  if (!several_grades(o).empty())
    return show_besides_files(with_progress("Monte Carlo", [&](const auto& report) { return grades_answer(file, o, warn, report); }), o);
  by_part(o.shared, o, [&] {
    const auto answer = with_progress("Monte Carlo", [&](const auto& report) { return budget_answer(file, o, warn, report); });
    if (!o.output.empty()) write_budget(o.output, *answer.data);
    show_besides_files(answer, o);
  });
}

}  // namespace

void add_calibrate(Verb& app) { add<CalibrateOptions>(app, run); }
void add_compare(Verb& app) { add<CompareOptions>(app, run); }
void add_verify(Verb& app) { add<VerifyOptions>(app, run); }
void add_simulate(Verb& app) { add<SimulateOptions>(app, run); }
void add_plan(Verb& app) { add<PlanOptions>(app, run); }
void add_trajectory(Verb& app) { add<TrajectoryOptions>(app, run); }
void add_budget(Verb& app) { add<BudgetVerbOptions>(app, run); }

void add_predict(Verb& app) {
  const auto o = std::make_shared<PredictOptions>();
  Verb& verb = declare(app, *o);
  verb.does = [o, &verb] {
    const bool takes_runs = method(o->method).takes_runs;
    for (const auto& [option, wanted] : {std::pair{"runs", verb.at("--runs").given && o->runs != 0},
                                         {"seed", verb.at("--seed").given},
                                         {"classical", o->classical},
                                         {"checkpoint", !o->shared.checkpoint.empty()},
                                         {"part", !o->shared.part.empty()}})
      if (wanted && !takes_runs) throw OptionError(option, "belongs to --method " + names_of_methods(&Method::takes_runs));
    run(*o);
  };
}

}  // namespace imulab::command
