// The navigation errors of a session that follow from the stated uncertainties of its calibration.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/navigation/budget/budget.hpp"

#include <exception>
#include <optional>

namespace imulab {

/// A budget along a navigation: the covariance of the calibration and, after an alignment, its tilt and the noise measured in the rest.
class NavigatedBudget {
 public:
  /// Adds its callbacks to `options`, before those already set; must outlive the navigation. Produces about `outputs` results.
  NavigatedBudget(const Calibration& calibration, const Session& session, NavigateOptions& options, int outputs = 120);
  NavigatedBudget(const NavigatedBudget&) = delete;
  NavigatedBudget& operator=(const NavigatedBudget&) = delete;

  /// Returns the budget at the end; absent for a calibration without uncertainties. Throws Error like GrowingBudget.
  std::optional<ErrorBudget> finish();

 private:
  void begin(const NavigationStart& start);
  void step(double time, const NavigationState& state, const Increment& sample);

  const Calibration& calibration_;
  StrapdownOptions strapdown_;
  int outputs_;
  std::optional<GrowingBudget> budget_;
  std::exception_ptr refused_;
};

}  // namespace imulab
