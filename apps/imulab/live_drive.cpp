// imulab live - --method drive: which coefficients the drive has shown so far, and which manoeuvre shows the rest.
#include "imulab/tasks/live_drive.hpp"

#include "apps/imulab/files.hpp"
#include "apps/imulab/live_stream.hpp"
#include "imulab/recording/clock.hpp"
#include "imulab/recording/readings.hpp"

#include <fmt/core.h>

#include <cstdio>

namespace imulab::command {
namespace {

/// Lines for each estimate.
void show_drive(const LiveOptions& options, const LiveDriveView& view) {
  print(options.json ? live_drive_json(view) : live_drive_lines(view), output_of(options));
  std::fflush(output_of(options));
}

void summarize_drive(const LiveOptions& options, const LiveDrive& drive) {
  summarize_live(options, drive.result()->calibration.quality, fmt::format("{:.0f} s", drive.view().time_s));
}

}  // namespace

void run_live_drive(const LiveOptions& options) {
  const Session session = session_of_stream(options);
  const RecordingSource& source = session.recordings.front();
  const std::vector<Requirement> required =
      options.require ? errors_at("--require", [&] { return parse_requirements(*options.require); }) : std::vector<Requirement>();
  LiveDrive drive(method(options.method), session, recording_options(source), required);
  LiveStream stream(options, source);
  const std::exception_ptr failure = follow(stream.rows, drive, [&](bool estimated) {
    if (estimated) show_drive(options, drive.view());
  });
  if (!drive.reached() && drive.view().samples > 1) {
    drive.estimate();
    show_drive(options, drive.view());
  }
  warn_of_stream(stream.rows, drive.recording(), "");
  if (drive.result()) {
    write_live(options, drive.result()->calibration, drive.recording(), session);
    summarize_drive(options, drive);
  }
  if (failure) std::rethrow_exception(failure);
  if (drive.view().samples < 2) throw Unsupported(fmt::format("{}: fewer than two rows arrived; expected a stream of them", name_of_stream(options)));
  if (const std::string missing = shortcomings(drive); !missing.empty()) throw Unsupported(missing);
}

}  // namespace imulab::command
