// The noise of an IMU, for people.
#pragma once

#include "imulab/files.hpp"
#include "imulab/noise.hpp"

#include <array>
#include <string>
#include <vector>

namespace imulab {

/// A customary unit: its size in SI, its name, and the name of the SI unit; of counts both are counts.
struct NoiseUnit {
  double size = 1;
  std::string name, si;
};

/// A row of the table of terms, in the order in which people read them: N, B, K, Q, R.
struct NoiseTermText {
  const char *name, *meaning;
  NoiseCoefficient NoiseCoefficients::*member;
  std::size_t batch_place;  ///< in BatchAxis::coefficients
  NoiseUnit gyro, accel, count;

  /// `of_axis`: NoiseAxis::unit.
  const NoiseUnit& unit(const std::string& of_axis) const { return of_axis == "count" ? count : of_axis == "rad/s" ? gyro : accel; }
};
const std::array<NoiseTermText, 5>& noise_terms();

/// What is known, in one sentence: "gyro N known to 0.2 %, B and K only bounded".
std::string noise_headline(const NoiseAnalysis& analysis);
std::string noise_headline(const NoiseBatch& batch);

/// A data sheet's coefficients as rows: axis, or triad if its axes are equal; term; value or bound with its unit; the same in SI; standing.
std::vector<std::array<std::string, 5>> sheet_rows(const NoiseAnalysis& analysis);
/// A log's comparison with a data sheet as rows: axis and term; sheet, log and 95 % interval in one unit, which is next; ratio; judgment.
std::vector<std::array<std::string, 7>> comparison_rows(const NoiseAnalysis& analysis);

/// A table of coefficients in customary units, with 95 % intervals; a coefficient that is not determined has only its bound.
/// Rows of the bounds of all axes: axis, N, processes, K, and the cost of each coast. Empty without bounds.
std::vector<std::array<std::string, 5>> bound_rows(const NoiseAnalysis& analysis);
std::vector<std::array<std::string, 5>> bound_rows(const NoiseBatch& batch);
/// What the columns of these rows are; empty without bounds.
std::vector<std::string> bound_legend(const NoiseAnalysis& analysis);
std::vector<std::string> bound_legend(const NoiseBatch& batch);

std::string noise_text(const NoiseAnalysis& analysis);
/// The mean of several logs, its spread, and the worst.
std::string noise_text(const NoiseBatch& batch);

}  // namespace imulab
