// The quantities of an error budget as files name them: position, velocity and attitude error east, north and up, horizontal position error.
#pragma once

#include "imulab/core/units.hpp"
#include "imulab/navigation/budget/budget.hpp"

#include <array>
#include <string_view>

namespace imulab::result_io {

inline constexpr std::array<std::string_view, budget_quantities + 1> quantity_names{"pe", "pn", "pu", "ve", "vn", "vu", "ae", "an", "au", "ph"};

/// m, m/s, arcsec.
inline double unit_of(Eigen::Index quantity) { return quantity >= 6 && quantity < budget_quantities ? unit::arcsec : 1; }

/// One sigma of each quantity over time, SI.
inline BudgetRows total_sigma(const ErrorBudget& b) {
  BudgetRows sigma(budget_quantities, static_cast<Eigen::Index>(b.time.size()));
  for (std::size_t i = 0; i < b.time.size(); ++i) sigma.col(static_cast<Eigen::Index>(i)) = b.covariance[i].diagonal().cwiseMax(0.0).cwiseSqrt();
  return sigma;
}

}  // namespace imulab::result_io
