// The noise of an IMU as other programs take it: white noise N and random walk K, one number for a triad or one an axis.
#pragma once

#include "imulab/exchange.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::export_io {

/// 1/s, of K over N where nothing measured K: ten times that of a MEMS unit, so that a filter does not trust biases that it should follow.
inline constexpr double assumed_walk = 0.1;

/// A coefficient of a triad. Where the log does not determine it, the upper bound (95 %): programs that take it refuse zero, or trust the sensor
/// blindly.
struct NoiseValue {
  double value = 0;              ///< of the axis chosen, or the mean
  std::array<double, 3> axes{};  ///< NaN: the axis has no noise
  std::string comment;           ///< the axes' values, and which are bounds
  bool missing = false;          ///< the noise has no such triad
};

struct NoiseValues {
  NoiseValue accel_N, accel_K, gyro_N, gyro_K;  ///< m/s^2/sqrt(Hz), m/s^3/sqrt(Hz), rad/s/sqrt(Hz), rad/s^2/sqrt(Hz)
  std::optional<double> stream_rate_hz;         ///< absent: that of a data sheet that does not give it
  std::vector<std::string> facts;               ///< for the head of a file: which log; then which axis

  /// Throws Error where the rate is absent.
  double rate_hz() const;
};

/// Without a noise log, the white noise of the calibration's rests, and `assumed_walk` times it for the random walk, which short rests do not show.
/// A triad that the noise lacks is `missing`. Throws Error where there is neither (`program` needs it: the message says to give --noise), where it is
/// in counts, or where a coefficient has neither value nor bound.
NoiseValues noise_values(const ExportInput& input, const std::string& program);

/// The same for a target that has numbers for each axis: the facts are without the axis chosen.
NoiseValues noise_values_by_axis(const ExportInput& input, const std::string& program);

/// The same for a program whose biases are processes of one correlation time and standard deviations K sqrt(time / 2): of bounds, the time that makes
/// them tightest, else `usual_s`.
struct ProcessValues {
  NoiseValues noise;
  double time_s = 0;
};
ProcessValues noise_values_of_process(const ExportInput& input, const std::string& program, double usual_s);

/// B of a triad, [m/s^2] or [rad/s]; zero where nothing is known of it, with a comment that says so.
NoiseValue bias_instability(const ExportInput& input, bool gyro);

/// Every axis, where an axis without noise has the largest of the others.
std::array<double, 3> each_axis(const NoiseValue& value);

/// A term of the noise as a table has it: its name, what it is, and its unit for each triad.
struct NoiseTerm {
  const char* name;
  NoiseCoefficient NoiseCoefficients::*coefficient;
  const char *what, *accel_unit, *gyro_unit;
};
const std::array<NoiseTerm, 5>& noise_terms();

/// A sentence for each term of a triad that the log determines and a target leaves out, with its values. Empty without noise. `held`: letters of the
/// terms that the target has, as in "NK".
std::vector<std::string> noise_left_out(const ExportInput& input, std::string_view held);

/// The head of a file of noise alone: `facts`, then those of the noise and all but the terms `held`, as comments that begin with `mark`.
std::string noise_head(const ExportInput& input, std::string_view program, std::vector<std::string> facts, const NoiseValues& noise,
                       std::string_view mark = "#", std::string_view held = "NK");

/// The text of a triad's values, or a comment in its place that says that they are missing.
std::string triad_text(const NoiseValue& value, const std::string& text, std::string_view mark = "#");

/// "KEY: VALUE  # UNIT; the axes' values" as a line of YAML, or a comment where the triad is missing.
std::string noise_line(const std::string& key, const NoiseValue& value, const char* unit);
/// The same of a number made from densities in `density_unit`.
std::string noise_line(const std::string& key, double number, const NoiseValue& densities, const char* unit, const char* density_unit);

}  // namespace imulab::export_io
