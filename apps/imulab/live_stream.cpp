#include "apps/imulab/live_stream.hpp"

#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/recording/origin.hpp"

#include <fmt/core.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

namespace imulab::command {
namespace {

/// Where Ctrl-C finds the stream.
std::atomic<int> stream_descriptor{-1}, empty_descriptor{-1};
std::atomic<bool> interrupted{false};
struct sigaction before_ctrl_c {};

void end_stream(int) {
  interrupted = true;
  dup2(empty_descriptor, stream_descriptor);
}

}  // namespace

CtrlC::CtrlC(int descriptor) {
  stream_descriptor = descriptor;
  empty_descriptor = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  struct sigaction action {};
  action.sa_handler = end_stream;  // without SA_RESTART: a read that waits returns
  sigaction(SIGINT, &action, &before_ctrl_c);
}
CtrlC::~CtrlC() { sigaction(SIGINT, &before_ctrl_c, nullptr); }
bool CtrlC::came() { return interrupted; }

LiveInput::LiveInput(const std::string& name) : descriptor_(name == "-" ? STDIN_FILENO : ::open(name.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (descriptor_ < 0) throw Error(fmt::format("{}: cannot be opened: {}", name, std::strerror(errno)));
}
LiveInput::~LiveInput() {
  if (descriptor_ != STDIN_FILENO) ::close(descriptor_);
}

LiveCopy::LiveCopy(const std::string& file) : name_(file) {
  if (!file.empty() && !(file_ = std::fopen(file.c_str(), "wb")))
    throw Error(fmt::format("--save {}: cannot be written: {}", file, std::strerror(errno)));
}
LiveCopy::~LiveCopy() {
  if (file_) std::fclose(file_);
}
void LiveCopy::write(std::string_view bytes) {
  if (file_ && (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size() || std::fflush(file_) != 0))
    throw Error(fmt::format("--save {}: cannot be written: {}", name_, std::strerror(errno)));
}

LiveStream::LiveStream(const LiveOptions& options, const RecordingSource& source)
    : input(options.input),
      copy(options.save),
      ctrl_c(input.descriptor()),
      rows(
          input.descriptor(), name_of_stream(options), source, [this](std::string_view bytes) { copy.write(bytes); }, true) {}

std::FILE* output_of(const LiveOptions& options) { return options.output == "-" ? stderr : stdout; }
std::string name_of_stream(const LiveOptions& options) { return options.input == "-" ? "standard input" : options.input; }

Session session_of_stream(const LiveOptions& options) {
  if (options.session.empty()) throw Error("the columns of the stream are not known; expected --session");
  Session session = session_at(options.session);
  const RecordingSource source = named_recording(session, options.recording);
  if (source.gyro.columns.empty() || source.accel.columns.empty())
    throw Error(fmt::format("{}: has one triad; expected gyros and accelerometers", source.file));
  session.recordings = {source};
  return session;
}

void write_live(const LiveOptions& options, Calibration calibration, const Recording& recording, Session session) {
  const std::string file = !options.save.empty() ? options.save : options.input != "-" ? options.input : "";
  if (!file.empty()) session.recordings.front().file = std::filesystem::absolute(file).string();
  if (file.empty())
    add_declared_origin(calibration, session, {});
  else
    add_provenance(calibration, session, {&recording, 1});
  calibration.options = {{"live", "true"}};
  if (!options.output.empty()) write_whole(options.output, calibration_text(calibration));
}

void summarize_live(const LiveOptions& options, const Quality& quality, const std::string& what) {
  warn_each(quality.findings.warnings());
  const std::string written =
      options.output.empty() ? "not saved: no -o FILE was given" : "written: " + (options.output == "-" ? "standard output" : options.output);
  if (!options.json) print(fmt::format("{}: {}; {}\n", what, verdict_text(quality), written), output_of(options));
}

void warn_of_stream(const RecordingStream& stream, const Recording& recording, const std::string& consequence) {
  if (CtrlC::came()) warn("stopped by Ctrl-C");
  warn_each(stream.warnings());
  if (const auto& gaps = recording.gaps; !gaps.empty())
    warn(fmt::format("{} gap{} in time, the first before {:.3f} s{}", gaps.size(), gaps.size() == 1 ? "" : "s", recording.time_s(gaps.front()),
                     consequence));
}

}  // namespace imulab::command
