#include "imulab/results/reached.hpp"

#include "imulab/formats/text/figures.hpp"
#include "imulab/model/requirement.hpp"
#include "imulab/model/user_value.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace imulab {

double judged_uncertainty(const Calibration& calibration, CoefficientIndex index) {
  const Coefficient& c = coefficient(index);
  const TriadModel& triad = triad_model(calibration.model, c.triad);
  if (c.term != Term::offset || triad.raw_unit != "count") return relative_uncertainty(calibration, index);
  return raw_zero(calibration, c.triad).uncertainty[c.row] * std::abs(triad.matrix(c.row, c.row));
}

std::string worst_text(std::string_view selector, const std::function<double(CoefficientIndex)>& sigma) {
  double worst = -1;
  UserUnit unit{};
  for (const CoefficientIndex index : select_coefficients(selector)) {
    const double own = sigma(index);
    if (!std::isfinite(own) || own <= worst) continue;
    worst = own;
    unit = user_unit(coefficient(index), own);
  }
  return worst < 0 ? "" : fmt::format("{} {}", text::two_digits(worst / unit.size), unit.name);
}

std::string reached_text(const std::function<double(CoefficientIndex)>& sigma) {
  std::string lines;
  for (const auto& [name, triad] : {std::pair{"accelerometers", "accel"}, std::pair{"gyros", "gyro"}}) {
    std::string line;
    for (const auto& [what, term] : {std::pair{"scale", ".matrix.diagonal"}, {"misalignment", ".matrix.off_diagonal"}, {"offset", ".offset"}})
      if (const std::string worst = worst_text(std::string(triad) + term, sigma); !worst.empty())
        line += fmt::format("{}{} {}", line.empty() ? "" : ", ", what, worst);
    if (!line.empty()) lines += text::wrapped(fmt::format("  {:<15} ", name), line);
  }
  return lines.empty() ? lines : lines + "                  (standard uncertainty of the worst axis)\n";
}

}  // namespace imulab
