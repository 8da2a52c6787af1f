#include "imulab/formats/aid/rows.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace imulab::aid_io {
namespace {

/// A value that is there, and is no number or beyond its range.
bool is_beyond(double value, double low, double high) { return !std::isnan(value) && !(value >= low && value <= high); }

void check_row(const AidRows& rows, const AidRow& row) {
  constexpr std::int64_t most = 4'600'000'000'000'000'000;  // ns, as of a recording: differences fit
  if (row.time < -most || row.time > most)
    throw Error(fmt::format("{}: {} s is no time; expected one within 146 years of 1970", rows.place(row), text::seconds_text(row.time)));
  const double latitude = row.position.x() / unit::deg, longitude = row.position.y() / unit::deg;
  if (is_beyond(latitude, -90, 90))
    throw Error(fmt::format("{}: latitude: {:g} deg is out of range; expected -90 to 90{}", rows.place(row), latitude,
                            std::abs(latitude) <= 360 && std::abs(longitude) <= 90 ? " (latitude and longitude seem to be swapped)" : ""));
  if (is_beyond(longitude, -360, 360))
    throw Error(fmt::format("{}: longitude: {:g} deg is out of range; expected -180 to 360", rows.place(row), longitude));
  if (is_beyond(row.position.z(), -12e3, 1e6))
    throw Error(fmt::format("{}: height: {:g} m is out of range; expected -12000 to 1e+06", rows.place(row), row.position.z()));
  for (const double speed : row.velocity)
    if (is_beyond(speed, -1e5, 1e5))
      throw Error(fmt::format("{}: velocity: {:g} m/s is out of range; expected -1e+05 to 1e+05", rows.place(row), speed));
  for (const double at : row.place)
    if (is_beyond(at, -1e7, 1e7)) throw Error(fmt::format("{}: position: {:g} m is out of range; expected -1e+07 to 1e+07", rows.place(row), at));
  constexpr double rounding = 0.01;  // of a quaternion's length: files have as few as three digits
  if (const double length = row.attitude.norm(); is_beyond(length, 1 - rounding, 1 + rounding))
    throw Error(fmt::format("{}: quaternion: its length is {:g}; expected 1", rows.place(row), length));
  if (is_beyond(row.value, -1e6, 1e6)) throw Error(fmt::format("{}: {:g} is out of range; expected -1e+06 to 1e+06", rows.place(row), row.value));
  for (const double sigma : {row.position_sigma.x(), row.position_sigma.y(), row.position_sigma.z(), row.velocity_sigma.x(), row.velocity_sigma.y(),
                             row.velocity_sigma.z(), row.value_sigma})
    if (is_beyond(sigma, 0, 1e9))
      throw Error(fmt::format("{}: standard deviation: {:g} is out of range; expected 0 to 1e+09", rows.place(row), sigma));
}

/// Counts and removes a standard deviation of 0.
std::size_t take_zero(double& sigma) {
  if (sigma != 0) return 0;
  sigma = AidRow::none;
  return 1;
}

std::size_t take_zeros(AidRow& row) {
  std::size_t zeros = take_zero(row.value_sigma);
  for (Eigen::Index i = 0; i < 3; ++i) zeros += take_zero(row.position_sigma[i]) + take_zero(row.velocity_sigma[i]);
  return zeros;
}

bool has_any(const AidRow& row) {
  return !std::isnan(row.value) || !row.position.array().isNaN().all() || !row.velocity.array().isNaN().all() || row.place.allFinite() ||
         row.attitude.allFinite();
}

/// Adds what the row before, of the same stamp, does not say: 0 where it says nothing new.
int fill(double& value, double more) {
  if (!std::isnan(value) || std::isnan(more)) return 0;
  value = more;
  return 1;
}

int fill(AidRow& row, const AidRow& more) {
  int added = fill(row.value, more.value) + fill(row.value_sigma, more.value_sigma);
  for (Eigen::Index i = 0; i < 4; ++i) added += fill(row.attitude[i], more.attitude[i]);
  for (const auto vector : {&AidRow::position, &AidRow::position_sigma, &AidRow::velocity, &AidRow::velocity_sigma, &AidRow::place})
    for (Eigen::Index i = 0; i < 3; ++i) added += fill((row.*vector)[i], (more.*vector)[i]);
  return added;
}

template <class Column, class Get>
void put_column(Column& column, const std::vector<AidRow>& rows, const Get& get) {
  bool any = false;
  for (const AidRow& row : rows) {
    column.push_back(get(row));
    if constexpr (requires { column.back().array(); })
      any = any || !column.back().array().isNaN().all();
    else
      any = any || !std::isnan(column.back());
  }
  if (!any) column.clear();
}

}  // namespace

