#include "imulab/inspection/purpose.hpp"

#include "imulab/grade.hpp"
#include "imulab/inspection/declared.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <utility>

namespace imulab::inspection {
namespace {

/// At rest in most rows, and in one direction.
bool is_one_attitude(const SignalTable& table, const TriadEvidence& triads) {
  constexpr double most_rows = 0.8, one_direction = 5 * unit::deg;  // a start and an end may move; as turns are counted
  std::size_t still = 0;
  for (const Range& rest : triads.rests) still += rest.size();
  return !triads.up.empty() && static_cast<double>(still) >= most_rows * static_cast<double>(table.rows()) &&
         std::all_of(triads.up.begin(), triads.up.end(), [&](const Vector3d& up) { return up.dot(triads.up.front()) > std::cos(one_direction); });
}

/// The mean of a column in the hottest tenth of the range less that in the coldest.
double change_with(std::span<const double> temperature, double low, double high, const std::vector<double>& values) {
  std::array<double, 2> sum{};
  std::array<std::size_t, 2> count{};
  for (std::size_t i = 0; i < temperature.size(); ++i) {
    const double part = (temperature[i] - low) / (high - low);
    if (part > 0.1 && part < 0.9) continue;
    sum[part > 0.5] += values[i], ++count[part > 0.5];
  }
  return sum[1] / static_cast<double>(count[1]) - sum[0] / static_cast<double>(count[0]);
}

}  // namespace

std::string noise_by_unit(const SignalTable& table, const TriadEvidence& triads, double interval_s) {
  constexpr std::size_t least = 100;  // samples: N to 10 %
  const auto longest = std::max_element(triads.rests.begin(), triads.rests.end(), [](const Range& a, const Range& b) { return a.size() < b.size(); });
  if (longest == triads.rests.end() || longest->size() < least || interval_s <= 0 || !triads.has_gyro) return "";
  double sum = 0;
  for (const std::size_t axis : triads.gyro)
    for (std::size_t i = longest->begin + 1; i < longest->end; ++i) {
      const double step = table.signals[axis].values[i] - table.signals[axis].values[i - 1];
      sum += step * step / 2;  // twice the variance of white noise
    }
  const double n = std::sqrt(sum / (3 * static_cast<double>(longest->size() - 1)) * interval_s);
  if (n == 0) return "";
  std::string out;
  for (const auto& [name, factor] : {std::pair("deg/s", unit::deg), std::pair("rad/s", 1.)}) {
    constexpr double alike = 5;  // grades are a factor of ten or more apart
    const Grade* nearest = nullptr;
    for (const Grade& grade : grades())
      if (const double ratio = std::abs(std::log(n * factor / grade.gyro_noise.N));
          ratio < std::log(alike) && (nearest == nullptr || ratio < std::abs(std::log(n * factor / nearest->gyro_noise.N))))
        nearest = &grade;
    out += fmt::format("{}{} gives N {:.2g} deg/sqrt(h){}", out.empty() ? "" : "; ", name, n * factor / unit::deg_per_sqrt_h,
                       nearest == nullptr ? "" : fmt::format(", as grade {}", nearest->name));
  }
  return out;
}

namespace {

/// The temperature of a log, and its extremes.
struct LoggedTemperature {
  std::span<const double> readings;
  double low = 0, high = 0;
  std::string unit;
  bool changes() const { return high - low >= 10; }  // K: warming up is less
};

LoggedTemperature temperature_of(const SignalTable& table, const Inspection& result) {
  const auto column = std::find_if(result.columns.begin(), result.columns.end(), [](const ColumnFinding& c) { return c.role == "temperature"; });
  if (column == result.columns.end()) return {};
  const std::vector<double>& readings = table.signals[static_cast<std::size_t>(column - result.columns.begin())].values;
  const auto [low, high] = std::minmax_element(readings.begin(), readings.end());
  return {readings, *low, *high, column->unit};
}

}  // namespace

bool sweeps_in_one_attitude(const SignalTable& table, const TriadEvidence& triads, const Inspection& result) {
  const LoggedTemperature temperature = temperature_of(table, result);
  return triads.has_gyro && triads.has_accel && is_one_attitude(table, triads) && temperature.changes() && temperature.unit != "raw";
}

void add_purpose(const SignalTable& table, const TriadEvidence& triads, Inspection& result) {
  if (!is_one_attitude(table, triads)) return;
  const LoggedTemperature temperature = temperature_of(table, result);
  if (!temperature.changes()) {
    result.note("good for: noise, as a log at rest in one attitude");
    return;
  }
  std::string changes;
  for (std::size_t c = 0; c < table.signals.size(); ++c)
    if (result.columns[c].role.starts_with("gyro.") || result.columns[c].role.starts_with("accel."))
      changes += fmt::format("{}{} {:+.3g}{}", changes.empty() ? "" : ", ", column_name(table, c),
                             change_with(temperature.readings, temperature.low, temperature.high, table.signals[c].values),
                             result.columns[c].unit.empty() || result.columns[c].unit == "count" ? "" : " " + result.columns[c].unit);
  result.note(fmt::format("good for: how the zeros follow the temperature in this one attitude: from {:.3g} to {:.3g} {} the means change by {}{}",
                          temperature.low, temperature.high, temperature.unit, changes,
                          temperature.unit == "raw" ? "; for static, declare in the session what the thermometer reads at_25_degC and per_K" : ""));
}

}  // namespace imulab::inspection
