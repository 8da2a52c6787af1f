// imulab live -: while the unit is being turned by hand, which poses and turns are still missing.
#include "imulab/tasks/live.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/recording/stream.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/recording/readings.hpp"

#include <fmt/core.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <memory>
#include <optional>
#include <unistd.h>

namespace imulab::command {

namespace {

struct Options {
  std::string input, session, recording, output, save;
  std::optional<std::string> require;
  double rest = 4;
  bool force = false, json = false;
};

/// Where Ctrl-C finds the stream: it ends there, as if the last row had come.
std::atomic<int> stream_descriptor{-1}, empty_descriptor{-1};
std::atomic<bool> interrupted{false};

void end_stream(int) {
  interrupted = true;
  dup2(empty_descriptor, stream_descriptor);
}

class CtrlC {
 public:
  explicit CtrlC(int descriptor) {
    stream_descriptor = descriptor;
    empty_descriptor = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    struct sigaction action {};
    action.sa_handler = end_stream;  // without SA_RESTART: a read that waits returns
    sigaction(SIGINT, &action, &before_);
  }
  ~CtrlC() { sigaction(SIGINT, &before_, nullptr); }
  CtrlC(const CtrlC&) = delete;
  CtrlC& operator=(const CtrlC&) = delete;

 private:
  struct sigaction before_ {};
};

/// Standard input, or a file.
class Input {
 public:
  explicit Input(const std::string& name) : descriptor_(name == "-" ? STDIN_FILENO : ::open(name.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) throw Error(fmt::format("{}: cannot be opened: {}", name, std::strerror(errno)));
  }
  ~Input() {
    if (descriptor_ != STDIN_FILENO) ::close(descriptor_);
  }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

/// A copy of the stream as it came, on the disk as soon as it is here.
class Copy {
 public:
  explicit Copy(const std::string& file) : name_(file) {
    if (!file.empty() && !(file_ = std::fopen(file.c_str(), "wb")))
      throw Error(fmt::format("--save {}: cannot be written: {}", file, std::strerror(errno)));
  }
  ~Copy() {
    if (file_) std::fclose(file_);
  }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;
  void write(std::string_view bytes) {
    if (file_ && (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size() || std::fflush(file_) != 0))
      throw Error(fmt::format("--save {}: cannot be written: {}", name_, std::strerror(errno)));
  }

