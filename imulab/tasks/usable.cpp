#include "imulab/tasks/usable.hpp"

#include "imulab/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

void expect_sizes(const Calibration& calibration, const std::string& name) {
  constexpr double largest = 1e30;  // in SI: products of a few such numbers are still numbers
  for (const CoefficientIndex index : coefficient_indices())
    if (const double value = coefficient_value(calibration.model, index); !(std::abs(value) <= largest))
      throw Error(fmt::format("{}: {} is {}; expected a number from {} to {}", name, coefficient(index).name, value, -largest, largest));
}

Usability usability(const Calibration& calibration, const std::string& name) {
  expect_sizes(calibration, name);
  const auto estimated = [&](const char* selector) {
    const std::vector<CoefficientIndex> of = select_coefficients(selector);
    return std::any_of(of.begin(), of.end(), [&](CoefficientIndex i) { return contains(calibration.estimated, i); });
  };
  Usability out;
  for (const auto& [triad, matrix] : {std::pair{"accelerometers", "accel.matrix"}, std::pair{"gyros", "gyro.matrix"}})
    if (!calibration.estimated.empty() && !estimated(matrix))
      out.warnings.push_back(fmt::format("{}: the {}' scales and axes were not calibrated: taken as declared, and as exactly known", name, triad));
  if (const std::vector<std::string> names = unusable(calibration); !names.empty())
    out.undetermined = fmt::format("{}: the data did not determine {}: starting values, which compensate nothing", name, fmt::join(names, ", "));
  return out;
}

}  // namespace imulab
