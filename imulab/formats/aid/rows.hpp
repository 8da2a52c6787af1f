// Rows of an aid as a format gives them, and the record that they make.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/eigen.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::aid_io {

/// What one message or line says; NaN: nothing.
struct AidRow {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  std::int64_t time = 0;  ///< [ns] of the scale of its rows
  std::size_t line = 0;   ///< or message, from 1
  Eigen::Vector3d position = Eigen::Vector3d::Constant(none), position_sigma = position;
  Eigen::Vector3d velocity = position, velocity_sigma = position;
  double value = none, value_sigma = none;
  Eigen::Vector3d place = position;                            ///< of a pose
  Eigen::Vector4d attitude = Eigen::Vector4d::Constant(none);  ///< quaternion x, y, z, w
};

struct AidRows {
  std::string file{};        ///< as messages name it
  std::string row = "line";  ///< what messages call a row: "message"
  TimeScale scale = TimeScale::own;
  std::vector<AidRow> rows{};
  std::vector<std::string> warnings{};

  /// "drive.pos:12", or "log.ulg: message 12".
  std::string place(const AidRow& row) const;
};

/// The standard deviation of a height above sea level as one above the ellipsoid: the geoid is 30 m off (RMS over the Earth, EGM2008), alike for all
/// heights of a drive.
void widen_by_geoid(AidRow& row);

struct AidReading {
  AidRecord record;
  std::vector<std::string> warnings;
};

/// Rows of one stamp become one; repeated ones are dropped, and so are standard deviations of 0, each with a warning. Throws Error with file and line
/// for a latitude, height or speed that no vehicle has (a latitude in the place of the longitude is named), for stamps that run back, and for no
/// rows.
AidReading make_record(AidRows rows);

/// Lines of a text, from 1, without their ends.
class AidLines {
 public:
  explicit AidLines(std::string_view text) : rest_(text) {}
  bool next();
  std::string_view line() const { return line_; }
  std::size_t number() const { return number_; }
  /// True for a last line without an end: the logger was switched off.
  bool is_cut() const { return cut_; }

 private:
  std::string_view rest_, line_;
  std::size_t number_ = 0;
  bool cut_ = false;
};

/// The parts of a line between single separators, where `empty` parts count (commas), or between any number of them (blanks).
std::vector<std::string_view> parts_of(std::string_view line, std::string_view separators, bool empty);
/// A finite decimal number that is all of the text.
std::optional<double> number_of(std::string_view text);
/// A decimal number of seconds in nanoseconds, exactly.
std::optional<std::int64_t> nanoseconds_of_text(std::string_view seconds);

/// From 1970 to the beginning of GPS time, 1980-01-06 [ns].
inline constexpr std::int64_t gps_epoch_ns = 315'964'800'000'000'000, week_ns = 604'800'000'000'000;
/// A week and its seconds as in the files, in nanoseconds since 1970 of GPS time.
std::optional<std::int64_t> time_of_week(std::string_view week, std::string_view seconds);

}  // namespace imulab::aid_io
