// Equivalent degrees of freedom of Allan-type variances under power-law noise: Greenhall and Riley, Uncertainty of stability variances based on
// finite differences, PTTI 2003; NIST SP 1065, section 5.4.
#pragma once

#include <cstddef>

namespace imulab::noise {

/// A variance of differences of order `order` (2: Allan, 3: Hadamard) of `points` phase points at m points' distance.
struct Variance {
  int order = 2;
  std::size_t points = 0, m = 1;
  bool overlapping = true;
  bool modified = false;  ///< of phase averaged over m points
};

/// For noise of spectrum f^alpha, alpha from 2 to 1 - 2 order + 1 (order 2: -2; order 3: -4). At least one term is expected: points > order m.
double degrees_of_freedom(const Variance& variance, int alpha);

/// Of the total variance over a time `ratio` averaging times long (Howe 2000; SP 1065): b ratio - c, alpha 0 to -2.
double total_degrees_of_freedom(double ratio, int alpha);

}  // namespace imulab::noise
