// The sensor model in integers, and how far it can be from the exact model: of 32 bits with sums of 64, and of 16 bits (Q15) with sums of 32.
//
//   v = reading 2^shift                                     |v| <= 2^30: the range of the readings                      Q15: 2^15
//   V = v - (k0 + (k1 + (k2 + (k3 t >> 30)) t >> 30) t >> 30 + s)    the thermal drift; t = (T - T0) 2^shift, |t| <= 2^30    Q15: 2^15, >> 15
//   V2 = V V >> 31, V3 = V2 V >> 31                                                                                     Q15: >> 15
//   out = (a0 + sum a_j V_j + a2 V2 + a3 V3 + sum c_j f_j) >> s      every >> rounds to nearest; a and c have up to 31 bits
// Where the matrix changes with the temperature, p is that sum without c, and out = p + ((sum m_j p_j >> s) + ((sum n_j p_j >> s) t >> 30)) t >> 30
// + (sum c_j f_j >> s).
#pragma once

#include "imulab/export/c_header_parts.hpp"

#include <array>
#include <cstdint>

namespace imulab::firmware {

/// The sizes that the arithmetic has.
struct FixedWords {
  const char *prefix, *data, *sum;  ///< of names in the header: "imulab_fixed"; types
  int data_bits;                    ///< 32, 16
  int v_bits;                       ///< v and t are at most 2^v_bits
  double largest_raw;               ///< of v with its drift, so that no product overflows
  int power_bits;                   ///< by which squares and cubes are shifted
  double largest_temperature;       ///< as the header takes it
  double largest_out, largest_sum;
  int most_shift;
};
/// 32 bits: outputs below 2^29, which leaves room for sums of them.
inline constexpr FixedWords words_of_32{"fixed", "int32_t", "int64_t", 32, 30, 2147483648.0, 31, 1073741824.0, 536870912.0, 4611686018427387904.0,
                                        60};
/// 16 bits: V V V / 2^30 and every sum stay below 2^31; the last leaves room for its rounding.
inline constexpr FixedWords words_of_16{"q15", "int16_t", "int32_t", 16, 15, 41000.0, 15, 32767.0, 32700.0, 2147483648.0 - 131072, 16};

struct FixedDrift {
  std::int64_t k0 = 0, k1 = 0, k2 = 0, k3 = 0;
  int shift = 0;
  double largest = 0, error = 0;  ///< in units of v
};

struct FixedRow {
  std::int64_t offset = 0;
  std::array<std::int64_t, 3> matrix{}, g_sensitivity{};
  std::int64_t quadratic = 0, cubic = 0;
  int shift = 1;
};

/// A row of the matrix's change with the temperature; t = 1 is 2^v_bits.
struct FixedChange {
  std::array<std::int64_t, 3> first{}, second{};
  int shift = 1;
};

struct FixedTriad {
  const FixedWords* words = &words_of_32;
  int in_bits = 0;            ///< a reading is an integer times 2^-in_bits of its unit; below 0 of counts that 16 bits do not hold
  std::int64_t in_limit = 0;  ///< readings beyond it are taken as the limit
  int in_shift = 0;
  double v_unit = 0;  ///< model's raw reading that is v = 1
  bool thermal = false;
  int temperature_bits = 0;                                      ///< a temperature is an integer times 2^-bits of its unit
  std::int64_t reference = 0, temperature_limit = 0;             ///< T0, and the largest |T - T0|
  std::int64_t lowest_temperature = 0, highest_temperature = 0;  ///< beyond them the limit is taken
  double moved = 0, end_error = 0;                               ///< by which T0 and the ends of the range are rounded, in the reading's unit
  int temperature_shift = 0;
  std::array<FixedDrift, 3> drift;
  std::array<FixedRow, 3> row;
  bool changes = false;  ///< the matrix, with the temperature
  std::array<FixedChange, 3> change;
  int out_bits = 0;               ///< an output is an integer times 2^-out_bits, SI
  double full_scale = 0;          ///< the largest output, SI
  std::array<double, 3> error{};  ///< of the outputs, SI: the largest within the ranges

  double largest_error() const { return std::max({error[0], error[1], error[2]}); }
};

/// `range`: the largest reading in its unit, 0 for the usual one. `force`: of the gyros' triad, the accelerometers'; else null. Throws Error where a
/// range is not positive or too large, or where the drift exceeds it (of 16 bits: a quarter of it).
FixedTriad fixed_triad(const SensorModel& model, const Input& in, double range, const FixedTriad* force, const FixedWords& words);

}  // namespace imulab::firmware
