// NovAtel's BESTPOS and BESTVEL in ASCII (https://docs.novatel.com/OEM7/Content/Logs/BESTPOS.htm and BESTVEL.htm): a head, the fields behind a
// semicolon, and a checksum, which is CRC-32 that begins with zero and is not inverted.
#include "imulab/error.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace imulab::aid_io {
namespace {

/// A log taken apart where its checksum is right.
struct BestLog {
  std::string_view name;
  std::vector<std::string_view> head, fields;
};

std::optional<BestLog> intact_log(std::string_view line) {
  const std::size_t star = line.rfind('*'), colon = line.find(';');
  if (star == std::string_view::npos || colon > star || line.size() - star < 9) return std::nullopt;
  const std::string_view body = line.substr(1, star - 1);
  std::uint32_t stated = 0;
  const char* const digits = line.data() + star + 1;
  if (std::from_chars(digits, digits + 8, stated, 16).ptr != digits + 8) return std::nullopt;
  if (~recording_io::crc32(body, ~std::uint32_t{0}) != stated) return std::nullopt;
  BestLog log{{}, parts_of(line.substr(1, colon - 1), ",", true), parts_of(line.substr(colon + 1, star - colon - 1), ",", true)};
  log.name = log.head[0];
  return log;
}

class BestReader {
 public:
  explicit BestReader(std::string file) { out_.file = std::move(file), out_.scale = TimeScale::gps; }

  void read(std::string_view line, std::size_t number) {
    if (!line.starts_with("#BESTPOSA,") && !line.starts_with("#BESTVELA,")) return;
    AidRow row;
    row.line = number;
    const auto log = intact_log(line);
    const auto time = log && log->head.size() > 6 ? time_of_week(log->head[5], log->head[6]) : std::nullopt;
    if (!time) return void(++damaged_);
    row.time = *time;
    if (log->fields[0] != "SOL_COMPUTED") return void(++without_fix_);
    const bool good = log->name == "BESTPOSA" ? read_position(log->fields, row) : read_velocity(log->fields, row);
    good ? out_.rows.push_back(row) : void(++damaged_);
  }

  AidRows take() {
    if (damaged_ > 0) out_.warnings.push_back(fmt::format("{}: {} logs are damaged (checksum, or fields) and are left out", out_.file, damaged_));
    if (without_fix_ > 0) out_.warnings.push_back(fmt::format("{}: {} logs without a solution are left out", out_.file, without_fix_));
    // A velocity is of a time before that of its log.
    std::stable_sort(out_.rows.begin(), out_.rows.end(), [](const AidRow& a, const AidRow& b) { return a.time < b.time; });
    return std::move(out_);
  }

 private:
  bool read_position(const std::vector<std::string_view>& f, AidRow& row) {
    if (f.size() < 10) return false;
    if (f[6] != "WGS84")
      throw Error(fmt::format("{}: positions in the datum {}; expected WGS84 (NovAtel's command DATUM WGS84)", out_.place(row), excerpt(f[6])));
    // The height is above sea level, and the undulation that of the geoid.
    std::array<double, 7> numbers{};
    constexpr std::array<std::size_t, 7> at{2, 3, 4, 5, 7, 8, 9};
    for (std::size_t k = 0; k < at.size(); ++k) {
      const auto number = number_of(f[at[k]]);
      if (!number) return false;
      numbers[k] = *number;
    }
    row.position = {numbers[0] * unit::deg, numbers[1] * unit::deg, numbers[2] + numbers[3]};
    row.position_sigma = {numbers[5], numbers[4], numbers[6]};
    return true;
  }
  static bool read_velocity(const std::vector<std::string_view>& f, AidRow& row) {
    if (f.size() < 7) return false;
    const auto latency = nanoseconds_of_text(f[2]);
    const auto speed = number_of(f[4]), course = number_of(f[5]), up = number_of(f[6]);
    if (!latency || !speed || !course || !up || std::abs(*latency) > 10'000'000'000) return false;
    row.time -= *latency;
    row.velocity = {*speed * std::sin(*course * unit::deg), *speed * std::cos(*course * unit::deg), *up};
    return true;
  }

  AidRows out_;
  std::size_t damaged_ = 0, without_fix_ = 0;
};

AidRows read_best(const AidRequest& request) {
  expect_gnss(request, "a receiver's log (NovAtel)");
  const MappedFile file(request.file);
  BestReader reader(input_name(request.file));
  for (AidLines lines(file.text()); lines.next();) reader.read(lines.line(), lines.number());
  return reader.take();
}

bool is_best(std::string_view head) { return head.find("#BESTPOSA,") != std::string_view::npos || head.find("#BESTVELA,") != std::string_view::npos; }

}  // namespace

AidFormat novatel_solution_format() { return {"NovAtel's BESTPOS and BESTVEL in ASCII", is_best, read_best}; }

}  // namespace imulab::aid_io
