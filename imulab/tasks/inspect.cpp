#include "imulab/tasks/inspect.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/join.hpp"
#include "imulab/inspection/pieces.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/recording/overview.hpp"
#include "imulab/report/recording_page.hpp"
#include "imulab/results/inspection.hpp"
#include "imulab/tasks/given_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <tuple>
#include <utility>
#include <variant>

namespace imulab {

Verb& declare(Verb& command, InspectOptions& o) {
  Verb& verb = command.verb("inspect", "Identify the contents of a recording, and write a session for it");
  verb.option("FILE", o.files,
              "the files of one recording, or its folder: text, bags, logs, arrays, archives; also aids, or a session; - for standard input")
      .required()
      .reads();
  verb.option("-o,--output FILE", o.output, "the session to write; - for standard output").writes().keeps_existing().of_command();
  verb.option("--for SECONDS", o.longest_s, "longest time to read a stream that does not end, such as a serial port")
      .in_range(0.1, 86400)
      .show_default()
      .of_command();
  topics_option(verb, o.topics);
  declarations_option(verb, o.declarations);
  report_option(verb, o.report);
  json_option(verb, o.json);
  verb.example("imulab inspect log.csv -o session.toml");
  verb.example("cat /dev/ttyUSB0 | imulab inspect - --for 30");
  verb.example("imulab inspect log.csv --set gyro.unit=deg/s -o session.toml");
  return verb;
}

VerbOption& topics_option(Verb& verb, std::vector<std::string>& topics) {
  return verb
      .option("--topic TOPIC", topics, "the table of a recording that has several; repeat it if gyros and accelerometers are in different ones")
      .repeats()
      .called("topics");
}

void declarations_option(Verb& verb, std::vector<std::string>& declarations) {
  verb.option("--set KEY=VALUE", declarations,
              fmt::format("declare what a recording does not contain; repeatable. Keys: {}", fmt::join(declaration_keys(), ", ")))
      .repeats()
      .of_command();
  verb.option("--time COLUMN", declarations, "the column of the stamps; none: the rows are equally spaced, and stamps are ignored (with --rate)")
      .declares("time.column")
      .of_command();
  verb.option("--rate HZ", declarations, "sampling rate of rows without stamps").in_range(1e-3, 1e6).declares("rate_hz").of_command();
}

Declarations parse_declarations(const std::vector<std::string>& texts) {
  Declarations declared;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) throw OptionError("set " + text, "has no value; expected KEY=VALUE");
    declared[text.substr(0, equals)] = text.substr(equals + 1);
  }
  errors_of_option("set", [&] {
    inspection::check_declarations(declared);
    declared_site(declared), declared_grade(declared);
  });
  return declared;
}

std::vector<std::string> recordings_named(const std::vector<std::string>& files) {
  std::vector<std::string> named = with_series_joined(files);
  for (std::string& file : named) file = without_slash(file).string();
  return named;
}

namespace {

struct InspectedFiles {
  Inspection found;
  std::vector<std::string> recordings;  ///< one after the other, by the same declaration; empty: one recording
};

InspectedFiles inspect_recordings(const GivenFiles& given, const InspectionTask& task) {
  if (given.recordings.empty())
    throw Error(fmt::format(
        "{0}: is an aid of kind {1} and no recording; expected the readings of an IMU, and this file beside them: imulab inspect log.csv {0}",
        given.aids.front().file, to_string(given.aids.front().kind)));
  const auto layout = task.declared.find("layout");
  const std::string declared_layout = layout != task.declared.end() ? layout->second : "";
  const std::vector<std::string> files = recordings_named(given.recordings);
  std::vector<SignalTable> tables;
  for (const std::string& file : files)
    for (SignalTable& table : read_tables(file, task.topics, recording_formats(), task.longest_s, task.most_numbers, declared_layout))
      tables.push_back(std::move(table));
  InspectedFiles out;
  const bool pieces = inspection::are_pieces(tables, task.declared);
  SignalTable whole;
  if (pieces)
    whole = inspection::appended(std::move(tables), task.declared);
  else
    whole = inspection::joined(std::move(tables), task.declared);
  out.found = inspect(whole, task.declared);
  out.found.source.layout = declared_layout;
  if (!pieces) return out;
  Findings asked;
  asked.add<Code::open_question>(Subject{"gyro.unit"}, "no file has three turns between rests, which would show it");
  std::ranges::replace(out.found.findings, Code::turns_unexplained, asked.front(), &Finding::code);
  out.recordings = files;
  out.found.note(
      fmt::format("files: {} with the same columns: recordings of one unit one after the other, which calibrate takes together, by "
                  "name or in the session of -o; turns from one file to the next are not seen",
                  files.size()));
  return out;
}

/// The recordings and aids of a session that has one recording; receivers tell the place.
void take_files(Session& session, const std::vector<std::string>& recordings, const std::vector<Aid>& aids, const Declarations& declared) {
  const auto name_of = [](const std::string& file) { return std::filesystem::path(file).filename().string(); };
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    if (k > 0) session.recordings.push_back(session.recordings.front());
    session.recordings[k].file = name_of(recordings[k]);
  }
  for (RecordingSource& source : session.recordings) {  // a clock that is named as the receiver's needs no search
    const std::string* const column = aids.empty() || !source.time.column ? nullptr : std::get_if<std::string>(&*source.time.column);
    if (column == nullptr) continue;
    if (lowered(*column).find("gps") != std::string::npos) source.time.scale = TimeScale::gps;
    if (lowered(*column).find("utc") != std::string::npos) source.time.scale = TimeScale::utc;
  }
  for (const Aid& aid : aids) {
    session.aids.push_back(aid);
    session.aids.back().file = name_of(aid.file);
    if (aid.kind == AidKind::gnss) session.site = declared_site(declared);
  }
}

