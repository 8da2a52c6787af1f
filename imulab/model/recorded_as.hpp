// How the recording of a calibration had a triad's readings: what a program that takes the same readings must convert.
#pragma once

#include <array>
#include <string>

namespace imulab {

/// Reading of column j, as the driver gives it, times `si_factor(unit) / counts_per_unit` (of increments also divided by `interval_s`) is the raw
/// reading of the calibration's model along the body axis `axes[j]`.
struct RecordedAs {
  std::string unit;                                   ///< as a session names it: "g", "deg/s", "count"; of increments "deg", "g*s"
  double counts_per_unit = 1;                         ///< number of the recording's counts in one `unit`; 1: the recording has the unit itself
  double interval_s = 0;                              ///< of increments: the nominal interval that they were divided by; 0: the readings are rates
  std::array<std::string, 3> axes{"+x", "+y", "+z"};  ///< along which body axis each column measures, with its sign
  bool operator==(const RecordedAs&) const = default;
};

}  // namespace imulab
