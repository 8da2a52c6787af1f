// How much the readings of short windows scatter, and which windows are quiet compared with the rest of the recording.
#pragma once

#include "imulab/recording/recording_view.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace imulab {

inline constexpr std::size_t strides_per_window = 10;

/// Below this the readings of a column are not distinguished from a rest, however small the noise: that of an ideal IMU, and the scatter that
/// rounding makes of a rest between two steps. It also rounds the noise of a rest within one step to nothing.
double least_noise(const RecordingView& recording, std::size_t column);

/// The axes of one triad, in windows that begin every `stride` samples.
struct WindowedTriad {
  const RecordingView& recording;
  std::size_t first_column, stride;
  std::array<double, 3> least;  ///< noise
};

/// One triad: the noise at rest of its axes, and which windows are quiet.
struct Quietness {
  std::array<double, 3> noise{};
  double factor = 0;
  std::vector<char> quiet;
};

/// The windows of `without`, by number, are not looked at for the thresholds.
Quietness quietness_of(const WindowedTriad& triad, double threshold_sigmas, const std::vector<char>& without);

}  // namespace imulab
