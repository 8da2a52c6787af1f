// imulab verify CALIBRATION
#include "imulab/tasks/verify.hpp"

#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/text/terminal.hpp"

#include <memory>
#include <string>

namespace imulab::command {

namespace {

struct Options {
  std::string calibration, session;
  bool json = false;
};

void run(const Options& o) {
  const VerifiedCalibration verified = [&] {
    const Progress progress("verifying");
    return verify(o.calibration, o.session);
  }();
  o.json ? print_json(verification_json(verified)) : print(verification_text(verified));
  if (const std::string text = shortcomings(verified); !text.empty()) throw Unsupported(text);
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
