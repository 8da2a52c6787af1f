// What explains readings that contradict a fit with effects: one bad step, a unit that moved in its mount, an effect or a term that is larger than
// expected, or noise and a table that are worse than declared.
#pragma once

#include "imulab/estimate/turntable/fit.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace imulab::turntable {

struct Explained {
  Fit fit;
  std::vector<std::string> dropped;  ///< steps that were left out
  std::vector<std::string> widened;  ///< optional terms with a wider prior than expected
  std::vector<std::string> causes;   ///< names of effects and terms for which the readings speak, with those that explain as much
  std::string worst;                 ///< the step that deviates most, where noise and table explain more than it does
  bool by_size = false;              ///< noise or table are worse than declared
};

/// Takes the explanations one by one, that first for which most speaks: the logarithm of the ratio of the readings' probabilities with it and without
/// it, which for the noise and the table is that of the most likely size of their errors. `level`: of outliers, shared among the steps.
Explained explained(const Fit& fit, const kernel::EffectSizes& sizes, double level);

}  // namespace imulab::turntable