 private:
  std::string name_;
  std::FILE* file_ = nullptr;
};

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

std::FILE* output_of(const Options& options) { return options.output == "-" ? stderr : stdout; }

std::string name_of(const std::string& input) { return input == "-" ? "standard input" : input; }

/// The calibration of what came, with where it comes from.
void write_result(const Options& options, LiveProgress& progress, Session session) {
  if (!progress.result()) return;
  Calibration calibration = progress.result()->calibration;
  const std::string file = !options.save.empty() ? options.save : options.input != "-" ? options.input : "";
  if (!file.empty()) session.recordings.front().file = std::filesystem::absolute(file).string();
  if (file.empty())
    add_declared_origin(calibration, session, {});
  else
    add_provenance(calibration, session, {&progress.recording(), 1});
  calibration.options = {{"live", "true"}};
  if (!options.output.empty()) write_whole(options.output, calibration_text(calibration));
}

void summarize(const Options& options, const LiveProgress& progress) {
  const LiveView& view = progress.view();
  const Quality& quality = progress.result()->calibration.quality;
  warn_each(quality.warnings);
  const std::string written =
      options.output.empty() ? "not saved: no -o FILE was given" : "written: " + (options.output == "-" ? "standard output" : options.output);
  if (!options.json)
    print(fmt::format("{} rest{} in {:.0f} s: {}; {}\n", view.up.size(), view.up.size() == 1 ? "" : "s", view.time_s, verdict_text(quality), written),
          output_of(options));
}

/// At the end: what was reached, and what is missing.
void conclude(const Options& options, const LiveProgress& progress) {
  const LiveView& view = progress.view();
  if (view.samples < 2) throw Unsupported(fmt::format("{}: fewer than two rows arrived; expected a stream of them", name_of(options.input)));
  if (!view.problem.empty()) throw Unsupported(shortcomings(progress));
  summarize(options, progress);
  if (!progress.reached()) throw Unsupported(shortcomings(progress));
}

/// Until everything is reached or nothing more comes; the error that ended the stream, if one did.
std::exception_ptr follow(RecordingStream& stream, LiveProgress& progress, Display& display) {
  try {
    while (const std::optional<Recording> piece = stream.next()) {
      for (std::optional<Range> left = Range{0, piece->size()}; left;) {
        left = progress.add(*piece, *left);
        display.show(progress.view(), left.has_value());
        if (left && progress.reached()) return {};
      }
    }
  } catch (const Error&) {
    return std::current_exception();
  }
  return {};
}

void run(const Options& options) {
  if (options.session.empty()) throw Error("the columns of the stream are not known; expected --session");
  Session session = session_at(options.session);
  const RecordingSource source = named_recording(session, options.recording);
  if (source.gyro.columns.empty() || source.accel.columns.empty())
    throw Error(fmt::format("{}: has one triad; expected gyros and accelerometers", source.file));
  session.recordings = {source};
  errors_at(session.file + ": [site]", [&] { session.site.gravity(); });
  const std::vector<Requirement> required =
      errors_at("--require", [&] { return live_requirements(options.require, source.accel.unit, session.site); });
  LiveProgress progress(session, recording_options(source), required, options.rest);
  expect_free("-o", options.output, options.force);
  expect_free("--save", options.save, options.force);
  Input input(options.input);
  Copy copy(options.save);
  const CtrlC ctrl_c(input.descriptor());
  RecordingStream stream(
      input.descriptor(), name_of(options.input), source, [&](std::string_view bytes) { copy.write(bytes); }, true);
  Display display(output_of(options), options.json);
  const std::exception_ptr failure = follow(stream, progress, display);
  if (!progress.reached() && progress.recording().size() > 0) {
    progress.estimate();
    display.show(progress.view(), true);
  }
  if (interrupted) warn("stopped by Ctrl-C");
  warn_each(stream.warnings());
  if (const auto& gaps = progress.recording().gaps; !gaps.empty())
    warn(fmt::format("{} gap{} in time, the first before {:.3f} s: turns across one are not used", gaps.size(), gaps.size() == 1 ? "" : "s",
                     progress.recording().time_s(gaps.front())));
  write_result(options, progress, session);
  if (failure) {
    if (progress.result()) summarize(options, progress);
    std::rethrow_exception(failure);
  }
  conclude(options, progress);
}

}  // namespace

void add_live(Verb& app) {
  const auto o = std::make_shared<Options>();
  Verb& verb = app.verb("live", "While the IMU is being turned by hand, show which poses and turns are still missing");
  verb.option("STREAM", o->input, "the stream of rows: - for standard input, or a file").required().reads();
  verb.option("--session SESSION", o->session, "a session that describes the stream's columns and the site").required().reads();
  verb.option("--recording FILE", o->recording, "the recording of that session to take the columns from, if it has several");
  verb.option("--require LIMITS", o->require, "stop when this is reached; if absent, " + usual_live_requirement("m/s^2"));
  verb.option("--rest", o->rest, "seconds of every rest").in_range(1, 600).show_default();
  verb.option("-o,--output FILE", o->output, "the calibration file to write at the end; - for standard output, and the events go to standard error")
      .writes();
  verb.option("--save FILE", o->save, "a file for what was streamed, as it came").writes();
  verb.option("--force", o->force, "replace these files if there are any");
  verb.option("--json", o->json, "print each event as JSON, one line each");
  verb.example("driver | imulab live - --session session.toml -o calibration.json");
  verb.does = [o] { run(*o); };
}

}  // namespace imulab::command
