// imulab compensate CALIBRATION - --session SESSION -o OUT: rows are written as they arrive.
#include "apps/imulab/command.hpp"
#include "apps/imulab/compensate.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/session_recording.hpp"
#include "apps/imulab/usable.hpp"
#include "imulab/core/error.hpp"
#include "imulab/formats/recording/csv_writer.hpp"
#include "imulab/formats/recording/stream.hpp"
#include "imulab/recording/compensate_recording.hpp"
#include "imulab/tasks/recordings.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <unistd.h>

namespace imulab::command {

namespace {

/// The output, a file or standard output. It is created with the first rows.
class Rows {
 public:
  explicit Rows(std::string output) : output_(std::move(output)) {}
  ~Rows() {
    if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  }
  Rows(const Rows&) = delete;
  Rows& operator=(const Rows&) = delete;

  void write(const CompensatedRecording& c) {
    counts_.samples += c.recording.size(), counts_.saturated += c.recording.saturated.size();
    counts_.out_of_range += c.out_of_range.size(), counts_.replaced += c.replaced.size();
    if (c.recording.size() == 0) return;
    std::string text = compensated_rows(c, true);
    if (file_ == nullptr) {
      file_ = output_ == "-" ? stdout : std::fopen(output_.c_str(), "wb");
      text = compensated_header(true) + text;
    }
    if (file_ == nullptr || std::fwrite(text.data(), 1, text.size(), file_) != text.size() || std::fflush(file_) != 0)
      throw Error((output_ == "-" ? "standard output" : "-o " + output_) + ": cannot be written");
  }
  CompensatedFile counts() const {
    CompensatedFile counts = counts_;
    counts.file = output_;
    return counts;
  }

 private:
  std::string output_;
  std::FILE* file_ = nullptr;
  CompensatedFile counts_ = {};
};

}  // namespace

void compensate_stream(const CompensateOptions& options) {
  if (options.stream_session.empty()) throw Error("the columns of standard input are not known; expected --session");
  if (!options.report.empty()) throw Error("--report: belongs to recordings in files; expected a session in place of -");
  if (options.output != "-" && std::filesystem::path(options.output).extension() != ".csv")
    throw Error(fmt::format("-o {}: expected a .csv file, or - for standard output", options.output));
  const Calibration calibration = read_usable(options.calibration, options.allow_undetermined);
  will_write("-o", options.output);
  const Session session = session_at(options.stream_session);
  const RecordingSource& source = named_recording(session, options.recording);
  check_thermal_units(calibration, source);

  RecordingStream stream(STDIN_FILENO, "standard input", source);
  Compensator compensator(calibration.model, options.outliers);
  Rows rows(options.output);
  try {
    while (auto piece = stream.next()) rows.write(compensator.next(*std::move(piece)));
  } catch (const Error&) {
    rows.write(compensator.rest());  // the rows before the wrong one
    throw;
  }
  rows.write(compensator.rest());

  for (const std::string& text : stream.warnings()) warn(text);
  if (const auto n = rows.counts().out_of_range; n > 0)
    warn(fmt::format("standard input: {} of {} samples are outside the calibrated temperatures", n, rows.counts().samples));
  if (options.output != "-") print_counts(options, {options.calibration, calibration.imu, calibration.quality, {rows.counts()}});
}

}  // namespace imulab::command
