// Where the factor of a filter comes from, for people.
#pragma once

#include "imulab/noise.hpp"

#include <array>
#include <string>
#include <vector>

namespace imulab {

/// A cause of one triad: of the axis with the largest factor.
struct MovingCell {
  std::string axis;                     ///< "x"; empty: the triad has no such cause
  std::string factor = "-", interval;   ///< "4.1", "3.9 to 4.3"
  double value = 0, low = 0, high = 0;  ///< for a picture; 0: not determined
};
struct MovingRow {
  std::string cause, parameter;
  MovingCell gyro, accel;
};
/// The table of causes. Requires `analysis.moving`.
std::vector<MovingRow> moving_rows(const NoiseAnalysis& analysis);
/// What a filter should use as rows: parameter, value and factor of the gyros, of the accelerometers.
std::vector<std::array<std::string, 3>> moving_totals(const NoiseAnalysis& analysis);
/// Sizes of the causes, and why some are not determined: a sentence each.
std::vector<std::string> moving_details(const NoiseAnalysis& analysis);

/// "gyro white 1.3, vibration 4.1: use N 0.41 deg/sqrt(h); accelerometer as at rest"
std::string moving_headline(const NoiseAnalysis& analysis);
std::string moving_text(const NoiseAnalysis& analysis);

}  // namespace imulab