/// Reads each recording as the session declares it, keeps the first, and counts all.
void read_all(InspectedRecording& out) {
  out.inspection.duration_s = out.session.recordings.size() > 1 ? 0 : out.inspection.duration_s;
  std::size_t rows = 0;
  for (const RecordingSource& source : out.session.recordings) {
    RecordingReading reading = read_recording(out.session, source);
    const std::vector<std::string> evidence = out.inspection.evidence();  // which has some of them already
    for (const std::string& text : reading.warnings)
      if (std::find(evidence.begin(), evidence.end(), text) == evidence.end()) out.inspection.note(text);
    const Recording& whole = reading.recording;  // of a long one only the first rows were inspected
    const double duration_s = whole.time_s(whole.size() - 1) - whole.time_s(0);
    rows += whole.size();
    out.inspection.duration_s =
        out.session.recordings.size() > 1 ? out.inspection.duration_s + duration_s : std::max(out.inspection.duration_s, duration_s);
    if (!out.recording) out.recording = std::move(reading.recording);
  }
  out.inspection.rows = std::max(out.inspection.rows, rows);
}

/// What the aids are, and what can be done with them.
void tell_aids(InspectedRecording& out) {
  if (out.session.aids.empty() || !out.recording) return;
  const AidsReading reading = read_aids(out.session, out.session.recordings.front(), *out.recording);
  for (const Aid& aid : reading.aids)
    if (has_record(aid.kind))
      out.inspection.note(fmt::format("aid: {}: {}, {} rows in {:.5g} s{}", aid.file, to_string(aid.kind), aid.record.time.size(),
                                      1e-9 * static_cast<double>(aid.record.time.back() - aid.record.time.front()),
                                      aid.scale == TimeScale::own ? ", on a clock whose offset is estimated" : ""));
  for (const std::string& warning : reading.warnings) out.inspection.note(warning);
  out.inspection.note("with the aid, by the session of -o: calibrate --method drive, and navigate --aided for the path");
  for (MethodFinding& method : out.inspection.methods)
    if (find_method(method.name)->takes_aids) method = {method.name, true, "by the aid, as far as the motion shows the coefficients, which it says"};
}

/// A recording as a table of what its session declares it to be.
SignalTable declared_table(const Recording& recording, const std::string& file, Declarations& declared) {
  SignalTable table{.file = file, .format = "as its session declares it"};
  const auto add = [&](const std::string& name, std::vector<double> values) { table.signals.push_back({name, "", name, std::move(values)}); };
  std::vector<double> time;
  for (std::size_t i = 0; i < recording.size(); ++i) time.push_back(recording.time_s(i));
  add("t", std::move(time));
  declared["time.column"] = "t", declared["time.unit"] = "s";
  for (const auto& [triad, columns, unit] :
       {std::tuple("gyro", &recording.gyro, &recording.gyro_unit), std::tuple("accel", &recording.accel, &recording.accel_unit)}) {
    if ((*columns)[0].empty()) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) add(fmt::format("{}.{}", triad, "xyz"[axis]), (*columns)[axis]);
    declared[fmt::format("{}.columns", triad)] = fmt::format("{0}.x,{0}.y,{0}.z", triad);
    declared[fmt::format("{}.unit", triad)] = *unit;
  }
  if (!recording.gyro_temperature[0].empty()) add("temperature", recording.gyro_temperature[0]);
  return table;
}

/// Throws Error for a file that the session does not name.
void expect_named(const Session& session, const std::string& file) {
  const auto is = [&](const std::string& named) {
    std::error_code none;
    return std::filesystem::equivalent(session_path(session, named), file, none);
  };
  for (const RecordingSource& source : session.recordings)
    for (const std::string& named : source.files())
      if (is(named)) return;
  for (const Aid& aid : session.aids)
    if (is(aid.file)) return;
  throw Error(fmt::format("{}: is not named by {}; expected the session with its own files, or recordings without it", file, session.file));
}

