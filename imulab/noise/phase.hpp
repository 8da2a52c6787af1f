// The integral of the rate, and sums of its squared differences: the inner loops of the deviations.
#pragma once

#include <cstddef>
#include <vector>

namespace imulab::noise {

/// Returns x[0] = 0, x[k] = sum of the first k rates minus their mean, which does not change second-order differences and reduces rounding. Its unit
/// is that of the rate times samples. It uses the memory of the rate if that has room for one more number. Throws Error for NaN or infinity.
std::vector<double> phase_of(std::vector<double>&& rate);

struct SquareSum {
  double sum = 0;
  std::size_t terms = 0;
};

/// Returns for each factor m the sum of squares of every second difference x[i + 2m] - 2 x[i + m] + x[i], piece by piece for the cache.
std::vector<SquareSum> second_differences(const std::vector<double>& phase, const std::vector<std::size_t>& factors);
/// Returns the same for third differences.
std::vector<SquareSum> third_differences(const std::vector<double>& phase, const std::vector<std::size_t>& factors);

/// Returns the sum of squares of the differences of this order (2 or 3) at every m-th point only.
SquareSum strided_differences(const std::vector<double>& phase, std::size_t m, int order);
/// Returns the sum of squares of sums of m successive second differences.
SquareSum modified_differences(const std::vector<double>& phase, std::size_t m);
/// Returns the sum of squares of second differences about every inner point of the phase, reflected at both ends.
SquareSum total_differences(const std::vector<double>& phase, std::size_t m);

}  // namespace imulab::noise
