// Equivalent degrees of freedom of Allan-type variances under power-law noise: Greenhall and Riley, Uncertainty of stability variances based on
// finite differences, PTTI 2003; NIST SP 1065, section 5.4.
#pragma once

#include <cstddef>
#include <vector>

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

/// Degrees of freedom of the total variance over a time `ratio` averaging times long (Howe 2000; SP 1065): b ratio - c, alpha 0 to -2.
double total_degrees_of_freedom(double ratio, int alpha);

// Which power law the noise follows at an averaging time.

/// The exponent alpha of the rate's spectrum f^alpha, between 2 and `least`, from the averages over m samples: by the lag-1 autocorrelation of the
/// averages, differenced until they are stationary (Riley and Greenhall 2004), of at most 8192 averages, spread over the record in runs of 1024.
/// Fewer than 30 averages tell little: the smaller exponent of the one at the longest time with 30 and of that by the ratio of standard to Allan
/// variance (Barnes's B1), which gives the wider bounds. A longer m than a third of the record is taken for that; a record has at least three
/// samples.
int noise_type(const std::vector<double>& phase, std::size_t m, int least);

}  // namespace imulab::noise
