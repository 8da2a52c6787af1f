// The spread between the units of a fleet, apart from measurement uncertainty:
//
//   y_i = mean + b_i + e_i,   b_i ~ N(0, spread^2),   e_i ~ N(0, v_i) with known variances v_i
//
//   const RandomEffects r = random_effects(values, variances);   // one coefficient of each unit, SI
//   r.spread                                                     // between units; 0 where the uncertainties explain all differences
//
// Restricted maximum likelihood (Harville 1977, doi:10.1080/01621459.1977.10480998). With few units the spread is often zero while its interval is
// wide: use spread_high where a bound is needed.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/fleet.hpp"

namespace imulab {

/// Interval of the spread by the profile of the likelihood (Hardy and Thompson 1996). One value gives the mean with its own uncertainty, and no
/// spread. `confidence` is that of each interval alone. Throws Error where there is no value, and for a variance that is not above 0.
RandomEffects random_effects(const Eigen::ArrayXd& values, const Eigen::ArrayXd& variances, double confidence = 0.95);

/// The spread's square alone.
double random_spread2(const Eigen::ArrayXd& values, const Eigen::ArrayXd& variances);

}  // namespace imulab
