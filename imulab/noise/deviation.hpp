// Allan-type deviations of a rate (gyro or accelerometer at rest) over averaging time, each with equivalent degrees of freedom and confidence bounds.
//
// Definitions: NIST SP 1065 (Riley 2008). The rate is integrated to phase, N samples to N + 1 points. Degrees of freedom: Greenhall and Riley 2003,
// for the power-law noise identified at each averaging time by the lag-1 autocorrelation (Riley and Greenhall 2004), and with fewer than 30 averages
// by the ratio of standard to Allan variance (Barnes 1969).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace imulab {

enum class DeviationKind { overlapping_allan, allan, modified_allan, hadamard, overlapping_hadamard, total };
/// By kind.
inline constexpr std::array<std::string_view, 6> deviation_names{"overlapping-allan",    "allan", "modified-allan", "hadamard",
                                                                 "overlapping-hadamard", "total"};
/// Empty where no kind has this name.
std::optional<DeviationKind> deviation_kind(std::string_view name);

/// One averaging time. Bounds are two-sided, from chi-square with `edf`. A total deviation is not corrected for its bias in flicker and random walk.
struct DeviationPoint {
  std::size_t factor = 0;  ///< averaging time in samples
  double tau = 0;          ///< [s]
  double deviation = 0;    ///< unit of the rate
  std::size_t terms = 0;   ///< number of squares averaged
  int noise_type = 0;      ///< power-law exponent alpha of the rate's spectrum: 2 (quantization) to -2 (random walk; -4 for Hadamard)
  double edf = 0;          ///< equivalent degrees of freedom
  double lower_68 = 0, upper_68 = 0, lower_95 = 0, upper_95 = 0;
};

/// Four averaging factors an octave (4 to 7 times a power of two) up to a third of the record.
std::vector<std::size_t> averaging_factors(std::size_t samples);

/// The deviation at each of the factors that the record is long enough for: at least one term (with the modified and Hadamard kinds 3 factors of
/// N + 1 points, with the others 2). Throws Error for fewer than 3 samples, a reading that is not finite, an interval that is not positive, or a
/// factor 0.
std::vector<DeviationPoint> deviation(std::span<const double> rate, double interval_s, const std::vector<std::size_t>& factors,
                                      DeviationKind kind = DeviationKind::overlapping_allan);
/// Computes the same deviations, bit for bit, in the memory of the readings, if the vector has room for one more number.
std::vector<DeviationPoint> deviation_in_place(std::vector<double>&& rate, double interval_s, const std::vector<std::size_t>& factors,
                                               DeviationKind kind = DeviationKind::overlapping_allan);

}  // namespace imulab
