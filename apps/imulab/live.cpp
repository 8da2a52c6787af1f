// imulab live -: while the unit is being turned by hand, which poses and turns are still missing.
#include "imulab/tasks/live.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/live_stream.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/readings.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <unistd.h>

namespace imulab::command {

namespace {

constexpr const char *by_hand = "handheld", *of_motion = "extrinsics";

/// A picture that is drawn anew, or a line for each event.
class Display {
 public:
  /// On standard output, or standard error where the calibration is written to that.
  Display(std::FILE* out, bool json)
      : out_(out),
        json_(json),
        terminal_(!json && isatty(fileno(out)) != 0 && !is("TERM", "dumb")),
        color_(terminal_ && (out == stdout ? output_has_color() : errors_have_color())) {
    if (terminal_) fmt::print(out_, "\033[2J");
  }
  void show(const LiveView& view, bool new_rest) {
    constexpr double every_s = 0.1;
    if (!new_rest && (!terminal_ || view.time_s - drawn_s_ < every_s)) return;
    drawn_s_ = view.time_s;
    if (json_)
      fmt::print(out_, "{}", live_json(view));
    else if (terminal_)
      redraw(view);
    else
      lines(view);
    std::fflush(out_);
  }

 private:
  static bool is(const char* variable, const char* value) {
    const char* const found = std::getenv(variable);
    return found != nullptr && std::strcmp(found, value) == 0;
  }
  void redraw(const LiveView& view) const {
    std::string text = "\033[H";
    for (const char c : live_picture(view, color_)) text += c == '\n' ? "\033[K\n" : std::string(1, c);
    fmt::print(out_, "{}\033[J", text);
  }
  void lines(const LiveView& view) const {
    const std::string at = fmt::format("{:8.2f} s  ", view.time_s);
    if (!view.up.empty()) print(fmt::format("{}rest {}: {} up\n", at, view.up.size(), direction_text(view.up.back())), out_);
    if (!view.problem.empty()) print(fmt::format("{}{}\n", at, view.problem), out_);
    std::string reached;
    for (const RequirementResult& r : view.requirements) reached += (reached.empty() ? "" : ", ") + progress_text(r);
    if (!reached.empty()) print(fmt::format("{}{}: {}\n", at, view.done ? "done" : "reached", reached), out_);
    if (view.next && !view.done) print(fmt::format("{}next: {}, then hold still for {:g} s\n", at, turn_text(*view.next), view.rest_s), out_);
  }
  std::FILE* out_;
  bool json_, terminal_, color_;
  double drawn_s_ = 0;
};

void summarize_by_hand(const LiveOptions& options, const LiveProgress& progress) {
  const LiveView& view = progress.view();
  summarize_live(options, progress.result()->calibration.quality,
                 fmt::format("{} rest{} in {:.0f} s", view.up.size(), view.up.size() == 1 ? "" : "s", view.time_s));
}

/// At the end: what was reached, and what is missing.
void conclude_by_hand(const LiveOptions& options, const LiveProgress& progress) {
  const LiveView& view = progress.view();
  if (view.samples < 2) throw Unsupported(fmt::format("{}: fewer than two rows arrived; expected a stream of them", name_of_stream(options)));
  if (!view.problem.empty()) throw Unsupported(shortcomings(progress));
  summarize_by_hand(options, progress);
  if (!progress.reached()) throw Unsupported(shortcomings(progress));
}

void run_by_hand(const LiveOptions& options) {
  const Session session = session_of_stream(options);
  const RecordingSource& source = session.recordings.front();
  errors_at(session.file + ": [site]", [&] { session.site.gravity(); });
  const std::vector<Requirement> required =
      errors_at("--require", [&] { return live_requirements(options.require, source.accel.unit, session.site); });
  constexpr double usual_rest_s = 4;
  LiveProgress progress(session, recording_options(source), required, options.rest.value_or(usual_rest_s));
  LiveStream stream(options, source);
  Display display(output_of(options), options.json);
  const std::exception_ptr failure = follow(stream.rows, progress, [&](bool new_rest) { display.show(progress.view(), new_rest); });
  if (!progress.reached() && progress.recording().size() > 0) {
    progress.estimate();
    display.show(progress.view(), true);
  }
  warn_of_stream(stream.rows, progress.recording(), ": turns across one are not used");
  if (progress.result()) write_live(options, progress.result()->calibration, progress.recording(), session);
  if (failure) {
    if (progress.result()) summarize_by_hand(options, progress);
    std::rethrow_exception(failure);
  }
  conclude_by_hand(options, progress);
}

void run_live(const LiveOptions& options) {
  if (options.method == of_motion) return run_live_extrinsics(options);
  const Method& chosen = errors_at("--method", [&]() -> const Method& { return method(options.method); });
  if (chosen.takes_aids && options.rest) throw Error("--rest: belongs to a calibration by hand");
  if (chosen.takes_aids) return run_live_drive(options);
  run_by_hand(options);
}

}  // namespace

void add_live(Verb& app) {
  const auto o = std::make_shared<LiveOptions>();
  Verb& verb = app.verb("live", "While the IMU is being turned by hand, or driven, show what is still missing");
  verb.option("STREAM", o->input, "rows of the IMU: - for standard input, or a file").required().reads();
  verb.option("--session SESSION", o->session, "the session that describes the stream: columns, site, of a drive also the aids").required().reads();
  verb.option("--recording FILE", o->recording, "the recording to use, if the session has several");
  std::vector<std::string> names{by_hand};
  for (const Method& m : methods())
    if (m.takes_aids) names.emplace_back(m.name);
  names.emplace_back(of_motion);
  verb.option("--method METHOD", o->method,
              "handheld: by hand; drive: from a drive whose aids' files grow; extrinsics: of several IMUs, while one is moved")
      .one_of(names)
      .show_default();
  verb.option("--require LIMITS", o->require,
              "stop when these limits are met; absent: by hand " + usual_live_requirement("m/s^2") + ", of a drive at the end of the stream");
  verb.option("--rest SECONDS", o->rest, "duration of each rest by hand; absent: 4").in_range(1, 600);
  verb.option("-o,--output FILE", o->output, "the calibration file to write at the end; - for standard output, and the events go to standard error")
      .writes()
      .keeps_existing();
  verb.option("--save FILE", o->save, "a file that gets all rows as they come").writes().keeps_existing();
  verb.option("--json", o->json, "print each event as JSON, one line each");
  verb.example("driver | imulab live - --session session.toml -o calibration.json");
  verb.does = [o] { run_live(*o); };
}

}  // namespace imulab::command
