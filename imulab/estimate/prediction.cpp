#include "imulab/estimate/prediction.hpp"

#include "imulab/error.hpp"
#include "imulab/estimate/kernel/prior.hpp"
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
  out.cramer_rao = out.degrees_of_freedom = out.sigma;
  for (Eigen::Index i = 0; i < out.sigma.size(); ++i)
    out.degrees_of_freedom[i] = expanded_uncertainty(calibration, out.coefficients[static_cast<std::size_t>(i)]).degrees_of_freedom;
  out.frame = calibration.frame;
  for (const std::string& name : calibration.quality.unobservable) out.undetermined.push_back(coefficient_index(name));
  for (const std::string& name : calibration.quality.considered)
    if (const CoefficientIndex index = coefficient_index(name); contains(out.coefficients, index)) out.considered.push_back(index);
  return out;
}

StatedSigma predicted(const Prediction& p, CoefficientIndex index) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const auto at = std::find(p.coefficients.begin(), p.coefficients.end(), index) - p.coefficients.begin();
  if (at < std::ssize(p.coefficients)) return {p.sigma[at], p.degrees_of_freedom.size() > 0 ? p.degrees_of_freedom[at] : infinite};
  return {p.frame == BodyFrame::accelerometers && zero_by_frame(index) ? 0 : infinite};
}

void add_sizes(Prediction& p, const Session& procedure, const std::function<Prediction(const Session&)>& of) {
  for (const auto& [sigma, factor] : {std::pair{&p.sigma_of_half, 0.5}, {&p.sigma_of_twice, 2.0}}) {
    Session other = procedure;
    other.imu = kernel::of_size(procedure.imu, factor);
    const Prediction found = of(other);
    sigma->resize(p.sigma.size());
    for (std::size_t k = 0; k < p.coefficients.size(); ++k) (*sigma)[static_cast<Eigen::Index>(k)] = predicted(found, p.coefficients[k]).sigma;
  }
}

namespace {

/// Returns the sigma for a requirement, which must not come from a prior alone.
StatedSigma judged_sigma(const Prediction& p, CoefficientIndex index) {
  return contains(p.considered, index) ? StatedSigma{std::numeric_limits<double>::infinity()} : predicted(p, index);
}

}  // namespace

std::vector<RequirementResult> assess(const Prediction& p, const std::vector<Requirement>& requirements) {
  std::vector<RequirementResult> out;
  for (const Requirement& r : requirements) out.push_back(compared(r, [&](CoefficientIndex index) { return judged_sigma(p, index); }));
  return out;
}

std::vector<Shortfall> shortfalls(const Prediction& p, const std::vector<Requirement>& requirements) {
  std::vector<Shortfall> out;
  std::vector<CoefficientIndex> named;
  for (const Requirement& r : requirements) {
    throw_problems("", problems_of(r));
    for (const CoefficientIndex index : r.coefficients) {
      if (contains(named, index)) continue;
      const StatedSigma stated = judged_sigma(p, index);
      if (stated.meets(r.limit)) continue;
      out.push_back({r, index, stated.compared(), std::isinf(stated.sigma) ? "the procedure does not determine it" : ""});
      named.push_back(index);
    }
  }
  return out;
}

}  // namespace imulab
