// The rate's integral, and sums of its squared differences: the hot loops behind the deviations.
#pragma once

#include <cstddef>
#include <vector>

namespace imulab::noise {

/// x[0] = 0, x[k] = sum of the first k rates less their mean: no difference of second order changes by that, and less is rounded. Unit of the rate
/// times samples. In the memory of the rate, where it has room for one number more. Throws Error for a reading that is not finite.
std::vector<double> phase_of(std::vector<double>&& rate);

struct SquareSum {
  double sum = 0;
  std::size_t terms = 0;
};

/// Sum of squares of every second difference x[i + 2m] - 2 x[i + m] + x[i], for each factor m; in one pass over the phase, piece by piece, so that it
/// stays in cache.
std::vector<SquareSum> second_differences(const std::vector<double>& phase, const std::vector<std::size_t>& factors);
/// Likewise of third differences.
std::vector<SquareSum> third_differences(const std::vector<double>& phase, const std::vector<std::size_t>& factors);

/// Sum of squares of the differences of this order (2 or 3) at every m-th point only.
SquareSum strided_differences(const std::vector<double>& phase, std::size_t m, int order);
/// Sum of squares of sums of m neighboring second differences.
SquareSum modified_differences(const std::vector<double>& phase, std::size_t m);
/// Sum of squares of second differences about every inner point of the phase, reflected at both ends.
SquareSum total_differences(const std::vector<double>& phase, std::size_t m);

}  // namespace imulab::noise