/// A session is opened: its recordings as it declares them. What contradicts the data is a problem.
InspectedRecording opened_session(const GivenFiles& given, const InspectionTask& task) {
  if (!task.declared.empty() || !task.topics.empty()) throw Error(given.session + ": declares all itself; expected it without --set and --topic");
  Session session = read_session(given.session);
  for (const std::string& file : given.recordings) expect_named(session, file);
  for (const Aid& aid : given.aids) expect_named(session, aid.file);
  if (session.recordings.empty())
    throw Error(given.session + ": has no [[recording]]: a procedure, which simulate and predict take; expected a session with its recording");
  InspectedRecording out{{}, std::move(session), {}};
  std::vector<SignalTable> tables;
  std::vector<std::string> warnings;
  Declarations declared;
  for (const RecordingSource& source : out.session.recordings) {
    RecordingReading reading = read_recording(out.session, source);
    tables.push_back(declared_table(reading.recording, source.file, declared));
    warnings.insert(warnings.end(), reading.warnings.begin(), reading.warnings.end());
    if (!out.recording) out.recording = std::move(reading.recording);
  }
  out.inspection = inspect(inspection::appended(std::move(tables), declared), declared);
  Inspection& found = out.inspection;
  found.file = given.session;
  found.source = out.session.recordings.front();
  for (const std::string& warning : warnings) found.note(warning);
  found.note(fmt::format("session: {} recording{}, {} steps, {} aids, used as it stands", out.session.recordings.size(),
                         out.session.recordings.size() == 1 ? "" : "s", out.session.steps.size(), out.session.aids.size()));
  for (Finding& f : found.findings)
    if (f.severity == Severity::warning) f.severity = Severity::doubt, f.text = "the data contradict the session: " + f.text;
  for (MethodFinding& method : found.methods)
    if (!find_method(method.name)->support && !find_method(method.name)->takes_aids && !find_method(method.name)->takes_reference &&
        !out.session.steps.empty() && !out.session.rigs.empty())
      method = {method.name, true, "the session has a rig and steps: try it if they are those that it needs"};
  return out;
}

}  // namespace

Inspection inspect_files(const InspectionTask& task) {
  inspection::check_declarations(task.declared);
  const GivenFiles given = given_files(task.files);
  return given.session.empty() ? inspect_recordings(given, task).found : opened_session(given, task).inspection;
}

InspectedRecording inspect_and_read(const InspectionTask& task) {
  inspection::check_declarations(task.declared);
  declared_site(task.declared), declared_grade(task.declared);  // their errors before the work
  const GivenFiles given = given_files(task.files);
  InspectedRecording out;
  try {
    if (!given.session.empty()) {
      out = opened_session(given, task);
    } else {
      auto [found, recordings] = inspect_recordings(given, task);
      out.session = inspected_session(found, task.declared);
      out.inspection = std::move(found);
      out.session.file = recordings_named(given.recordings).front();  // its folder is that of the recording
      take_files(out.session, recordings, given.aids, task.declared);
      if (!out.inspection.complete() || is_stream(out.session.file)) return out;
      out.session.sha256 = file_sum(out.session.file).sha256;
      give_back_freed_memory();  // of the tables that were inspected
      read_all(out);
    }
    tell_aids(out);
  } catch (const Error& e) {
    if (out.inspection.rows == 0) throw;  // nothing was found
    out.inspection.findings.add<Code::file_problem>(e.what());
  }
  return out;
}

AnswerOf<InspectedRecording> inspection_answer(const InspectionTask& task) {
  constexpr std::size_t intervals = 1500;  // of the picture
  const auto found = std::make_shared<const InspectedRecording>(inspect_and_read(task));
  const Inspection& inspection = found->inspection;
  return {{.json = [found] { return inspection_json(found->inspection); },
           .table = [found](bool) { return inspection_text(found->inspection); },
           .page =
               [found] {
                 std::optional<Overview> picture;
                 if (found->recording) picture = overview(SensorModel{}, *found->recording, intervals);
                 return inspection_page(found->inspection, picture);
               },
           .shortcomings = fmt::format("{}", fmt::join(inspection.problems().empty() ? inspection.ambiguous() : inspection.problems(), "\n")),
           .conclusion = {Verdict::none, inspection_headline(inspection)}},
          found};
}

Session session_for(const Inspection& inspection, const InspectionTask& task, const std::string& hint) {
  const std::string file = recordings_named(task.files).front();
  if (const std::vector<std::string> problems = inspection.problems(); !problems.empty()) throw Error(fmt::format("{}: {}", file, problems.front()));
  if (!inspection.complete())
    throw Unsupported(
        fmt::format("{}: the data do not answer every question about it; {}:\n  {}", file, hint, fmt::join(inspection.ambiguous(), "\n  ")));
  Session session = inspected_session(inspection, task.declared);
  session.file = file;
  session.sha256 = file_sum(file).sha256;
  return session;
}

std::string assumed_gravity(const Session& session) {
  if (session.site.latitude || !(session.site.given_gravity_sigma >= gravity_anywhere_sigma)) return "";
  return fmt::format("gravity {} m/s^2 (u = {} m/s^2), as anywhere on Earth", *session.site.given_gravity, *session.site.given_gravity_sigma);
}

}  // namespace imulab
