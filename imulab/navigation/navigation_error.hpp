// Selection of states for a comparison with a truth, and rates of many runs.
#pragma once

#include "imulab/navigate.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab {

/// Keeps those states of a solution, as they are reached, that a comparison with a truth needs: both neighbors of each time of the truth, the first
/// state, and the last two.
class ComparedStates {
 public:
  explicit ComparedStates(const Solution& truth) : truth_(truth) {}
  void add(double time, const NavigationState& state);
  const Solution& solution() const { return solution_; }

 private:
  const Solution& truth_;
  std::size_t passed_ = 0;    // number of times of the truth that were passed
  std::vector<bool> needed_;  // for each state of the solution
  Solution solution_;
};

/// Pure-inertial rates over a set of runs [m/s]: RMS, and the median (CEP rate).
struct RateSummary {
  double rms = 0, cep = 0;
};
RateSummary rate_summary(const std::vector<double>& rates);

}  // namespace imulab
