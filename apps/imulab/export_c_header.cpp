#include "apps/imulab/export_c_header.hpp"

#include "imulab/core/error.hpp"
#include "imulab/export/c_header_parts.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/format.h>

#include <tuple>
#include <vector>

namespace imulab::command {

namespace {

std::vector<std::string> rates(Quantity quantity) {
  const std::vector<std::string_view> names = unit_names(quantity, false);
  return {names.begin(), names.end()};
}

/// A triad's readings: as recorded, or the model's own, changed by the arguments.
std::optional<RecordedAs> readings(const std::optional<std::string>& unit, const std::optional<double>& counts, bool body_axes,
                                   const std::optional<RecordedAs>& recorded, const std::string& raw) {
  if (!unit && !counts && !body_axes) return std::nullopt;
  RecordedAs as = recorded.value_or(RecordedAs{raw});
  if (unit) as.unit = *unit, as.counts_per_unit = 1, as.interval_s = 0;
  if (counts) as.counts_per_unit = *counts;
  if (body_axes) as.axes = RecordedAs{}.axes;
  return as;
}

}  // namespace

bool CHeaderArguments::given() const {
  return accel_unit || gyro_unit || accel_counts_per_unit || gyro_counts_per_unit || accel_range || gyro_range || body_axes || fixed_point || q15 ||
         prefix;
}

void add_c_header_options(Verb& verb, CHeaderArguments& a) {
  verb.option("--input-accel UNIT", a.accel_unit, "c-header: unit of the firmware's accelerometer readings; absent: as recorded")
      .one_of(rates(Quantity::accel));
  verb.option("--input-gyro UNIT", a.gyro_unit, "c-header: unit of its gyro readings; absent: as recorded").one_of(rates(Quantity::gyro));
  verb.option("--accel-counts-per-unit N", a.accel_counts_per_unit, "c-header: the readings are counts, so many to one unit").in_range(1e-9, 1e12);
  verb.option("--gyro-counts-per-unit N", a.gyro_counts_per_unit, "c-header: the same of the gyros").in_range(1e-9, 1e12);
  verb.option("--prefix NAME", a.prefix, "c-header: with which its names begin, for programs with several IMUs; absent: imulab");
  verb.flag("--body-axes", a.body_axes, "c-header: the readings are along the body axes, not in the recording's columns");
  verb.flag("--fixed-point", a.fixed_point, "c-header: also a compensation in integers of 32 bits");
  verb.flag("--q15", a.q15, "c-header: also a compensation in integers of 16 bits");
  verb.option("--accel-range R", a.accel_range, "--fixed-point, --q15: largest reading; absent: 32768 counts, or 16 g").in_range(1e-9, 1e12);
  verb.option("--gyro-range R", a.gyro_range, "--fixed-point, --q15: largest reading; absent: 32768 counts, or 2000 deg/s").in_range(1e-9, 1e12);
}

CHeaderOptions c_header_options(const CHeaderArguments& a, const Calibration& c) {
  const auto or_si = [](const std::string& raw, const char* si) { return raw.empty() ? std::string(si) : raw; };
  CHeaderOptions out;
  out.accel = readings(a.accel_unit, a.accel_counts_per_unit, a.body_axes, c.recorded_accel, or_si(c.model.accel.raw_unit, "m/s^2"));
  out.gyro = readings(a.gyro_unit, a.gyro_counts_per_unit, a.body_axes, c.recorded_gyro, or_si(c.model.gyro.raw_unit, "rad/s"));
  out.fixed_point = a.fixed_point, out.q15 = a.q15;
  if (a.prefix) errors_at("--prefix", [&] { firmware::expect_prefix(*a.prefix); }), out.prefix = *a.prefix;
  for (const auto& [option, from, to] :
       {std::tuple("--accel-range", a.accel_range, &out.accel_range), {"--gyro-range", a.gyro_range, &out.gyro_range}}) {
    if (!from) continue;
    if (!a.fixed_point && !a.q15) throw Error(std::string(option) + ": is of --fixed-point and --q15; expected one of these flags as well");
    if (!(*from > 0)) throw Error(std::string(option) + ": expected a number above 0");
    *to = *from;
  }
  return out;
}

std::vector<std::string> assumed_readings(const CHeaderOptions& options, const Calibration& c) {
  std::vector<std::string> out;
  const auto add = [&out](bool known, const std::string& raw, const std::string& name, const std::string& unit, const std::string& option) {
    if (!known && raw != "count")
      out.push_back(fmt::format("does not say how the {} were recorded: the header takes {}; {} gives another unit", name, unit, option));
  };
  add(options.accel || c.recorded_accel, c.model.accel.raw_unit, "accelerometers", "m/s^2", "--input-accel");
  add(options.gyro || c.recorded_gyro, c.model.gyro.raw_unit, "gyros", "rad/s", "--input-gyro");
  return out;
}

}  // namespace imulab::command
