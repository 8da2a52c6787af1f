// The uncertainty of a coefficient as requirements state it, and the one rule by which all verbs compare it with a limit.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// What is wrong with a requirement that was made in memory: no coefficients, some that are not in the table or cannot be required, a limit that is
/// not finite and above 0.
std::vector<std::string> problems_of(const Requirement& requirement);

/// The data tell more of it than was known before: it is neither at its starting value nor at its prior.
bool is_result(const Calibration& calibration, CoefficientIndex index);

/// Standard uncertainty of a coefficient, SI; of matrices relative to the row's scale; infinite where it was not estimated.
double relative_uncertainty(const Calibration& calibration, CoefficientIndex index);

/// A standard uncertainty with its effective degrees of freedom. A sigma of 0: the coefficient is fixed by the frame.
struct StatedSigma {
  double sigma = 0, degrees_of_freedom = std::numeric_limits<double>::infinity();

  /// The larger of u and U/2: an uncertainty from few residuals counts with Student's t.
  double compared() const;
  /// With fewer than 3 degrees of freedom no requirement is met: nothing checks the uncertainty.
  bool has_enough() const { return sigma == 0 || degrees_of_freedom >= 3; }
  bool meets(double limit) const { return compared() <= limit && has_enough(); }
};

/// The worst of a requirement's coefficients against its limit.
RequirementResult compared(const Requirement& requirement, const std::function<StatedSigma(CoefficientIndex)>& of);

/// k: 95.45 % of a t distribution, two sigma of a normal one.
double coverage_factor(double degrees_of_freedom);

}  // namespace imulab
