// imulab live - --method extrinsics: what the motion of one IMU has shown so far of where another one on its body is.
#include "apps/imulab/live_stream.hpp"
#include "imulab/extrinsics.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/results/extrinsics.hpp"

#include <fmt/format.h>

#include <algorithm>
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
    const double start_s = all_.size() > 0 ? all_.time_s(0) : piece.time_s(samples.begin);
    std::size_t end = samples.begin;
    while (end < samples.end && piece.time_s(end) - start_s < next_s_) ++end;
    const bool due = end < samples.end;
    if (due) ++end;
    append(all_, piece, {samples.begin, end});
    time_s = all_.time_s(all_.size() - 1) - start_s;
    if (!due) return std::nullopt;
    predict();
    constexpr double least_s = 5, part = 0.1;  // predictions take longer the longer it is
    next_s_ = time_s + std::max(least_s, part * time_s);
    return Range{end, samples.end};
  }
  void predict() {
    recording = completed(all_, options_);
    try {
      found = predict_extrinsics({.name = name_, .recording = recording, .grade = grade_});
      missing = found->from_first.front().not_shown;
    } catch (const Unsupported& e) {
      found.reset(), missing = {e.what()};
    }
  }
  bool reached() const { return false; }

  Recording recording;  ///< so far
  std::optional<Extrinsics> found;
  std::vector<std::string> missing;
  double time_s = 0;

 private:
  std::string name_, grade_;
  RecordingOptions options_;
  Recording all_;  ///< as it arrived
  double next_s_ = 10;
};

void show_motion(const LiveOptions& options, const LiveMotion& motion) {
  const std::string headline = motion.found ? conclusion_of(*motion.found).headline : "";
  if (options.json) {
    std::vector<JsonValue> u;
    if (motion.found)
      for (int row = 0; row < Mounting::rows; ++row) u.emplace_back(motion.found->from_first.front().uncertainty(row));
    const JsonFields event{{{"time_s", motion.time_s}, {"headline", headline}, {"standard_uncertainty", u}, {"not_shown", motion.missing}}};
    print(fields_json(event, true));
  } else {
    std::vector<std::string> said;
    if (!headline.empty()) said.push_back(headline);
    if (!motion.missing.empty()) said.push_back(fmt::format("not shown: {}", fmt::join(motion.missing, ", ")));
    print(text::wrapped(fmt::format("{:8.2f} s  ", motion.time_s), fmt::format("{}", fmt::join(said, "; "))));
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
  if (motion.time_s > 0) motion.predict(), show_motion(options, motion);
  warn_of_stream(stream.rows, motion.recording, "");
  if (failure) std::rethrow_exception(failure);
  if (!motion.found || !motion.missing.empty())
    throw Unsupported(fmt::format("{}: not shown by this motion: {}", name_of_stream(options), fmt::join(motion.missing, ", ")));
}

}  // namespace imulab::command
