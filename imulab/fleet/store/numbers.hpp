// A calibration's numbers as the store keeps them: values and covariance of the estimated coefficients, in the accelerometers' frame.
#pragma once

#include "imulab/calibration.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::fleet {

/// The numbers of one calibration.
struct Numbers {
  std::vector<CoefficientIndex> estimated;
  Eigen::VectorXd values;      ///< SI
  Eigen::MatrixXd covariance;  ///< SI
  Eigen::VectorXd constant;    ///< variances that the same unit brings again (Calibration::constant_covariance); empty: zero
};

/// In the accelerometers' frame. Throws Error where nothing is estimated, a number is not finite or the covariance has no positive diagonal.
Numbers numbers_of(const Calibration& calibration);

/// Doubles, least significant byte first: the values, the covariance's lower triangle row by row, and the constant variances unless they are zero.
std::string packed(const Numbers& numbers);
/// The number of doubles for this number of coefficients, but for constant variances.
constexpr std::size_t packed_numbers(std::size_t n) { return n + n * (n + 1) / 2; }
/// Are these the numbers of n coefficients, without or with constant variances?
constexpr bool is_packed(std::string_view data, std::size_t n) {
  return data.size() == sizeof(double) * packed_numbers(n) || data.size() == sizeof(double) * (packed_numbers(n) + n);
}
double packed_number(std::string_view data, std::size_t place);
/// The numbers in packed bytes, as many as the coefficients require.
Numbers unpacked(std::string_view data, const std::vector<CoefficientIndex>& estimated);

/// "accel.offset.x accel.offset.y"
std::string layout_text(const std::vector<CoefficientIndex>& estimated);
/// Throws Error for an unknown coefficient.
std::vector<CoefficientIndex> parse_layout(std::string_view text);

std::int64_t crc32_of(std::string_view bytes);
std::string deflated(std::string_view text);
/// Throws Error where it is not `bytes` long.
std::string inflated(std::string_view data, std::size_t bytes);

}  // namespace imulab::fleet
