// The uncertainty of a coefficient in the form of requirements, and the common rule by which verbs compare it with a limit.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Lists the faults of a requirement made in memory: no coefficients, unknown coefficients or ones that cannot be required, a limit that is not
/// finite and above 0.
std::vector<std::string> problems_of(const Requirement& requirement);

/// Returns true if the data are informative about a coefficient: it is neither at its starting value nor at its prior.
bool is_result(const Calibration& calibration, CoefficientIndex index);

/// Returns the standard uncertainty of a coefficient, SI; for matrices relative to the scale of the row; infinite if it was not estimated.
double relative_uncertainty(const Calibration& calibration, CoefficientIndex index);

/// A standard uncertainty with its effective degrees of freedom. A sigma of 0 means that the frame fixes the coefficient.
struct StatedSigma {
  double sigma = 0, degrees_of_freedom = std::numeric_limits<double>::infinity();

  /// Returns the larger of u and U/2: an uncertainty from few residuals is enlarged by Student's t.
  double compared() const;
  /// Returns false for fewer than 3 degrees of freedom: such an uncertainty is unchecked and meets no requirement.
  bool has_enough() const { return sigma == 0 || degrees_of_freedom >= 3; }
  bool meets(double limit) const { return compared() <= limit && has_enough(); }
};

/// Compares the worst of a requirement's coefficients with its limit.
RequirementResult compared(const Requirement& requirement, const std::function<StatedSigma(CoefficientIndex)>& of);

/// Returns k for 95.45 % of a t distribution, two sigma of a normal one.
double coverage_factor(double degrees_of_freedom);

}  // namespace imulab
