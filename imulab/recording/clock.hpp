// The numbers that files have for time -> nanoseconds.
#pragma once

#include "imulab/recording/session.hpp"

#include <cstdint>
#include <optional>

namespace imulab {

/// Turns the stamps of a table, one after the other, into nanoseconds less the zero.
class Clock {
 public:
  /// `rate_hz`: of the samples, which count time where the source has no stamps or numbers of samples. Throws Error without it there.
  Clock(const TimeSource& source, std::optional<double> rate_hz);

  /// A column's number becomes the integer that next() takes when multiplied by 10^exponent(): nanoseconds, or whole ticks or samples.
  int exponent() const { return exponent_; }
  int fraction_exponent() const { return fraction_exponent_; }

  /// Whether a stamp's time does not depend on those before.
  bool is_independent() const { return modulus_ == 0; }

  /// The stamp of the next row; nothing where it is more than 146 years from the zero, so that differences would not fit.
  std::optional<std::int64_t> next(std::int64_t stamp, std::int64_t fraction_ns = 0);
  /// The same of a table without stamps.
  std::optional<std::int64_t> next() { return next(row_++); }

 private:
  int exponent_ = 9, fraction_exponent_ = 0;
  std::int64_t zero_ = 0, modulus_ = 0, wrapped_ = 0, row_ = 1;  // a sample's stamp is the end of its interval
  std::optional<std::int64_t> last_;
  std::optional<double> per_second_;  // of ticks or samples
};

/// A number times 10^exponent as such an integer; nothing where it does not fit or is none.
std::optional<std::int64_t> scaled_stamp(double number, int exponent);

}  // namespace imulab
