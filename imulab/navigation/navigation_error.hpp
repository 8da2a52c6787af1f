// A navigation solution compared with a reference solution.
#pragma once

#include "imulab/navigation/integration/strapdown.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace imulab {

/// Solution less truth at one time, east-north-up.
struct NavigationError {
  double time = 0;           // s
  Eigen::Vector3d position;  // m
  Eigen::Vector3d velocity;  // m/s
  Eigen::Vector3d attitude;  // phi [rad]: C_nb = (I - [phi x]) C_nb of the truth; phi_U is the error of the heading

  double horizontal() const { return position.head<2>().norm(); }
};

struct NavigationErrors {
  std::vector<NavigationError> history;  // at the times of the coarser of the two, the last one where both last end
  double rate = 0;                       // horizontal error at the end over the time navigated until then [m/s]
  std::vector<std::string> warnings;
};

/// Where the times differ the finer of the two is interpolated: position and velocity by the cubic through its positions and velocities (error
/// h^4/384 of the fourth derivative), attitude by the shortest rotation. Throws Error where the times do not overlap.
NavigationErrors navigation_errors(const Solution& solution, const Solution& truth);

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
