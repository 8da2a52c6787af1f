// imulab live - --method extrinsics: what the motion of one IMU has shown so far of where another one on its body is.
#include "apps/imulab/live_stream.hpp"
#include "imulab/core/memory.hpp"
#include "imulab/extrinsics.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/results/extrinsics.hpp"
#include "imulab/tasks/growing_recording.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <utility>
#include <vector>

namespace imulab::command {
namespace {

class LiveMotion {
 public:
  LiveMotion(const Session& session, RecordingOptions options)
      : name_(session.imu.name), grade_(session.imu.grade.value_or("mems")), options_(std::move(options)) {}

  std::optional<Range> add(const Recording& piece, Range samples) {
    const std::optional<Range> left = all_.add(piece, samples);
    if (left) predict();
    return left;
  }
  void predict() {
    constexpr double most_memory = 10;  // over what came: another IMU's readings, and the fit of the seconds with most motion
    expect_memory(most_memory * static_cast<double>(all_.samples().bytes()), fmt::format("a prediction while {:.0f} s arrive", time_s()));
    recording = completed(all_.samples(), options_);
    try {
      found = predict_extrinsics({.name = name_, .recording = recording, .grade = grade_});
      missing = found->from_first.front().not_shown;
    } catch (const Unsupported& e) {
      found.reset(), missing = {e.what()};
    }
  }
  bool reached() const { return false; }
  double time_s() const { return all_.time_s(); }

  Recording recording;  ///< so far
  std::optional<Extrinsics> found;
  std::vector<std::string> missing;

 private:
  std::string name_, grade_;
  RecordingOptions options_;
  GrowingRecording all_{5};
};

void show_motion(const LiveOptions& options, const LiveMotion& motion) {
  const std::string headline = motion.found ? conclusion_of(*motion.found).headline : "";
  if (options.json) {
    std::vector<JsonValue> u;
    if (motion.found)
      for (int row = 0; row < Mounting::rows; ++row) u.emplace_back(motion.found->from_first.front().uncertainty(row));
    const JsonFields event{{{"time_s", motion.time_s()}, {"headline", headline}, {"standard_uncertainty", u}, {"not_shown", motion.missing}}};
    print(fields_json(event, true));
  } else {
    std::vector<std::string> said;
    if (!headline.empty()) said.push_back(headline);
    if (!motion.missing.empty()) said.push_back(fmt::format("not shown: {}", fmt::join(motion.missing, ", ")));
    print(text::wrapped(fmt::format("{:8.2f} s  ", motion.time_s()), fmt::format("{}", fmt::join(said, "; "))));
  }
  std::fflush(stdout);
}

}  // namespace

void run_live_extrinsics(const LiveOptions& options) {
  if (!options.output.empty() || options.require || options.rest) throw Error("--output, --require, --rest: belong to a calibration");
  const Session session = session_of_stream(options);
  const RecordingSource& source = session.recordings.front();
  LiveMotion motion(session, recording_options(source));
  LiveStream stream(options, source);
  const std::exception_ptr failure = follow(stream.rows, motion, [&](bool predicted) {
    if (predicted) show_motion(options, motion);
  });
  if (motion.time_s() > 0) motion.predict(), show_motion(options, motion);
  warn_of_stream(stream.rows, motion.recording, "");
  if (failure) std::rethrow_exception(failure);
  if (!motion.found || !motion.missing.empty())
    throw Unsupported(fmt::format("{}: not shown by this motion: {}", name_of_stream(options), fmt::join(motion.missing, ", ")));
}

}  // namespace imulab::command
