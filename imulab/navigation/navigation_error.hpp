// States that a comparison with a truth needs, and the rates of many runs.
#pragma once

#include "imulab/navigate.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab {

/// Keeps those of a solution's states, as they are reached, that its comparison with a truth needs: on both sides of each of the truth's times, the
/// first, and the last two.
class ComparedStates {
 public:
  explicit ComparedStates(const Solution& truth) : truth_(truth) {}
  void add(double time, const NavigationState& state);
  const Solution& solution() const { return solution_; }

 private:
  const Solution& truth_;
  std::size_t passed_ = 0;    // of the truth's times
  std::vector<bool> needed_;  // of the solution's states
  Solution solution_;
};

/// Pure-inertial rates over a set of runs [m/s]: root mean square, and the median, which half of the runs stay below (CEP rate).
struct RateSummary {
  double rms = 0, cep = 0;
};
RateSummary rate_summary(const std::vector<double>& rates);

}  // namespace imulab
