// imulab inspect FILE...
#include "imulab/tasks/inspect.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/inspected.hpp"
#include "apps/imulab/report.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/report/recording_page.hpp"
#include "imulab/results/inspection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace imulab::command {

namespace {

struct Options {
  std::vector<std::string> files, topics, declarations;
  std::string output, report;
  double longest_s = stream_s;
  bool json = false, force = false;
};

/// A session beside its recordings names them without their folder; elsewhere by their full path.
Session placed(Session session, const Options& o) {
  namespace fs = std::filesystem;
  const fs::path place = fs::absolute(o.output).parent_path();
  const auto rename = [&](std::string& name) {
    for (const std::string& file : o.files)
      if (fs::path(file).filename().string() == name)
        name = fs::absolute(file).lexically_normal().lexically_proximate(place.lexically_normal()).string();
  };
  for (RecordingSource& source : session.recordings) {
    rename(source.file);
    for (auto* triad : {&source.gyro, &source.accel})
      if (triad->file) rename(*triad->file);
  }
  return session;
}

void run(const Options& o) {
  expect_free("-o", o.output, o.force);
  if (!o.output.empty() && std::any_of(o.files.begin(), o.files.end(), is_stream))
    throw Error("-o: a session names files; expected a recording that is one, not a stream");
  const InspectionTask task{.files = o.files, .topics = o.topics, .declared = parse_declarations(o.declarations), .longest_s = o.longest_s};
  const auto [inspection, session, recording] = [&] {
    const Progress progress("inspecting");
    return inspect_and_read(task);
  }();
  if (o.json) {
    print_json(inspection_json(inspection));
  } else if (o.output != "-") {
    print(inspection_text(inspection));
  }
  if (!o.output.empty() && inspection.complete()) {
    write_whole(o.output, inspected_session_text(inspection, placed(session, o)));
    if (!o.json && o.output != "-") print(fmt::format("\nwritten: {}\n", o.output));
  } else if (!o.json && o.output.empty() && inspection.complete()) {
    print("\nnot saved: no -o session.toml was given\n");
  }
  if (!o.report.empty()) {
    std::optional<Overview> overview;
    if (recording) overview = imulab::overview(SensorModel{}, *recording, 1500);
    write_whole(o.report, inspection_page(inspection, overview));
  }
  if (!inspection.problems.empty()) throw Unsupported(fmt::format("{}: no session: {}", inspection.file, inspection.problems.front()));
  if (!inspection.complete())
    throw Unsupported(
        fmt::format("{}: no session: {} open; declare with --set KEY=VALUE", inspection.file,
                    inspection.ambiguous.size() == 1 ? "one question is" : fmt::format("{} questions are", inspection.ambiguous.size())));
}

}  // namespace

void add_inspect(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("inspect", "Identify the contents of a recording, and write a session for it");
  verb.option("FILE", o->files, "the files of one recording: text, bags, logs, arrays; - for standard input").required().reads();
  verb.option("--for SECONDS", o->longest_s, "how long to read a stream that does not end: a serial port").in_range(0.1, 86400).show_default();
  verb.option("--topic TOPIC", o->topics, "of a file with several tables; repeat it where gyros and accelerometers are in different ones").repeats();
  add_declarations(verb, o->declarations);
  verb.option("-o,--output FILE", o->output, "the session to write; - for standard output").writes();
  add_report_option(verb, o->report);
  verb.flag("--force", o->force, "replace the session if there is one");
  verb.flag("--json", o->json, "print the result as JSON");
  verb.example("imulab inspect log.csv -o session.toml");
  verb.example("cat /dev/ttyUSB0 | imulab inspect - --for 30");
  verb.example("imulab inspect log.csv --set gyro.unit=deg/s -o session.toml");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
