// imulab compensate CALIBRATION SESSION -o OUT
#include "imulab/compensate.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/text/stream.hpp"
#include "imulab/formats/recording/written/compensated_file.hpp"
#include "imulab/formats/recording/written/csv_writer.hpp"
#include "imulab/formats/session/file.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/report/recording_page.hpp"
#include "imulab/results/compensation.hpp"
#include "imulab/results/conclusion.hpp"
#include "imulab/tasks/inspect.hpp"
#include "imulab/tasks/usable.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <unistd.h>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct CompensateOptions : ShowOptions {
  std::string calibration, session;
  std::vector<std::string> declarations, topics;  ///< of a recording without a session
  Outliers outliers = Outliers::keep;
  bool reject_outliers = false, allow_undetermined = false;
  std::string stream_session, recording;  ///< of a stream
};

/// "out.csv: 100 samples, 0 saturated, 0 outside the calibrated temperatures", with the outliers if they are rejected; or as JSON.
void print_counts(const CompensateOptions& options, const CompensationSummary& summary, const std::vector<std::string>& warnings) {
  if (options.json) return print_json(with_conclusion(compensation_json(summary), conclusion_of(summary), warnings));
  for (const CompensatedFile& c : summary.files)
    print(text::wrapped(
        "", fmt::format("{}: {} samples, {} saturated, {} outside the calibrated temperatures{}", one_line(c.file), c.samples, c.saturated,
                        c.out_of_range, options.outliers == Outliers::reject ? fmt::format(", {} with an outlier replaced", c.replaced) : "")));
}

CompensatedRecording compensated(const Calibration& calibration, const Session& session, const RecordingSource& source, Outliers outliers) {
  CompensatedRecording out = compensate(calibration.model, read_for(calibration, session, source), outliers);
  if (!out.out_of_range.empty())
    warn(fmt::format("{}: {} of {} samples are outside the calibrated temperatures", source.file, out.out_of_range.size(), out.recording.size()));
  return out;
}

bool is_one_file(const fs::path& output) {
  return output.extension() == ".csv" || output.extension() == ".npz" || output == "-" || is_bag_name(output);
}

/// The output file of each recording: a .csv or .npz file or a bag for one, else files named like the recordings in a folder.
std::vector<fs::path> output_files(const Session& session, const fs::path& output) {
  const bool one_file = is_one_file(output);
  for (const char* other : {".mat", ".h5", ".hdf5", ".npy", ".ulg", ".bin", ".txt"})
    if (output.extension() == other)
      throw Error(fmt::format("-o {}: {} files are not written; expected .csv, .npz, a bag or a folder", output.string(), other));
  if (one_file && session.recordings.size() > 1)
    throw Error(fmt::format("-o {}: the session has {} recordings; expected a folder", output.string(), session.recordings.size()));
  if (one_file) return {output};
  if (fs::exists(output) && !fs::is_directory(output))
    throw Error(fmt::format("-o {}: exists and is not a folder; expected a folder, a .csv or .npz file, or a bag", output.string()));
  std::vector<fs::path> files;
  for (const auto& recording : session.recordings) {
    fs::path file = output / fs::path(recording.file).filename().replace_extension(".csv");
    if (std::find(files.begin(), files.end(), file) != files.end())
      throw Error(
          fmt::format("-o {}: two recordings would both be written to {}; expected different names", output.string(), file.filename().string()));
    files.push_back(std::move(file));
  }
  return files;
}

/// As a table, as arrays, or as the bag that it came from.
void write_compensated(const fs::path& file, const Session& session, const RecordingSource& source, const CompensatedRecording& c) {
  if (file.extension() == ".npz") return write_compensated_npz(file, c);
  {
    const Progress progress("writing");
    if (!is_bag_name(file)) return write_compensated_rows(file, c);
    write_compensated_bag(file, session, source, c);
  }
  if (const std::size_t flags = c.recording.saturated.size() + c.out_of_range.size() + c.replaced.size(); flags > 0)
    warn(fmt::format(
        "{}: messages have no flags: {} saturated, {} outside the calibrated temperatures and {} replaced samples are in it like the others",
        file.string(), c.recording.saturated.size(), c.out_of_range.size(), c.replaced.size()));
}

CompensatedFile summary_of(const fs::path& file, const CompensatedRecording& c, bool pictures) {
  constexpr std::size_t intervals = 1500;
  const Recording& r = c.recording;
  CompensatedFile out{file.string(), r.size(), r.saturated.size(), c.out_of_range.size(), c.replaced.size(), r.name, 1 / r.interval_s, r.gaps.size()};
  if (pictures) out.overview = overview(SensorModel{}, r, intervals);
  return out;
}

