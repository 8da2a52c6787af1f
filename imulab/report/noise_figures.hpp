// The pictures of a noise analysis: deviations and spectra.
#pragma once

#include "imulab/noise.hpp"

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::report {

/// The readings of an axis by its place among the axes; empty: they are not there.
using AxisReadings = std::function<std::span<const double>(std::size_t axis)>;

/// "deg/√h" for deg/sqrt(h).
std::string noise_unit_text(std::string_view unit);
/// The value with its unit, or the bound of one that is not determined: "0.102 deg/√h", "below 1.6 deg/h".
std::string noise_value_text(const NoiseCoefficient& c, double size, const std::string& unit);

/// The term of a triad's worst axis: the largest value where an axis determines it, else the largest bound.
struct WorstTerm {
  const NoiseAxis* axis = nullptr;
  const NoiseCoefficient* c = nullptr;
  int determined = 0, axes = 0;  ///< number of axes
};
WorstTerm worst_term(const NoiseAnalysis& analysis, bool gyro, NoiseCoefficient NoiseCoefficients::*term);

/// x, y and z of each triad in one chart, with the slopes of N, B and K; and their spectra.
std::string deviation_charts(const NoiseAnalysis& analysis);
std::string spectrum_charts(const NoiseAnalysis& analysis);
/// Each axis by itself, on the scale of its triad: the deviation with the fitted terms, the spectrum with Welch's where there are readings.
std::string axis_charts(const NoiseAnalysis& analysis, const AxisReadings& readings);
/// The deviations of several logs, a chart an axis.
std::string batch_charts(const NoiseBatch& batch);

}  // namespace imulab::report
