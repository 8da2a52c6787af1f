#include "imulab/tasks/inspect.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/inspection/join.hpp"
#include "imulab/recording/overview.hpp"
#include "imulab/report/recording_page.hpp"
#include "imulab/results/inspection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

namespace imulab {

Verb& declare(Verb& command, InspectOptions& o) {
  Verb& verb = command.verb("inspect", "Identify the contents of a recording, and write a session for it");
  verb.option("FILE", o.files, "the files of one recording, or its folder: text, bags, logs, arrays, archives; - for standard input")
      .required()
      .reads();
  verb.option("--for SECONDS", o.longest_s, "how long to read a stream that does not end: a serial port")
      .in_range(0.1, 86400)
      .show_default()
      .of_command();
  topics_option(verb, o.topics);
  declarations_option(verb, o.declarations);
  verb.option("-o,--output FILE", o.output, "the session to write; - for standard output").writes().of_command();
  report_option(verb, o.report);
  verb.option("--force", o.force, "replace the session if there is one").of_command();
  json_option(verb, o.json);
  verb.example("imulab inspect log.csv -o session.toml");
  verb.example("cat /dev/ttyUSB0 | imulab inspect - --for 30");
  verb.example("imulab inspect log.csv --set gyro.unit=deg/s -o session.toml");
  return verb;
}

VerbOption& topics_option(Verb& verb, std::vector<std::string>& topics) {
  return verb.option("--topic TOPIC", topics, "of a recording with several tables; repeat it where gyros and accelerometers are in different ones")
      .repeats()
      .called("topics");
}

void declarations_option(Verb& verb, std::vector<std::string>& declarations) {
  verb.option("--set KEY=VALUE", declarations,
              fmt::format("declare what the data of a recording do not determine; repeatable: {}", fmt::join(declaration_keys(), ", ")))
      .repeats()
      .of_command();
  verb.option("--time COLUMN", declarations,
              "the column of the stamps; none: the rows follow each other evenly, whatever stamps there are (with --rate)")
      .declares("time.column")
      .of_command();
  verb.option("--rate HZ", declarations, "the sampling rate, of rows without stamps").in_range(1e-3, 1e6).declares("rate_hz").of_command();
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

Inspection inspect_files(const InspectionTask& task) {
  inspection::check_declarations(task.declared);
  for (const std::string& file : task.files)
    if (std::filesystem::path(file).extension() == ".toml")
      throw Error(file + ": is a session or other settings; expected a recording, as a session names one");
  const auto layout = task.declared.find("layout");
  const std::string declared_layout = layout != task.declared.end() ? layout->second : "";
  std::vector<SignalTable> tables;
  for (const std::string& file : recordings_named(task.files))
    for (SignalTable& table : read_tables(file, task.topics, recording_formats(), task.longest_s, task.most_numbers, declared_layout))
      tables.push_back(std::move(table));
  Inspection found = inspect(inspection::joined(std::move(tables), task.declared), task.declared);
  found.source.layout = declared_layout;
  return found;
}

InspectedRecording inspect_and_read(const InspectionTask& task) {
  declared_site(task.declared), declared_grade(task.declared);  // their errors before the work
  Inspection found = inspect_files(task);
  Session session = inspected_session(found, task.declared);
  session.file = recordings_named(task.files).front();  // its folder is that of the recording
  InspectedRecording out{std::move(found), std::move(session), {}};
  if (!out.inspection.complete() || is_stream(out.session.file)) return out;
  out.session.sha256 = file_sum(out.session.file).sha256;
  give_back_freed_memory();  // of the tables that were inspected
  try {
    RecordingReading reading = read_recording(out.session, out.session.recordings.front());
    std::vector<std::string>& evidence = out.inspection.evidence;  // which has some of them already
    for (std::string& text : reading.warnings)
      if (std::find(evidence.begin(), evidence.end(), text) == evidence.end()) evidence.push_back(std::move(text));
    out.recording = std::move(reading.recording);
    const Recording& whole = *out.recording;  // of a long one only the first rows were inspected
    out.inspection.rows = std::max(out.inspection.rows, whole.size());
    out.inspection.duration_s = std::max(out.inspection.duration_s, whole.time_s(whole.size() - 1) - whole.time_s(0));
  } catch (const Error& e) {
    out.inspection.problems.emplace_back(e.what());
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
           .shortcomings = fmt::format("{}", fmt::join(inspection.problems.empty() ? inspection.ambiguous : inspection.problems, "\n")),
           .conclusion = {"", inspection_headline(inspection)}},
          found};
}

Session session_for(const Inspection& inspection, const InspectionTask& task, const std::string& hint) {
  const std::string file = recordings_named(task.files).front();
  if (!inspection.problems.empty()) throw Error(fmt::format("{}: {}", file, inspection.problems.front()));
  if (!inspection.complete())
    throw Unsupported(
        fmt::format("{}: the data do not answer every question about it; {}:\n  {}", file, hint, fmt::join(inspection.ambiguous, "\n  ")));
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