void compensate_files(const CompensateOptions& options) {
  if (!options.stream_session.empty() || !options.recording.empty())
    throw Error("--session and --recording belong to standard input; expected - in place of the session");
  const auto [calibration, warnings] = read_usable(options.calibration, options.allow_undetermined);
  const Session session = open_session(options.session, {options.declarations, options.topics}, numbers_inspected, Purpose::compensation);
  if (session.recordings.empty()) throw Error(session.file + ": has no recordings; expected at least one");
  const std::vector<fs::path> files = output_files(session, options.output);
  for (const fs::path& file : files) will_write("-o", file);
  std::vector<CompensatedRecording> recordings;  // all are compensated before any is written
  for (const auto& source : session.recordings) recordings.push_back(compensated(calibration, session, source, options.outliers));
  std::optional<NewFolder> folder;
  if (!is_one_file(options.output)) {
    folder.emplace(options.output, NewFolder::Existing::add);
  } else if (files[0].has_parent_path()) {
    std::error_code failure;
    fs::create_directories(files[0].parent_path(), failure);
    if (failure) throw Error(fmt::format("-o {}: the folder cannot be created: {}", options.output, failure.message()));
  }
  CompensationSummary summary{.calibration_file = options.calibration, .imu = calibration.imu, .quality = calibration.quality, .files = {}};
  for (std::size_t i = 0; i < files.size(); ++i) {
    write_compensated(folder ? folder->path() / files[i].filename() : files[i], session, session.recordings[i], recordings[i]);
    summary.files.push_back(summary_of(files[i], recordings[i], options.json || !options.report.empty()));
  }
  if (folder) folder->commit();
  if (files[0] != "-") print_counts(options, summary, warnings);
  if (!options.report.empty()) write_whole(options.report, compensation_page(summary));
}

// ---- a stream: rows are written as they arrive

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

/// Standard input to standard output or a file, row by row.
void compensate_stream(const CompensateOptions& options) {
  if (options.stream_session.empty()) throw Error("the columns of standard input are not known; expected --session");
  if (!options.report.empty()) throw Error("--report: belongs to recordings in files; expected a session in place of -");
  if (options.output != "-" && std::filesystem::path(options.output).extension() != ".csv")
    throw Error(fmt::format("-o {}: expected a .csv file, or - for standard output", options.output));
  const auto [calibration, warnings] = read_usable(options.calibration, options.allow_undetermined);
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

  warn_each(stream.warnings());
  if (const auto n = rows.counts().out_of_range; n > 0)
    warn(fmt::format("standard input: {} of {} samples are outside the calibrated temperatures", n, rows.counts().samples));
  if (options.output != "-") print_counts(options, {options.calibration, calibration.imu, calibration.quality, {rows.counts()}}, warnings);
}

}  // namespace

void add_compensate(Verb& app) {
  const auto options = std::make_shared<CompensateOptions>();
  Verb& verb = app.verb("compensate", "Apply a calibration: raw recordings to angular rates and specific forces in SI");
  verb.option("CALIBRATION", options->calibration, "calibration.json").required().reads();
  verb.option(
          "SESSION", options->session,
          "a session folder or its session.toml; a recording, which is inspected first; - for rows on standard input, as --session describes them")
      .required()
      .reads();
  verb.option("-o,--output FILE", options->output,
              "a folder; for one recording also a .csv or .npz file, the bag that it is (.bag, .mcap, .db3), or - for standard output")
      .required();
  allow_undetermined_option(verb, options->allow_undetermined);
  verb.option("--reject-outliers", options->reject_outliers, "first replace spikes of one or two samples");
  report_option(verb, options->report);
  verb.option("--session SESSION", options->stream_session, "the session that describes the stream: its columns").reads();
  verb.option("--recording FILE", options->recording, "the recording to use, if the session has several");
  topics_option(verb, options->topics);
  declarations_option(verb, options->declarations);
  json_option(verb, options->json, "print what was written as JSON");
  verb.example("imulab compensate calibration.json session -o compensated.csv");
  verb.example("imulab compensate calibration.json session -o compensated.mcap");
  verb.example("producer | imulab compensate calibration.json - --session session -o -");
  verb.does = [options] {
    if (options->json && options->output == "-") throw Error("--json: standard output has the rows; expected -o FILE");
    if (options->reject_outliers) options->outliers = Outliers::reject;
    if (options->session == "-")
      compensate_stream(*options);
    else
      compensate_files(*options);
  };
}

}  // namespace imulab::command