std::string AidRows::place(const AidRow& at) const {
  return row == "line" ? fmt::format("{}:{}", file, at.line) : fmt::format("{}: {} {}", file, row, at.line);
}

void widen_by_geoid(AidRow& row) {
  constexpr double geoid = 30;  // m
  double& sigma = row.position_sigma.z();
  sigma = std::isnan(sigma) ? geoid : std::hypot(sigma, geoid);
}

AidReading make_record(AidRows all) {
  std::vector<AidRow> rows;
  std::size_t repeated = 0, zeros = 0;
  for (AidRow& row : all.rows) {
    check_row(all, row);
    zeros += take_zeros(row);
    if (!rows.empty() && row.time < rows.back().time)
      throw Error(fmt::format("{}: time runs back by {:g} s; expected ascending stamps", all.place(row),
                              1e-9 * (static_cast<double>(rows.back().time) - static_cast<double>(row.time))));
    if (!rows.empty() && row.time == rows.back().time)
      repeated += fill(rows.back(), row) == 0 ? 1 : 0;
    else if (has_any(row))
      rows.push_back(row);
  }
  if (rows.empty()) throw Error(all.file + ": has no row with a position, a velocity, an attitude or a value; expected some");
  AidReading out{{}, std::move(all.warnings)};
  if (repeated > 0) out.warnings.push_back(fmt::format("{}: {} rows repeat the stamp of the row before and are left out", all.file, repeated));
  if (zeros > 0)
    out.warnings.push_back(fmt::format(
        "{}: {} standard deviations are stated as 0, which nothing has; they are ignored, and those of [[aid]] are used", all.file, zeros));
  for (const AidRow& row : rows) out.record.time.push_back(row.time);
  put_column(out.record.position, rows, [](const AidRow& row) { return row.position; });
  put_column(out.record.position_sigma, rows, [](const AidRow& row) { return row.position_sigma; });
  put_column(out.record.velocity, rows, [](const AidRow& row) { return row.velocity; });
  put_column(out.record.velocity_sigma, rows, [](const AidRow& row) { return row.velocity_sigma; });
  put_column(out.record.value, rows, [](const AidRow& row) { return row.value; });
  put_column(out.record.value_sigma, rows, [](const AidRow& row) { return row.value_sigma; });
  put_column(out.record.place, rows, [](const AidRow& row) { return row.place; });
  if (std::ranges::any_of(rows, [](const AidRow& row) { return row.attitude.allFinite(); }))
    for (const AidRow& row : rows) out.record.attitude.push_back(row.attitude.normalized());
  return out;
}

bool AidLines::next() {
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find('\n');
  cut_ = end == std::string_view::npos;
  line_ = rest_.substr(0, end);
  rest_.remove_prefix(cut_ ? rest_.size() : end + 1);
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  ++number_;
  return true;
}

std::vector<std::string_view> parts_of(std::string_view line, std::string_view separators, bool empty) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find_first_of(separators, at), line.size());
    if (empty || end > at) parts.push_back(line.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

std::optional<double> number_of(std::string_view text) {
  text = text::without_plus(text);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::int64_t> nanoseconds_of_text(std::string_view seconds) {
  const text::ScaledInteger ns = text::scaled_integer(seconds.data(), seconds.data() + seconds.size(), 9);
  if (ns.status != text::ScaledInteger::Status::good || ns.end != seconds.data() + seconds.size()) return std::nullopt;
  return ns.value;
}

std::optional<std::int64_t> time_of_week(std::string_view week, std::string_view seconds) {
  constexpr double most_weeks = 10'000;
  const auto weeks = number_of(week);
  const auto ns = nanoseconds_of_text(seconds);
  if (!weeks || !ns || !(*weeks >= 0 && *weeks <= most_weeks) || *weeks != std::floor(*weeks) || *ns < 0 || *ns > week_ns) return std::nullopt;
  return gps_epoch_ns + static_cast<std::int64_t>(*weeks) * week_ns + *ns;
}

}  // namespace imulab::aid_io
