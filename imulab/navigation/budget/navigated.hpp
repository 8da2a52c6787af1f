// The navigation errors of a session that the stated uncertainties of its calibration explain.
#pragma once

#include "imulab/navigate.hpp"
#include "imulab/navigation/budget/budget.hpp"

#include <exception>
#include <optional>

namespace imulab {

/// Along a navigation, as it goes: the calibration's covariance, and after an alignment its tilt and the noise that it measured in the rest.
class NavigatedBudget {
 public:
  /// Must outlive the navigation with these options, which calls it before what they called already. About `outputs` results.
  NavigatedBudget(const Calibration& calibration, const Session& session, NavigateOptions& options, int outputs = 120);
  NavigatedBudget(const NavigatedBudget&) = delete;
  NavigatedBudget& operator=(const NavigatedBudget&) = delete;

  /// At the end of the navigation; none for a calibration without uncertainties. Throws Error as GrowingBudget does.
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
