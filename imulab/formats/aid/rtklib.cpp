// RTKLIB's solutions (.pos), as its manual (appendix B) and solution.c write them: lines of % say what the columns are; dates or GPS weeks; degrees,
// or degrees, minutes and seconds.
#include "imulab/error.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/text/date.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab::aid_io {
namespace {

constexpr std::string_view pos_separators = " ,;\t";
constexpr std::array<std::string_view, 3> pos_scales{"GPST", "UTC", "JST"};

struct PosColumn {
  std::string_view name;  ///< before the bracket
  std::size_t at;         ///< index of its first part in a row
};

/// What the line of columns says; a row begins with two parts of time.
struct PosLayout {
  TimeScale scale = TimeScale::gps;
  std::int64_t ahead_ns = 0;  ///< of UTC
  bool sexagesimal = false;
  std::size_t parts = 2;
  std::vector<PosColumn> columns{};
};

/// "latitude(d'\")" has three parts in a row.
bool is_sexagesimal(std::string_view column) { return column.find('\'') != std::string_view::npos; }

std::optional<PosLayout> pos_layout(std::string_view line) {
  const std::vector<std::string_view> names = parts_of(line, " ,;\t%", false);
  if (!line.starts_with('%') || names.size() < 2 || std::find(pos_scales.begin(), pos_scales.end(), names[0]) == pos_scales.end())
    return std::nullopt;
  PosLayout layout;
  layout.scale = names[0] == "GPST" ? TimeScale::gps : TimeScale::utc;
  if (names[0] == "JST") layout.ahead_ns = 9 * 3'600'000'000'000;
  for (std::size_t i = 1; i < names.size(); ++i) {
    layout.columns.push_back({names[i].substr(0, names[i].find('(')), layout.parts});
    layout.sexagesimal = layout.sexagesimal || is_sexagesimal(names[i]);
    layout.parts += is_sexagesimal(names[i]) ? 3 : 1;
  }
  return layout;
}

std::optional<std::int64_t> pos_time(std::string_view first, std::string_view second) {
  if (first.find('/') == std::string_view::npos) return time_of_week(first, second);
  const std::string both = fmt::format("{} {}", first, second);
  const text::Moment moment = text::moment_of(both);
  if (!moment.has_date || !moment.has_time) return std::nullopt;
  std::string seconds;
  text::append_seconds(seconds, moment.seconds, moment.fraction);
  return nanoseconds_of_text(seconds);
}

/// A row taken apart.
class PosRow {
 public:
  PosRow(const AidRows& rows, const PosLayout& layout, std::size_t line, std::vector<std::string_view> parts)
      : rows_(rows), layout_(layout), parts_(std::move(parts)) {
    row_.line = line;
  }

  AidRow read() {
    const auto time = pos_time(parts_[0], parts_[1]);
    if (!time) fail(fmt::format("{} {}", excerpt(parts_[0]), excerpt(parts_[1])), "a date and time of day, or a GPS week and its seconds");
    row_.time = *time - layout_.ahead_ns;
    row_.position = {angle("latitude"), angle("longitude"), number("height")};
    row_.position_sigma = {number("sde"), number("sdn"), number("sdu")};
    row_.velocity = {number("ve"), number("vn"), number("vu")};
    row_.velocity_sigma = {number("sdve"), number("sdvn"), number("sdvu")};
    return row_;
  }

 private:
  [[noreturn]] void fail(const std::string& found, const char* expected) const {
    throw Error(fmt::format("{}: {} is not {}; expected it as RTKLIB writes it", rows_.place(row_), found, expected));
  }
  const PosColumn* column(std::string_view name) const {
    const auto found = std::find_if(layout_.columns.begin(), layout_.columns.end(), [&](const PosColumn& c) { return c.name == name; });
    return found != layout_.columns.end() ? &*found : nullptr;
  }
  double number_at(std::size_t at) const {
    const auto value = number_of(parts_[at]);
    if (!value) fail(excerpt(parts_[at]), "a number");
    return *value;
  }
  double number(std::string_view name) const {
    const PosColumn* at = column(name);
    return at != nullptr ? number_at(at->at) : AidRow::none;
  }
  double angle(std::string_view name) const {
    const std::size_t at = column(name)->at;
    if (!layout_.sexagesimal) return number_at(at) * unit::deg;
    const double size = std::abs(number_at(at)) + number_at(at + 1) / 60 + number_at(at + 2) / 3600;
    return (parts_[at].starts_with('-') ? -size : size) * unit::deg;
  }

  const AidRows& rows_;
  const PosLayout& layout_;
  std::vector<std::string_view> parts_;
  AidRow row_;
};

void expect_degrees(const PosLayout& layout, const std::string& place) {
  const auto has = [&](std::string_view name) {
    return std::any_of(layout.columns.begin(), layout.columns.end(), [&](const PosColumn& c) { return c.name == name; });
  };
  if (!has("latitude") || !has("longitude") || !has("height"))
    throw Error(fmt::format("{}: has {} in place of latitude, longitude and height; expected RTKLIB's out-solformat = llh", place,
                            layout.columns.empty() ? "nothing" : excerpt(layout.columns.front().name)));
}

AidRows read_rtklib(const AidRequest& request) {
  expect_gnss(request, "RTKLIB's solution");
  const MappedFile file(request.file);
  AidRows out{.file = input_name(request.file)};
  std::optional<PosLayout> layout;
  bool geodetic = false;
  for (AidLines lines(file.text()); lines.next();) {
    const std::string_view line = lines.line();
    const std::string place = fmt::format("{}:{}", out.file, lines.number());
    if (line.starts_with('%')) {
      if (auto found = pos_layout(line)) layout = std::move(found), expect_degrees(*layout, place), out.scale = layout->scale;
      geodetic = geodetic || line.find("WGS84/geodetic") != std::string_view::npos;
      continue;
    }
    std::vector<std::string_view> parts = parts_of(line, pos_separators, false);
    if (parts.empty()) continue;
    if (!layout) throw Error(place + ": a row before the line that names the columns; expected \"%  GPST  latitude(deg) ...\"");
    if (parts.size() < layout->parts) {
      if (!lines.is_cut()) throw Error(fmt::format("{}: {} fields; expected {}", place, parts.size(), layout->parts));
      out.warnings.push_back(out.file + ": ends inside a row, which is left out");
      break;
    }
    out.rows.push_back(PosRow(out, *layout, lines.number(), std::move(parts)).read());
  }
  if (!geodetic) return out;
  std::ranges::for_each(out.rows, widen_by_geoid);
  out.warnings.push_back(out.file +
                         ": heights are above sea level (WGS84/geodetic); the geoid's undulation, up to 100 m, is an error of every height");
  return out;
}

bool is_rtklib(std::string_view head) {
  for (AidLines lines(head); lines.next();)
    if (pos_layout(lines.line())) return true;
  return false;
}

}  // namespace

AidFormat rtklib_format() { return {"RTKLIB's solution (.pos)", is_rtklib, read_rtklib}; }

}  // namespace imulab::aid_io
