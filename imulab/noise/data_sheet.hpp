// The noise of an IMU by its data sheet: values as printed become coefficients, and what a sheet does not print is bounded by what it does.
//
// A data sheet prints a white density N, its square (a power spectral density), or an RMS in a bandwidth; and the flicker coefficient B of IEEE Std
// 952, or the in-run stability m, the minimum of the Allan deviation. At that minimum
//
//   m^2 = 2 N K / sqrt(3) + (2 ln 2 / pi) B^2                                                   (1)
//
// where the first term is the minimum of N^2 / tau + K^2 tau / 3, and no term is negative. So B <= m / 0.664 and K <= sqrt(3) m^2 / (2 N). Without a
// printed m, a printed B implies a visible flat part, m = 0.664 B; a printed K without both, m^2 = 2 N K / sqrt(3). If nothing but N is printed, the
// white noise is assumed to dominate up to `assumed_white_s`.
#pragma once

#include "imulab/noise.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

enum class SheetQuantity { N, psd, rms, bandwidth, noise_bandwidth, B, stability, K };
enum class SheetKind { undeclared, typical, maximum };

struct SheetEntry {
  bool gyro = false;
  std::optional<std::size_t> axis;  ///< absent: all three
  SheetQuantity quantity = SheetQuantity::N;
  double value = 0;  ///< SI
  SheetKind kind = SheetKind::undeclared;
  std::string text;  ///< as given
};

struct DataSheet {
  std::string name;
  double rate_hz = 0;  ///< of the readings; 0: not given
  SheetKind kind = SheetKind::undeclared;
  std::vector<SheetEntry> entries;

  /// The entry of an axis, or that of its triad; null: the sheet has none.
  const SheetEntry* find(bool gyro, std::size_t axis, SheetQuantity quantity) const;
};

/// Averaging time [s] up to which white noise dominates if a sheet prints nothing but N: then K = N / 10 per second, as exports assume without a log.
inline constexpr double assumed_white_s = 8.660254037844386;  // sqrt(3) / 2 / (0.1 / s)

/// Returns the coefficients of each triad that the sheet has. A typical value has no upper bound, a maximum is its own; a value that the sheet does
/// not print is `bounded`. Throws Error if a triad has no N, or more than one.
NoiseAnalysis data_sheet_noise(const DataSheet& sheet);

/// Returns each printed value beside that of the log. The log's stability is the minimum of its Allan deviation. Throws Error for a log in counts.
std::vector<SheetComparison> compare_with_sheet(const NoiseAnalysis& log, const DataSheet& sheet);

/// Returns the key that was meant by a usual name of a value, "gyro.N" by "gyro.ARW", "VRW" of accelerometers or "gyroscope noise density"; empty:
/// none.
std::string meant_noise_key(std::string_view name);

/// Returns true if the bounds of B and K are assumed because the data sheet prints nothing but N of this axis.
bool has_assumed_bounds(const NoiseCoefficients& axis);
/// Returns "typical", "maximum", "bounded" or "assumed", of a coefficient of an axis of a data sheet.
std::string sheet_standing(const NoiseCoefficients& axis, const NoiseCoefficient& coefficient);
/// The meaning of "bounded" and "assumed".
inline constexpr std::string_view sheet_legend =
    "bounded: not in the data sheet, but at most this by its other values; assumed: the sheet has N alone, and white noise is taken to dominate up "
    "to "
    "8.7 s";

}  // namespace imulab
