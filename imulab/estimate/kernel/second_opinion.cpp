#include "imulab/estimate/kernel/second_opinion.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/frame.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace imulab::kernel {

std::optional<SecondOpinion> second_opinion(const Calibration& estimate, const Calibration& other) {
  constexpr double least = 0.1;  // of the larger variance
  const Calibration a = in_accelerometer_frame(estimate), b = in_accelerometer_frame(other);
  std::optional<SecondOpinion> worst;
  for (const CoefficientIndex index : a.estimated) {
    const std::optional<double> of_a = standard_uncertainty(a, index), of_b = standard_uncertainty(b, index);
    const auto held = [&](const Calibration& c) {
      const auto named = [&](const std::vector<std::string>& names) { return std::ranges::find(names, coefficient(index).name) != names.end(); };
      return named(c.quality.considered) || named(c.quality.unobservable);
    };
    if (!of_a || !of_b || held(a) || held(b)) continue;
    const double variance = std::abs(*of_b * *of_b - *of_a * *of_a);
    if (!(variance >= least * std::pow(std::max(*of_a, *of_b), 2))) continue;
    const double sigmas = (coefficient_value(b.model, index) - coefficient_value(a.model, index)) / std::sqrt(variance);
    if (!worst || std::abs(sigmas) > std::abs(worst->sigmas)) worst = SecondOpinion{b.method, std::string(coefficient(index).name), sigmas};
  }
  return worst;
}

void add_second_opinion(Calibration& calibration, const Calibration& other) {
  constexpr double most = 3.7;
  const std::optional<SecondOpinion> opinion = second_opinion(calibration, other);
  if (!opinion) return;
  calibration.quality.second_opinion = opinion;
  if (std::abs(opinion->sigmas) > most)
    add_doubt(calibration.quality, fmt::format("the method {} finds {} {:.1f} standard deviations away, from the same data", opinion->method,
                                               opinion->coefficient, std::abs(opinion->sigmas)));
}

}  // namespace imulab::kernel
