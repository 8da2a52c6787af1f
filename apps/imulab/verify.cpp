// imulab verify CALIBRATION
#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/calibration/file.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <string>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct Options {
  std::string calibration, session;
};

/// The session's file: where the user says, as the calibration names it, or beside the calibration.
fs::path session_file(const Options& o, const std::string& recorded) {
  if (!o.session.empty()) return fs::is_directory(o.session) ? fs::path(o.session) / "session.toml" : fs::path(o.session);
  const fs::path beside = fs::path(o.calibration).parent_path() / fs::path(recorded).filename();
  return !fs::exists(recorded) && fs::exists(beside) ? beside : fs::path(recorded);
}

const char* to_string(FileState state) {
  return state == FileState::unchanged ? "unchanged" : state == FileState::changed ? "changed" : "missing";
}

void run(const Options& o) {
  const Calibration calibration = read_calibration(o.calibration);
  if (calibration.sources.empty())
    throw Error(fmt::format("{}: has no hashes of recordings; expected a calibration that imulab made from files", o.calibration));
  std::string differing;
  for (const VerifiedFile& f : verify_sources(calibration, session_file(o, calibration.session_file))) {
    fmt::print("{}: {}\n", f.file.string(), to_string(f.state));
    if (f.state != FileState::unchanged) differing += fmt::format("{}{}", differing.empty() ? "" : ", ", f.file.string());
  }
  if (!differing.empty()) throw Unsupported(fmt::format("{}: not what it was made from: {}", o.calibration, differing));
}

}  // namespace

void add_verify(Verb app) {
  const auto o = std::make_shared<Options>();
  Verb verb = app.verb("verify", "Check that the recordings and the session of a calibration are still the same files");
  verb.option("CALIBRATION", o->calibration, "calibration.json").required();
  verb.option("--session", o->session, "the session's folder or file, if it is not where it was");
  verb.does([o] { run(*o); });
}

}  // namespace imulab::command
