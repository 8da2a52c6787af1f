// The navigation errors of a session that the stated uncertainties of its calibration explain.
#pragma once

#include "imulab/navigation/budget/budget.hpp"
#include "imulab/navigation/navigate.hpp"

#include <optional>

namespace imulab {

/// Along Navigated::motion: the calibration's covariance, and after an alignment its tilt and the noise that it measured in the rest. About
/// `outputs` times. Absent for a calibration without uncertainties.
std::optional<ErrorBudget> navigated_budget(const Calibration& calibration, const Session& session, const Navigated& navigated, int outputs = 120);

}  // namespace imulab
