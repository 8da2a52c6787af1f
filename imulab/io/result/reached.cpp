#include "imulab/io/result/reached.hpp"

#include "imulab/io/text/figures.hpp"
#include "imulab/model/user_unit.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace imulab {

namespace {

/// Of a group of coefficients, in user units; empty where none is known.
std::string worst_of(const std::string& selector, const std::function<double(CoefficientIndex)>& sigma) {
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

}  // namespace

std::string reached_text(const std::function<double(CoefficientIndex)>& sigma) {
  std::string lines;
  for (const auto& [name, triad] : {std::pair{"accelerometers", "accel"}, std::pair{"gyros", "gyro"}}) {
    std::string line;
    for (const auto& [what, term] : {std::pair{"scale", ".matrix.diagonal"}, {"misalignment", ".matrix.off_diagonal"}, {"offset", ".offset"}})
      if (const std::string worst = worst_of(std::string(triad) + term, sigma); !worst.empty())
        line += fmt::format("{}{} {}", line.empty() ? "" : ", ", what, worst);
    if (!line.empty()) lines += text::wrapped(fmt::format("  {:<15} ", name), line);
  }
  return lines.empty() ? lines : lines + "                  (standard uncertainty of the worst axis)\n";
}

}  // namespace imulab
