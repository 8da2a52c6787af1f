// The uncertainty of a coefficient as a certificate states it (GUM, JCGM 100): u, effective degrees of freedom, k, U.
#pragma once

#include "imulab/model/calibration.hpp"

namespace imulab {

/// SI. Type A is the uncertainty that the fit found from the data; type B is the declared uncertainty that is known separately: that of g, which
/// enters the accelerometers' scales. Declared errors of a rig and priors are part of the first: a calibration does not separate them.
struct ExpandedUncertainty {
  double standard = 0;            ///< u
  double from_fit = 0;            ///< type A
  double declared = 0;            ///< type B
  double degrees_of_freedom = 0;  ///< effective (Welch-Satterthwaite); infinite where the declared part dominates
  double coverage_factor = 0;     ///< k: 95.45 % of a t distribution
  double expanded = 0;            ///< U = k u
};

/// Of an estimated coefficient. Throws Error for one without uncertainty.
ExpandedUncertainty expanded_uncertainty(const Calibration& calibration, CoefficientIndex index);

}  // namespace imulab
