// imulab verify CALIBRATION
#include "apps/imulab/command.hpp"
#include "apps/imulab/session_recording.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/calibration/file.hpp"
#include "imulab/io/result/fields.hpp"
#include "imulab/io/text/terminal.hpp"

#include <fmt/core.h>

#include <memory>
#include <string>

namespace imulab::command {

namespace {

struct Options {
  std::string calibration, session;
  bool json = false;
};

const char* to_string(FileState state) { return state == FileState::unchanged ? "unchanged" : state == FileState::changed ? "changed" : "missing"; }

void run(const Options& o) {
  const Calibration calibration = read_calibration(o.calibration);
  if (calibration.sources.empty())
    throw Error(fmt::format("{}: has no hashes of recordings; expected a calibration that imulab made from files", o.calibration));
  std::string changed, missing;
  std::vector<JsonFields> files;
  const auto verified = [&] {
    const Progress progress("verifying");
    return verify_sources(calibration, find_session(o.session, o.calibration, calibration.session_file));
  }();
  for (const VerifiedFile& f : verified) {
    if (!o.json) print(fmt::format("{}: {}\n", f.file.string(), to_string(f.state)));
    files.push_back({{{"file", f.file.string()}, {"state", std::string(to_string(f.state))}}});
    std::string& list = f.state == FileState::changed ? changed : missing;
    if (f.state != FileState::unchanged) list += fmt::format("{}{}", list.empty() ? "" : ", ", f.file.string());
  }
  if (o.json) print_json(fields_json({{{"files", files}, {"unchanged", changed.empty() && missing.empty()}}}));
  if (!changed.empty()) throw Unsupported(fmt::format("{}: not what it was made from: {}", o.calibration, changed));
  if (!missing.empty()) throw Unsupported(fmt::format("{}: not found: {}; expected --session with their place", o.calibration, missing));
}

}  // namespace

void add_verify(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("verify", "Check that the recordings and the session of a calibration are still the same files");
  verb.option("CALIBRATION", o->calibration, "calibration.json").required().reads();
  verb.option("--session SESSION", o->session, "the session's folder or file, if it is not where it was");
  verb.flag("--json", o->json, "print the result as JSON");
  verb.example("imulab verify calibration.json");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
