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
};

/// In the accelerometers' frame. Throws Error where nothing is estimated, a number is not finite or the covariance has no positive diagonal.
Numbers numbers_of(const Calibration& calibration);

/// Doubles, least significant byte first: the values, then the covariance's lower triangle row by row.
std::string packed(const Numbers& numbers);
/// The number of bytes for this number of coefficients.
constexpr std::size_t packed_size(std::size_t n) { return sizeof(double) * (n + n * (n + 1) / 2); }
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
