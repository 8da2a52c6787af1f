// The calibration that a fit on rests gives.
#pragma once

#include "imulab/estimate/method.hpp"
#include "imulab/estimate/rests/fit.hpp"

#include <string_view>
#include <vector>

namespace imulab::rests {

/// Model, covariance and quality of a fit: raw units, g's uncertainty added, undetermined coefficients named.
Calibration calibration_of(std::string_view method, const kernel::RestStart& start, const RestProblem& problem, const Fit& fit,
                           const Session& session);

/// The findings of a fit: spreads, dropped parts of `all`, and what makes it doubtful. `under_noise`: the adjustment by the sample noise alone.
void add_findings(kernel::Findings& findings, Calibration& calibration, const Fit& fit, const Adjustment& under_noise, const Session& session,
                  const std::vector<std::string>& dropped, std::size_t all);

}  // namespace imulab::rests
