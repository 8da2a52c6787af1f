// What both ways of `imulab live` share: the stream, its copy, Ctrl-C, and the calibration at the end.
#pragma once

#include "apps/imulab/command.hpp"
#include "imulab/calibrate.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/text/stream.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <string_view>

namespace imulab::command {

struct LiveOptions {
  std::string input, session, recording, output, save, method = "handheld";
  std::optional<std::string> require;
  std::optional<double> rest;
  bool json = false;
};

/// Ends the stream at Ctrl-C, as if the last row had come.
class CtrlC {
 public:
  explicit CtrlC(int descriptor);
  ~CtrlC();
  CtrlC(const CtrlC&) = delete;
  CtrlC& operator=(const CtrlC&) = delete;
  static bool came();
};

/// Standard input, or a file.
class LiveInput {
 public:
  explicit LiveInput(const std::string& name);
  ~LiveInput();
  LiveInput(const LiveInput&) = delete;
  LiveInput& operator=(const LiveInput&) = delete;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

/// A copy of the stream as it came, on the disk as soon as it is here.
class LiveCopy {
 public:
  explicit LiveCopy(const std::string& file);
  ~LiveCopy();
  LiveCopy(const LiveCopy&) = delete;
  LiveCopy& operator=(const LiveCopy&) = delete;
  void write(std::string_view bytes);

 private:
  std::string name_;
  std::FILE* file_ = nullptr;
};

/// The rows of the input, read until Ctrl-C, while the copy is written. Throws Error where -o or --save would replace a file.
struct LiveStream {
  LiveStream(const LiveOptions& options, const RecordingSource& source);
  LiveInput input;
  LiveCopy copy;
  CtrlC ctrl_c;
  RecordingStream rows;
};

/// Standard output, or standard error where the calibration is written to that.
std::FILE* output_of(const LiveOptions& options);
std::string name_of_stream(const LiveOptions& options);

/// The session of the stream alone. Throws Error where its columns are not known, or those of a triad.
Session session_of_stream(const LiveOptions& options);

/// The calibration of what came, with where it comes from, into the file of -o.
void write_live(const LiveOptions& options, Calibration calibration, const Recording& recording, Session session);

/// "14 rests in 108 s: good; written: calibration.json", after the warnings.
void summarize_live(const LiveOptions& options, const Quality& quality, const std::string& what);

/// Warns of Ctrl-C, what the stream left out, and gaps, which `consequence` follows.
void warn_of_stream(const RecordingStream& stream, const Recording& recording, const std::string& consequence);

/// Until everything is reached or nothing more comes; the error that ended the stream, if one did. `show(event)`: after each row that arrived, and
/// after each estimate.
template <class Progress, class Show>
std::exception_ptr follow(RecordingStream& stream, Progress& progress, const Show& show) {
  try {
    while (const std::optional<Recording> piece = stream.next()) {
      for (std::optional<Range> left = Range{0, piece->size()}; left;) {
        left = progress.add(*piece, *left);
        show(left.has_value());
        if (left && progress.reached()) return {};
      }
    }
  } catch (const Error&) {
    return std::current_exception();
  }
  return {};
}

/// Of extrinsics, while moving one IMU of the body.
void run_live_extrinsics(const LiveOptions& options);
/// Of a method with aids, while driving.
void run_live_drive(const LiveOptions& options);

}  // namespace imulab::command
