// The search for the sizes of all noise sources, one step per pass of the smoother.
#pragma once

#include "imulab/navigation/aided/filter.hpp"
#include "imulab/navigation/aided/problem.hpp"

#include <vector>

namespace imulab::aided {

inline constexpr double settled = 0.1;  // relative change of a factor: another pass changes sigmas by less than half of it

/// Sets the factors of the first pass. The search reduces noise quickly, but hardly increases it: noise that no aid explains is attributed to the
/// sensors. A vehicle therefore starts with more vibration than a table; an aid starts with the deviation of its values from smooth motion, up to the
/// usual size of its kind if none is stated.
void set_first_factors(Problem& problem);

/// Updates factors to the mean of their posterior: n values give a mean of n / (n - 2) times their observed variance. From the second pass on, it
/// uses secants of the logarithms: plain iteration is slow if noise is hidden in other noise, and oscillates if two sources share little.
class FactorSearch {
 public:
  /// Sets the factors. Returns the largest relative change of the factors that the data resolve.
  double update(Problem& problem, const std::vector<NoiseEvidence>& evidence);

 private:
  struct Tried {
    double factor, step;  // logarithms
  };
  std::vector<Tried> before_;
  int passes_ = 0;  // the first is about another trajectory
};

}  // namespace imulab::aided
