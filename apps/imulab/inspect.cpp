// imulab inspect FILE...
#include "imulab/tasks/inspect.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/results/inspection.hpp"
#include "imulab/tasks/given_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace imulab::command {

namespace {

/// A session beside its recordings names them without their folder; elsewhere by their full path.
Session placed(Session session, const InspectOptions& o) {
  namespace fs = std::filesystem;
  const fs::path place = fs::absolute(o.output).parent_path();
  const auto rename = [&](std::string& name) {
    for (const std::string& file : recordings_named(o.files))
      if (fs::path(file).filename().string() == name)
        name = fs::absolute(file).lexically_normal().lexically_proximate(place.lexically_normal()).string();
  };
  for (RecordingSource& source : session.recordings) {
    rename(source.file);
    for (auto* triad : {&source.gyro, &source.accel})
      if (triad->file) rename(*triad->file);
  }
  for (Aid& aid : session.aids) rename(aid.file);
  return session;
}

void run(const InspectOptions& o) {
  if (!o.output.empty() && std::any_of(o.files.begin(), o.files.end(), is_stream))
    throw Error("-o: a session names files; expected a recording that is one, not a stream");
  const std::string opened = given_files(o.files).session;
  if (!opened.empty() && !o.output.empty())
    throw Error(fmt::format("-o: {} is a session already; expected its recordings alone, for another one", opened));
  const InspectionTask task{.files = o.files, .topics = o.topics, .declared = parse_declarations(o.declarations), .longest_s = o.longest_s};
  auto answer = [&] {
    const Progress progress("inspecting");
    return inspection_answer(task);
  }();
  const Inspection& inspection = answer.data->inspection;
  const bool complete = inspection.complete();
  if (!inspection.problems().empty())
    answer.shortcomings = fmt::format("{}: no session: {}", inspection.file, inspection.problems().front());
  else if (!complete && o.output == "-" && !o.json)  // whose questions are printed nowhere else
    answer.shortcomings =
        fmt::format("{}: no session; declare with --set KEY=VALUE:\n  {}", inspection.file, fmt::join(inspection.ambiguous(), "\n  "));
  else if (!complete)
    answer.shortcomings =
        fmt::format("{}: no session: {} open; declare with --set KEY=VALUE", inspection.file,
                    inspection.ambiguous().size() == 1 ? "one question is" : fmt::format("{} questions are", inspection.ambiguous().size()));
  const std::string closing = "\n" + written_text(o.output, "not saved: no -o session.toml was given") + "\n";
  if (o.json && o.output == "-") print_json(answer.document());
  if (!o.output.empty() && complete) write_whole(o.output, inspected_session_text(inspection, placed(answer.data->session, o)));
  show(answer, o, complete && opened.empty() ? closing : "");
}

}  // namespace

void add_inspect(Verb& app) { add<InspectOptions>(app, run); }

}  // namespace imulab::command
