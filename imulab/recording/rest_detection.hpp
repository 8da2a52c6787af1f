// Finds the rests of a recording. Every threshold is estimated from the recording; an IMU without noise is assumed to have a hundredth of the
// Earth's rate, 1 ug, and the rounding of counts.
//
// The standard deviation within short windows has a dense, narrow cluster, the sensors' noise at rest, and a wide tail, the motion. The
// cluster's center and width set the threshold of each triad; a run of quiet windows is a rest if the gyros' mean agrees with that of the
// other rests, so that a steady rotation is not taken for a rest.
#pragma once

#include "imulab/recording/pieces.hpp"

#include <array>
#include <string>
#include <vector>

namespace imulab {

struct RestOptions {
  double window_s = 0.5;        ///< length of a window; motion shorter than a fraction of it is not detected
  double shortest_s = 1.0;      ///< a shorter quiet run is not a rest
  double threshold_sigmas = 6;  ///< threshold above the center of the cluster, in its own (robust) widths
};

/// The rests, and the thresholds used (in the recording's units, per axis).
struct RestDetection {
  std::vector<Range> rests;
  std::array<double, 3> gyro_noise{}, accel_noise{};  ///< standard deviation of a sample at rest
  double gyro_factor = 0, accel_factor = 0;           ///< a window is quiet below noise x factor
  std::size_t turning = 0;                            ///< quiet runs rejected because the IMU was turning steadily
  std::vector<std::string> notes;                     ///< the same in words
};

/// An IMU at rest on both sides of a shorter gap was at rest inside it.
inline constexpr double still_s = 0.25;

/// Throws Error for what `validate` refuses.
RestDetection detect_rests(const Recording& recording, const RestOptions& options = {});
/// Of a recording that is valid.
RestDetection detect_rests(const RecordingView& recording, const RestOptions& options = {});

}  // namespace imulab
