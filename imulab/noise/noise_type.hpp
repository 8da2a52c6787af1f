// Which power law the noise follows at an averaging time.
#pragma once

#include <cstddef>
#include <vector>

namespace imulab::noise {

/// The exponent alpha of the rate's spectrum f^alpha, between 2 and `least`, from the averages over m samples: by the lag-1 autocorrelation of the
/// averages, differenced until they are stationary (Riley and Greenhall 2004), of at most 8192 averages, spread over the record in runs of 1024.
/// Fewer than 30 averages tell little: the smaller exponent of the one at the longest time with 30 and of that by the ratio of standard to Allan
/// variance (Barnes's B1), which gives the wider bounds. A longer m than a third of the record is taken for that; a record has at least three
/// samples.
int noise_type(const std::vector<double>& phase, std::size_t m, int least);

}  // namespace imulab::noise
