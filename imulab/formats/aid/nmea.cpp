// NMEA 0183, as receivers log it: GGA (position), RMC (date, velocity), VTG (velocity) and GST (standard deviations), of any talker. NMEA 0183
// version 4.11; receivers' manuals have the sentences (u-blox 8 protocol specification, section 31).
#include "imulab/error.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <charconv>
#include <chrono>
#include <cmath>

namespace imulab::aid_io {
namespace {

constexpr double knot = 1852.0 / 3600, km_per_h = 1 / 3.6;  // m/s
constexpr std::int64_t day_ns = 86'400'000'000'000;

/// The sentence between $ and the checksum where that is right; nothing where it is damaged.
std::optional<std::string_view> intact_sentence(std::string_view line) {
  const std::size_t begin = line.find('$'), star = line.rfind('*');
  if (begin == std::string_view::npos || star == std::string_view::npos || star < begin || line.size() - star < 3) return std::nullopt;
  const std::string_view body = line.substr(begin + 1, star - begin - 1);
  unsigned stated = 0, sum = 0;
  const char* const digits = line.data() + star + 1;
  if (std::from_chars(digits, digits + 2, stated, 16).ptr != digits + 2) return std::nullopt;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  return sum == stated ? std::optional(body) : std::nullopt;
}

/// hhmmss.ss [ns since midnight]
std::optional<std::int64_t> time_of_day(std::string_view text) {
  const auto number = nanoseconds_of_text(text);
  if (!number || *number < 0) return std::nullopt;
  const std::int64_t whole = *number / 1'000'000'000, hours = whole / 10'000, minutes = whole / 100 % 100, seconds = whole % 100;
  if (hours > 23 || minutes > 59 || seconds > 60) return std::nullopt;
  return (hours * 3600 + minutes * 60 + seconds) * 1'000'000'000 + *number % 1'000'000'000;
}

/// ddmmyy [ns since 1970]
std::optional<std::int64_t> date_of(std::string_view text) {
  const auto number = number_of(text);
  if (!number || text.size() != 6 || *number < 0 || *number != std::floor(*number)) return std::nullopt;
  const int all = static_cast<int>(*number), year = all % 100;
  const std::chrono::year_month_day date{std::chrono::year(year < 80 ? 2000 + year : 1900 + year),
                                         std::chrono::month(static_cast<unsigned>(all / 100 % 100)),
                                         std::chrono::day(static_cast<unsigned>(all / 10'000))};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch().count() * day_ns;
}

/// ddmm.mmmm and N, S, E or W [rad]
std::optional<double> degrees_of(std::string_view text, std::string_view side) {
  const auto number = number_of(text);
  if (!number || *number < 0 || side.size() != 1) return std::nullopt;
  const double degrees = std::floor(*number / 100), minutes = *number - 100 * degrees;
  const double size = (degrees + minutes / 60) * unit::deg;
  return side == "S" || side == "W" ? -size : size;
}

class NmeaReader {
 public:
  explicit NmeaReader(std::string file) { out_.file = std::move(file), out_.scale = TimeScale::utc; }

  void read(std::string_view line, std::size_t number) {
    if (line.find('$') == std::string_view::npos) return;
    ++sentences_;
    const auto body = intact_sentence(line);
    if (!body) {
      ++damaged_;
      return;
    }
    const std::vector<std::string_view> f = parts_of(*body, ",", true);
    if (f[0].size() != 5) return;  // of one maker: $PUBX
    const std::string_view type = f[0].substr(2);
    AidRow row;
    row.line = number;
    const bool good = type == "GGA"   ? read_gga(f, row)
                      : type == "RMC" ? read_rmc(f, row)
                      : type == "VTG" ? read_vtg(f, row)
                                      : type == "GST" && read_gst(f, row);
    if (good) out_.rows.push_back(row);
  }

  AidRows take() {
    if (damaged_ > 0)
      out_.warnings.push_back(fmt::format("{}: {} of {} sentences are damaged (checksum) and are left out", out_.file, damaged_, sentences_));
    if (without_fix_ > 0) out_.warnings.push_back(fmt::format("{}: {} sentences without a fix are left out", out_.file, without_fix_));
    if (above_sea_ > 0)
      out_.warnings.push_back(
          fmt::format("{}: {} heights have no geoid separation: they are above sea level, up to 100 m from the ellipsoid", out_.file, above_sea_));
    if (!date_) {
      out_.scale = TimeScale::own;
      out_.warnings.push_back(out_.file + ": has no date (RMC): its times of day are taken as a clock of its own");
    } else {
      for (AidRow& row : out_.rows) row.time += first_date_;
    }
    return std::move(out_);
  }

 private:
  /// Puts the time of day; days are counted from the first date, or from the first midnight.
  bool put_time(std::string_view text, AidRow& row) {
    const auto time = time_of_day(text);
    if (!time) return false;
    if (last_ && *time < *last_ - day_ns / 2) ++days_;
    last_ = *time;
    row.time = days_ * day_ns + *time;
    time_ = row.time;
    return true;
  }
  bool read_gga(const std::vector<std::string_view>& f, AidRow& row) {
    if (f.size() < 12 || !put_time(f[1], row)) return false;
    const auto latitude = degrees_of(f[2], f[3]), longitude = degrees_of(f[4], f[5]), altitude = number_of(f[9]), geoid = number_of(f[11]);
    if (f[6].empty() || f[6] == "0" || !latitude || !longitude || !altitude) return ++without_fix_, false;
    if (geoid) geoid_ = geoid;
    row.position = {*latitude, *longitude, *altitude + geoid_.value_or(0)};
    if (!geoid_) ++above_sea_, widen_by_geoid(row);
    return true;
  }
  bool put_velocity(std::string_view speed, double unit, std::string_view course, AidRow& row) {
    const auto size = number_of(speed), angle = number_of(course);
    if (!size || (!angle && *size * unit > 0.5)) return false;  // at rest receivers leave the course empty
    row.velocity = {*size * unit * std::sin(angle.value_or(0) * unit::deg), *size * unit * std::cos(angle.value_or(0) * unit::deg), AidRow::none};
    return true;
  }
  bool read_rmc(const std::vector<std::string_view>& f, AidRow& row) {
    if (f.size() < 10 || !put_time(f[1], row)) return false;
    if (const auto date = date_of(f[9]); date && !date_) date_ = true, first_date_ = *date - days_ * day_ns;
    if (f[2] != "A") return ++without_fix_, false;
    return put_velocity(f[7], knot, f[8], row);
  }
  /// Of the sentence before.
  bool read_vtg(const std::vector<std::string_view>& f, AidRow& row) {
    if (f.size() < 9 || !time_) return false;
    row.time = *time_;
    return put_velocity(f[7], km_per_h, f[1], row);
  }
  bool read_gst(const std::vector<std::string_view>& f, AidRow& row) {
    if (f.size() < 9 || !put_time(f[1], row)) return false;
    const auto north = number_of(f[6]), east = number_of(f[7]), up = number_of(f[8]);
    if (!north || !east || !up) return false;
    row.position_sigma = {*east, *north, *up};
    if (!geoid_) widen_by_geoid(row);
    return true;
  }

  AidRows out_;
  std::optional<std::int64_t> last_, time_;
  std::optional<double> geoid_;  // its last separation
  std::int64_t days_ = 0, first_date_ = 0;
  bool date_ = false;
  std::size_t sentences_ = 0, damaged_ = 0, without_fix_ = 0, above_sea_ = 0;
};

AidRows read_nmea(const AidRequest& request) {
  expect_gnss(request, "a receiver's log (NMEA 0183)");
  const MappedFile file(request.file);
  NmeaReader reader(input_name(request.file));
  for (AidLines lines(file.text()); lines.next();) reader.read(lines.line(), lines.number());
  return reader.take();
}

/// Lines that begin with a talker of a satellite system and a type of three letters.
bool is_nmea(std::string_view head) {
  for (AidLines lines(head); lines.next();) {
    const std::string_view line = lines.line();
    if (line.size() > 6 && line.starts_with("$G") && line[6] == ',' && line.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ", 1) == 6) return true;
  }
  return false;
}

}  // namespace

AidFormat nmea_format() { return {"NMEA 0183", is_nmea, read_nmea}; }

}  // namespace imulab::aid_io
