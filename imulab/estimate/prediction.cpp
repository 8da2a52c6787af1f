#include "imulab/estimate/prediction.hpp"

#include "imulab/error.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/predict.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

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

namespace {

/// Infinite where the procedure does not determine it; zero where the frame fixes it.
double predicted_sigma(const Prediction& p, CoefficientIndex index) {
  const auto found = std::find(p.coefficients.begin(), p.coefficients.end(), index);
  if (found != p.coefficients.end()) return p.sigma[found - p.coefficients.begin()];
  return p.frame == "accelerometers" && zero_by_frame(index) ? 0 : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<RequirementResult> assess(const Prediction& p, const std::vector<Requirement>& requirements) {
  std::vector<RequirementResult> out;
  for (const Requirement& r : requirements) {
    throw_problems("", problems_of(r));
    RequirementResult result{to_string(r), std::string(coefficient(r.coefficients.front()).name), r.limit, 0, false};
    for (const CoefficientIndex index : r.coefficients)
      if (const double sigma = predicted_sigma(p, index); sigma > result.reached)
        result.reached = sigma, result.coefficient = coefficient(index).name;
    result.met = result.reached <= r.limit;
    out.push_back(std::move(result));
  }
  return out;
}

std::vector<Shortfall> shortfalls(const Prediction& p, const std::vector<Requirement>& requirements) {
  std::vector<Shortfall> out;
  std::vector<CoefficientIndex> named;
  for (const Requirement& r : requirements) {
    throw_problems("", problems_of(r));
    for (const CoefficientIndex index : r.coefficients) {
      if (contains(named, index)) continue;
      const double sigma = predicted_sigma(p, index);
      if (sigma <= r.limit) continue;
      out.push_back({r, index, sigma, std::isinf(sigma) ? "the procedure does not determine it" : ""});
      named.push_back(index);
    }
  }
  return out;
}

}  // namespace imulab
