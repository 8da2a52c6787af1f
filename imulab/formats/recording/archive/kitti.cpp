// KITTI's raw data (Geiger et al., IJRR 2013): a folder oxts of an OXTS RT 3003, with timestamps.txt, a time a line, and data/, a file of 30 numbers
// for each of these lines. As a text of one table, which is read as any other.
#include "imulab/core/text.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/archive/text_tables.hpp"
#include "imulab/formats/text/date.hpp"
#include "imulab/formats/text/several_files.hpp"
#include "imulab/formats/text/take_until.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <system_error>

namespace imulab::recording_io {
namespace {

namespace fs = std::filesystem;

/// As the data set's dataformat.txt has them: x forward, y left, z up; f, l, u along and across the earth's surface. Names of the position and its
/// accuracy follow the velocities.
constexpr std::string_view oxts_header =
    "timestamp_ns,lat,lon,alt,roll,pitch,yaw,vn,ve,vf,vl,vu,accel.x [m/s^2],accel.y [m/s^2],accel.z [m/s^2],af,al,au,gyro.x [rad/s],gyro.y [rad/s],"
    "gyro.z [rad/s],wf,wl,wu,pos_accuracy,vel_accuracy,navstat,numsats,posmode,velmode,orimode\n";
constexpr std::size_t oxts_fields = 30;

/// The folder oxts: the path itself, or in it.
std::optional<fs::path> oxts_folder(const fs::path& path) {
  std::error_code none;
  for (const fs::path& folder : {path, path / "oxts"})
    if (fs::is_regular_file(folder / "timestamps.txt", none) && fs::is_directory(folder / "data", none)) return folder;
  return std::nullopt;
}

/// "2011-09-26 13:02:25.964389445" in nanoseconds since 1970.
std::optional<std::int64_t> oxts_time_ns(std::string_view line) {
  const text::Moment moment = text::moment_of(line);
  if (!moment.has_date || !moment.has_time || moment.fraction.size() > 9) return std::nullopt;
  std::string digits(moment.fraction);
  digits.resize(9, '0');
  std::int64_t fraction = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), fraction);
  return moment.seconds * 1'000'000'000 + fraction;
}

/// The numbers of a file with one line, each after a comma.
std::string oxts_row(const fs::path& file) {
  constexpr std::uintmax_t longest = 4096;
  std::error_code none;
  if (fs::file_size(file, none) > longest)
    throw Error(fmt::format("{}: is longer than a line of {} numbers; expected one", file.string(), oxts_fields));
  const MappedFile mapped(file);
  std::string_view all = mapped.text(), line = trimmed(text::take_until(all, '\n'));
  std::string row;
  std::size_t fields = 0;
  while (!line.empty())
    if (const std::string_view field = text::take_until(line, ' '); !field.empty()) row += "," + std::string(field), ++fields;
  if (fields != oxts_fields) throw Error(fmt::format("{}:1: has {} fields; expected the {} of an OXTS record", file.string(), fields, oxts_fields));
  return row;
}

std::string oxts_text(const fs::path& folder, std::uint64_t most) {
  const MappedFile stamps(folder / "timestamps.txt");
  std::string_view lines = stamps.text();
  std::string text(oxts_header);
  std::size_t number = 0;
  for (const fs::path& file : files_of(folder / "data")) {
    if (file.extension() != ".txt") continue;
    const std::string_view line = trimmed(text::take_until(lines, '\n'));
    const auto time_ns = oxts_time_ns(line);
    ++number;
    if (!time_ns)
      throw Error(fmt::format("{}:{}: expected a time such as 2011-09-26 13:02:25.964389445 for {}", (folder / "timestamps.txt").string(), number,
                              file.filename().string()));
    text += fmt::format("{}{}\n", *time_ns, oxts_row(file));
    if (text.size() > most) break;
  }
  return text;
}

std::vector<TextMember> texts_of_oxts(const fs::path& path) {
  const fs::path folder = oxts_folder(path).value();
  const std::vector<fs::path> files = files_of(folder / "data");
  const std::uint64_t bytes = files.size() * std::uint64_t{300};  // of a row, about
  return {{"oxts", bytes, [folder](std::uint64_t most) {
             return TextTable(most == whole_text ? folder / "oxts.csv" : folder / "oxts.csv (its beginning)", oxts_text(folder, most));
           }}};
}

}  // namespace

RecordingFormat kitti_oxts_format() {
  RecordingFormat row = text_tables_row<texts_of_oxts>("KITTI oxts folder");
  row.recognizes_path = [](const fs::path& path) { return oxts_folder(path).has_value(); };
  return row;
}

}  // namespace imulab::recording_io
