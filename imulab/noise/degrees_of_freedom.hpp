// Equivalent degrees of freedom of Allan-type variances for power-law noise: Greenhall and Riley, Uncertainty of stability variances based on finite
// differences, PTTI 2003; NIST SP 1065, section 5.4.
#pragma once

#include <cstddef>
#include <vector>

namespace imulab::noise {

/// A variance of differences of order `order` (2: Allan, 3: Hadamard) of `points` phase points at a distance of m points.
struct Variance {
  int order = 2;
  std::size_t points = 0, m = 1;
  bool overlapping = true;
  bool modified = false;  ///< variance of phase averaged over m points
};

/// Returns the degrees of freedom for noise of spectrum f^alpha, alpha from 2 to 1 - 2 order + 1 (order 2: -2; order 3: -4); points > order m.
double degrees_of_freedom(const Variance& variance, int alpha);

/// Returns the degrees of freedom of the total variance over `ratio` averaging times (Howe 2000; SP 1065): b ratio - c, alpha 0 to -2.
double total_degrees_of_freedom(double ratio, int alpha);

// The power law of the noise at an averaging time.

/// Returns the exponent alpha of the rate's spectrum f^alpha, between 2 and `least`, from averages over m samples. It uses the lag-1 autocorrelation
/// of the averages, differenced until they are stationary (Riley and Greenhall 2004), of at most 8192 averages in runs of 1024 spread over the
/// record. Fewer than 30 averages are uninformative: the result is then the smaller exponent (with wider bounds) of that at the longest time with 30
/// averages and that from the ratio of standard to Allan variance (Barnes's B1). m is limited to a third of the (3 or more) samples.
int noise_type(const std::vector<double>& phase, std::size_t m, int least);

}  // namespace imulab::noise
