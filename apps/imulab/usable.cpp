#include "apps/imulab/usable.hpp"

#include "imulab/core/error.hpp"
#include "imulab/io/calibration/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace imulab::command {

void add_allow_undetermined(Verb& verb, bool& allowed) {
  verb.flag("--allow-undetermined", allowed, "use a calibration though the data did not determine some of its offsets or matrices");
}

void expect_sizes(const Calibration& calibration, const std::string& file) {
  constexpr double largest = 1e30;  // in SI: products of a few such numbers are still numbers
  for (const CoefficientIndex index : coefficient_indices())
    if (const double value = coefficient_value(calibration.model, index); !(std::abs(value) <= largest))
      throw Error(fmt::format("{}: {} is {}; expected a number from {} to {}", file, coefficient(index).name, value, -largest, largest));
}

void expect_usable(const Calibration& calibration, const std::string& file, bool allowed) {
  const auto estimated = [&](const char* selector) {
    const std::vector<CoefficientIndex> of = select_coefficients(selector);
    return std::any_of(of.begin(), of.end(), [&](CoefficientIndex i) { return contains(calibration.estimated, i); });
  };
  for (const auto& [name, matrix] : {std::pair{"accelerometers", "accel.matrix"}, std::pair{"gyros", "gyro.matrix"}})
    if (!calibration.estimated.empty() && !estimated(matrix))
      warn(fmt::format("{}: the {}' scales and axes were not calibrated: taken as declared, and as exactly known", file, name));
  expect_sizes(calibration, file);
  const std::vector<std::string> names = unusable(calibration);
  if (names.empty()) return;
  const std::string text = fmt::format("{}: the data did not determine {}: starting values, which compensate nothing", file, fmt::join(names, ", "));
  if (!allowed) throw Unsupported(text + "; expected a calibration from more data, or --allow-undetermined");
  warn(text);
}

Calibration read_usable(const std::string& file, bool allowed) {
  Calibration calibration = read_calibration(file);
  expect_usable(calibration, file, allowed);
  return calibration;
}

}  // namespace imulab::command
