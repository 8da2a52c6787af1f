// The least determined coefficients of a procedure for the hybrid method, and the turns that would help.
#pragma once

#include "imulab/estimate/hybrid/prediction.hpp"

#include <string>
#include <vector>

namespace imulab::hybrid {

/// The worst-determined direction: a combination of coefficients, each in units of its requirement (or of half its prior), and the further turns, one
/// or two of 90 or 180 deg about the table's axes at the end of the procedure, that help most.
struct Advice {
  std::vector<CoefficientIndex> coefficients;  ///< with a large part in it, the largest first
  double ratio = 0;                            ///< sigma along it, in those units
  std::vector<std::string> turns;              ///< "turn by 180 deg about the IMU's z axis while it is horizontal"; each with a rest after it
  double ratio_after = 0;                      ///< the largest ratio with them
};
Advice advise(const Plan& plan, const Prediction& prediction, const std::vector<Requirement>& requirements = {});

}  // namespace imulab::hybrid
