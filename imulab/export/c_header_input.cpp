#include "imulab/export/c_header_input.hpp"

#include "imulab/core/error.hpp"
#include "imulab/export/c_header_text.hpp"
#include "imulab/formats/text/names.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::firmware {

namespace {

void expect_fitting(const RecordedAs& as, Triad triad, const std::string& raw) {
  const char* const name = triad == Triad::accel ? "accelerometers" : "gyros";
  const std::vector<std::string_view> units = unit_names(triad == Triad::accel ? Quantity::accel : Quantity::gyro, as.interval_s > 0);
  if (std::find(units.begin(), units.end(), as.unit) == units.end())
    throw Error(fmt::format("readings of the {} in {}; expected one of {}", name, harmless(as.unit), text::listed(units)));
  if (!raw.empty() && (as.unit == "count") != (raw == "count"))
    throw Error(fmt::format("readings of the {} in {}; expected {}, which the calibration was made from", name, as.unit,
                            raw == "count" ? "count" : "a physical unit"));
  if (!(as.counts_per_unit > 0) || !std::isfinite(as.counts_per_unit) || (as.unit == "count" && as.counts_per_unit != 1))
    throw Error(fmt::format("{:g} counts per {} of the {}; expected {}", as.counts_per_unit, as.unit, name,
                            as.unit == "count" ? "a physical unit with them" : "a number above 0"));
}

std::string described(const RecordedAs& as) {
  std::string text = as.counts_per_unit != 1 ? fmt::format("counts, {} to one {}", as.counts_per_unit, as.unit)
                     : as.unit == "count"    ? "counts"
                                             : as.unit;
  if (as.interval_s > 0) text += fmt::format(", each the sum over its interval of {} s", as.interval_s);
  return text;
}

void set_axes(Input& in) {
  in.column.fill(-1);
  for (int column = 0; column < 3; ++column) {
    const std::string& axis = in.as.axes[static_cast<std::size_t>(column)];
    const std::size_t body = axis.size() == 2 && (axis[0] == '+' || axis[0] == '-') ? std::string_view("xyz").find(axis[1]) : std::string::npos;
    if (body == std::string::npos || in.column[body] >= 0)
      throw Error(fmt::format("axis {} of column {}; expected +x, -x, +y, -y, +z or -z, each axis once", harmless(axis), column + 1));
    in.column[body] = column;
    in.sign[body] = axis[0] == '-' ? -1 : 1;
  }
}

}  // namespace

Input input_of(const Calibration& calibration, const CHeaderOptions& options, Triad triad) {
  const bool accel = triad == Triad::accel;
  const TriadModel& model = accel ? calibration.model.accel : calibration.model.gyro;
  const std::optional<RecordedAs>&given = accel ? options.accel : options.gyro,
        &recorded = accel ? calibration.recorded_accel : calibration.recorded_gyro;
  Input in;
  in.triad = triad;
  if (given || recorded)
    in.as = given ? *given : *recorded;
  else
    in.as.unit = model.raw_unit.empty() ? (accel ? "m/s^2" : "rad/s") : model.raw_unit;
  expect_fitting(in.as, triad, model.raw_unit);
  in.factor = si_factor(in.as.unit) / in.as.counts_per_unit;
  if (in.as.interval_s > 0) in.factor /= in.as.interval_s;
  if (!(in.factor > 0 && std::isfinite(in.factor)))
    throw Error(fmt::format("readings of the {} in {}: cannot be converted; expected a scale of an IMU", accel ? "accelerometers" : "gyros",
                            described(in.as)));
  in.counts = in.as.unit == "count" || in.as.counts_per_unit != 1;
  set_axes(in);
  in.parameter = fmt::format("{}_{}", in.triad_name(), in.counts ? "count" : unit_in_name(in.as.unit));
  in.unit = described(in.as);
  return in;
}

}  // namespace imulab::firmware
