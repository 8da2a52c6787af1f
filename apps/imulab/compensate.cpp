// imulab compensate CALIBRATION SESSION -o OUT
#include "imulab/analysis/compensate_recording.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/io/compensated_file.hpp"
#include "imulab/io/file.hpp"
#include "imulab/io/session_file.hpp"

#include <fmt/core.h>

#include "apps/imulab/command.hpp"
#include "apps/imulab/session_recording.hpp"
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

struct Options {
  std::string calibration, session, output;
};

CompensatedRecording compensated(const Calibration& calibration, const Session& session, const RecordingSource& source) {
  CompensatedRecording out = compensate(calibration.model, read_for(calibration, session, source));
  if (!out.out_of_range.empty())
    warn(fmt::format("{}: {} of {} samples are outside the temperatures the calibration saw", source.file, out.out_of_range.size(),
                     out.recording.size()));
  return out;
}

/// Where each recording goes: a .csv file for one, else files named like the recordings in a folder.
std::vector<fs::path> output_files(const Session& session, const fs::path& output) {
  const bool one_file = output.extension() == ".csv" || output == "-";
  if (one_file && session.recordings.size() > 1)
    throw Error(fmt::format("-o {}: the session has {} recordings, expected a folder", output.string(), session.recordings.size()));
  if (one_file) return {output};
  if (fs::exists(output) && !fs::is_directory(output))
    throw Error(fmt::format("-o {}: exists and is not a folder; expected a folder or a .csv file", output.string()));
  std::vector<fs::path> files;
  for (const auto& recording : session.recordings) {
    fs::path file = output / fs::path(recording.file).filename().replace_extension(".csv");
    if (std::find(files.begin(), files.end(), file) != files.end())
      throw Error(fmt::format("-o {}: two recordings would both become {}", output.string(), file.filename().string()));
    files.push_back(std::move(file));
  }
  return files;
}

/// The raw data are never overwritten.
void check_inputs_stay(const Options& options, const Session& session, const std::vector<fs::path>& outputs) {
  std::vector<fs::path> inputs{options.calibration, session.file};
  for (const auto& recording : session.recordings)
    for (const auto& file : {std::optional(recording.file), recording.gyro.file, recording.accel.file})
      if (file) inputs.push_back(session_path(session, *file));
  for (const auto& output : outputs)
    for (const auto& input : inputs)
      if (fs::exists(output) && fs::exists(input) && fs::equivalent(output, input))
        throw Error(fmt::format("-o {}: would overwrite {}, expected another place", options.output, input.string()));
}

void write(const fs::path& file, const CompensatedRecording& recording) {
  const std::string text = compensated_text(recording);
  if (file == "-") {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) throw Error("standard output cannot be written");
    return;
  }
  write_whole(file, text);
  fmt::print("{}: {} samples, {} saturated, {} outside the calibrated temperatures\n", file.string(), recording.recording.size(),
             recording.recording.saturated.size(), recording.out_of_range.size());
}

void run(const Options& options) {
  const Calibration calibration = read_calibration(options.calibration);
  const Session session = read_session(options.session);
  if (session.recordings.empty()) throw Error(session.file + ": has no recordings, expected a session with at least one");
  const std::vector<fs::path> files = output_files(session, options.output);
  check_inputs_stay(options, session, files);
  std::vector<CompensatedRecording> recordings;  // all are compensated before any is written
  for (const auto& source : session.recordings) recordings.push_back(compensated(calibration, session, source));
  if (files[0].has_parent_path()) {
    std::error_code failure;
    fs::create_directories(files[0].parent_path(), failure);
    if (failure) throw Error(fmt::format("-o {}: cannot make the folder: {}", options.output, failure.message()));
  }
  for (std::size_t i = 0; i < files.size(); ++i) write(files[i], recordings[i]);
}

}  // namespace

void add_compensate(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* const verb = app.add_subcommand("compensate", "Raw recordings -> angular rates and specific forces in SI");
  verb->add_option("CALIBRATION", options->calibration, "calibration.json")->required();
  verb->add_option("SESSION", options->session, "a session folder or its session.toml")->required();
  verb->add_option("-o,--output", options->output, "a folder; for one recording also a .csv file, or - for standard output")->required();
  verb->callback([options] { run(*options); });
}

}  // namespace imulab::command
