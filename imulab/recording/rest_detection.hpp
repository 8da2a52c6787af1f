// Finds the rests of a recording by itself. Every threshold is estimated from the recording; a unit without noise is taken to have a hundredth of
// the Earth's rate, 1 ug, and the rounding of counts.
//
// The standard deviation within short windows has a dense, narrow cluster, the sensors' noise at rest, and a wide tail, the motion. The
// cluster's centre and width set the threshold of each triad; a run of quiet windows is a rest if the gyros' mean agrees with that of the
// other rests, so that steady turning is not taken for rest.
#pragma once

#include "imulab/recording/recording.hpp"

#include <array>
#include <string>
#include <vector>

namespace imulab {

struct RestOptions {
  double window_s = 0.5;        ///< length of a window; motion shorter than a fraction of it is not seen
  double shortest_s = 1.0;      ///< a shorter quiet run is no rest
  double threshold_sigmas = 6;  ///< threshold above the centre of the cluster, in its own (robust) widths
};

/// What was found, and with which thresholds (in the recording's units, per axis).
struct RestDetection {
  std::vector<Range> rests;
  std::array<double, 3> gyro_noise{}, accel_noise{};  ///< standard deviation of a sample at rest
  double gyro_factor = 0, accel_factor = 0;           ///< a window is quiet below noise x factor
  std::size_t turning = 0;                            ///< quiet runs refused because the unit was turning steadily
  std::vector<std::string> notes;                     ///< the same in words
};

/// The parts of a range between its gaps of at least `shortest_gap_s` and its saturated samples.
std::vector<Range> without_interruptions(const Recording& recording, Range range, double shortest_gap_s = 0);

/// A unit at rest on both sides of a shorter gap rested inside it.
inline constexpr double still_s = 0.25;

RestDetection detect_rests(const Recording& recording, const RestOptions& options = {});

}  // namespace imulab
