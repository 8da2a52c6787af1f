// The search for the sizes of all sources of noise, a step each pass of the smoother.
#pragma once

#include "imulab/navigation/aided/filter.hpp"
#include "imulab/navigation/aided/problem.hpp"

#include <vector>

namespace imulab::aided {

inline constexpr double settled = 0.1;  // of a factor: a further pass changes sigmas by less than half of it

/// The factors of the first pass. The search comes down to the noise quickly, but hardly up: noise that no aid admits is taken for the sensors'. A
/// vehicle shakes more than a table; an aid has what its values differ by from any smooth motion, up to what its kind has where nothing is stated.
void set_first_factors(Problem& problem);

/// New factors are the means of what they may be, n values leaving a variance n / (n - 2) of the size that they show; from the second pass on by
/// secants in their logarithms, since the plain repetition creeps where much is hidden in other noise, and swings where two sources share what is
/// small.
class FactorSearch {
 public:
  /// Sets the factors. The largest relative change of those that the data resolve.
  double update(Problem& problem, const std::vector<NoiseEvidence>& evidence);

 private:
  struct Tried {
    double factor, step;  // logarithms
  };
  std::vector<Tried> before_;
  int passes_ = 0;  // the first is about another trajectory
};

}  // namespace imulab::aided
