#include "imulab/tasks/given_files.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/results/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>
#include <variant>

namespace imulab {
namespace {

namespace fs = std::filesystem;

template <class... Functions>
struct ByKind : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
ByKind(Functions...) -> ByKind<Functions...>;

/// What a saved result is, and what takes it.
std::string described_result(const SavedResult& result) {
  return std::visit(ByKind{[](const Calibration& c) {
                             return fmt::format("a calibration ({}{}), which compensate, compare, export, navigate, report and verify take", c.imu,
                                                c.method.empty() ? "" : ", method " + c.method);
                           },
                           [](const NoiseAnalysis&) {
                             return std::string("an analysis of noise, which report takes, and a session as noise = \"FILE\" of its [imu]");
                           },
                           [](const NoiseBatch&) { return std::string("an analysis of the noise of several logs, which report takes"); },
                           [](const Extrinsics&) { return std::string("a set of extrinsics, which report and export take"); },
                           [](const auto&) { return std::string("a saved result, which report and compare take"); }},
                    result);
}

/// Throws Error for a result that was saved before. A recording may be JSON, too: a list, or a line a row.
void expect_no_result(const std::string& file, std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || text[first] != '{' || text.size() > most_copied) return;
  std::optional<SavedAnswer> saved;
  try {
    saved = parse_answer(text, file);
  } catch (const Error&) {
    return;
  }
  throw Error(fmt::format("{}: is {}; expected a recording: the readings of an IMU", file, described_result(saved->result)));
}

/// Adds a file that is no stream and is there.
void add_given(GivenFiles& given, const std::string& file) {
  const MappedFile mapped(file);
  const std::string_view text = mapped.text();
  if (is_session_text(text)) {
    if (!given.session.empty()) throw Error(fmt::format("{} and {}: are two sessions; expected one, or recordings", given.session, file));
    given.session = file;
  } else if (fs::path(file).extension() == ".toml") {
    throw Error(file + ": is no session, and no recording: settings; expected a recording, or format = \"imulab.session/1\"");
  } else if (const auto kind = aid_io::kind_of_aid(file)) {
    given.aids.push_back({.kind = *kind, .file = file});
  } else {
    expect_no_result(file, text);
    given.recordings.push_back(file);
  }
}

}  // namespace

bool is_session_text(std::string_view text) {
  text = text.substr(0, std::size_t{1} << 16);
  if (text.find('\0') != std::string_view::npos) return false;
  const auto takes = [](std::string_view& line, std::string_view word) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (!line.starts_with(word)) return false;
    line.remove_prefix(word.size());
    return true;
  };
  for (std::size_t begin = 0, end = 0; end != std::string_view::npos; begin = end + 1) {
    end = text.find('\n', begin);
    std::string_view line = text.substr(begin, end - begin);
    if (takes(line, "format") && takes(line, "=") && (takes(line, "\"imulab.session/") || takes(line, "'imulab.session/"))) return true;
  }
  return false;
}

GivenFiles given_files(const std::vector<std::string>& files) {
  GivenFiles given;
  for (const std::string& file : files) {
    std::error_code none;
    const fs::path in_folder = fs::path(file) / "session.toml";
    if (fs::exists(in_folder, none))
      add_given(given, in_folder.string());
    else if (file == "-" || is_several_files(file) || !fs::is_regular_file(file, none) || is_kept(file))
      given.recordings.push_back(file);  // what is not there is said where it is read
    else
      add_given(given, file);
  }
  return given;
}

}  // namespace imulab
