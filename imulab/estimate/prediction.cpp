#include "imulab/estimate/prediction.hpp"

#include "imulab/model/frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace imulab {

std::string_view to_string(Knob knob) {
  constexpr std::array<std::string_view, 4> names{"table", "timing", "imu", "all"};
  return names[static_cast<std::size_t>(knob)];
}

Prediction prediction_of(const Calibration& calibration) {
  Prediction out{calibration.estimated, {}, calibration.covariance.diagonal().cwiseSqrt(), {}};
  out.cramer_rao = out.sigma;
  out.frame = calibration.frame;
  for (const std::string& name : calibration.quality.unobservable) out.undetermined.push_back(coefficient_index(name));
  for (const std::string& name : calibration.quality.considered)
    if (const CoefficientIndex index = coefficient_index(name); contains(out.coefficients, index)) out.considered.push_back(index);
  return out;
}

std::vector<Shortfall> shortfalls(const Prediction& p, const std::vector<Requirement>& requirements) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  std::vector<Shortfall> out;
  std::vector<CoefficientIndex> named;
  for (const Requirement& r : requirements)
    for (const CoefficientIndex index : r.coefficients) {
      if (contains(named, index)) continue;
      const auto found = std::find(p.coefficients.begin(), p.coefficients.end(), index);
      const bool fixed = p.frame == "accelerometers" && zero_by_frame(index);
      const double sigma = found != p.coefficients.end() ? p.sigma[found - p.coefficients.begin()] : fixed ? 0 : infinite;
      if (sigma <= r.limit) continue;
      out.push_back({r, index, sigma, std::isinf(sigma) ? "the procedure does not determine it" : ""});
      named.push_back(index);
    }
  return out;
}

}  // namespace imulab
