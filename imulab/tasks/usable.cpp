#include "imulab/tasks/usable.hpp"

#include "imulab/core/nearest_name.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/printable.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

namespace imulab {
namespace {

void check_thermal_unit(const TriadModel& model, const std::optional<ThermalSource>& source, const std::string& file, const char* triad) {
  if (model.temperature && source && model.temperature->unit != source->unit)
    throw Error(
        fmt::format("{}: the {} temperature is in {}; expected {} as in the calibration", file, triad, source->unit, model.temperature->unit));
}

/// A matrix without an inverse maps different readings to the same motion.
void expect_invertible(const Calibration& calibration, const std::string& name) {
  constexpr double least = 1e-6;  // of axes that share all but 0.2 arcsec
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const Matrix3d rows = triad_model(calibration.model, triad).matrix.rowwise().normalized();
    if (!(std::abs(rows.determinant()) > least))
      throw Error(fmt::format("{}: {}.matrix is singular; expected three rows that are not zero and not of one plane", name, to_string(triad)));
  }
}

}  // namespace

void expect_sizes(const Calibration& calibration, const std::string& name) {
  constexpr double largest = 1e30;  // in SI: products of a few such numbers are still numbers
  for (const CoefficientIndex index : coefficient_indices())
    if (const double value = coefficient_value(calibration.model, index); !(std::abs(value) <= largest))
      throw Error(fmt::format("{}: {} is {}; expected a number from {} to {}", name, coefficient(index).name, value, -largest, largest));
}

std::vector<std::string> doubt_about(const Calibration& calibration, const std::string& name) {
  if (calibration.quality.verdict != Verdict::doubtful) return {};
  return {name + ": the calibration is doubtful; its errors may be larger than it states"};
}

std::vector<std::string> expect_usable(const Calibration& calibration, const std::string& name, bool allowed, const std::string& allow) {
  expect_sizes(calibration, name), expect_invertible(calibration, name);
  std::vector<std::string> warnings = doubt_about(calibration, name);
  const auto estimated = [&](const char* selector) {
    const std::vector<CoefficientIndex> of = select_coefficients(selector);
    return std::any_of(of.begin(), of.end(), [&](CoefficientIndex i) { return contains(calibration.estimated, i); });
  };
  for (const auto& [triad, matrix] : {std::pair{"accelerometers", "accel.matrix"}, std::pair{"gyros", "gyro.matrix"}})
    if (!calibration.estimated.empty() && !estimated(matrix))
      warnings.push_back(fmt::format("{}: the {}' scales and axes were not calibrated: taken as declared, and as exactly known", name, triad));
  const std::vector<std::string> names = unusable(calibration);
  if (names.empty()) return warnings;
  const std::string text = fmt::format("{}: the data did not determine {}: starting values, which compensate nothing", name, fmt::join(names, ", "));
  if (!allowed) throw Unsupported(fmt::format("{}; expected a calibration from more data, or {}", text, allow));
  warnings.push_back(text);
  return warnings;
}

const RecordingSource& choose_recording(const Session& session, const std::string& name) {
  std::vector<std::string_view> files;
  for (const RecordingSource& source : session.recordings) {
    if (source.file == name || (name.empty() && session.recordings.size() == 1)) return source;
    files.push_back(source.file);
  }
  if (files.empty()) throw Error(session.file + ": has no recordings; expected at least one [[recording]]");
  throw Error(
      fmt::format("{}: {}{}", session.file, name.empty() ? "has several recordings" : "has no recording " + name, expected_name(name, files)));
}

void check_thermal_units(const Calibration& calibration, const RecordingSource& source) {
  check_thermal_unit(calibration.model.accel, source.accel_temperature, source.file, "accelerometer");
  check_thermal_unit(calibration.model.gyro, source.gyro_temperature, source.file, "gyro");
}

}  // namespace imulab
