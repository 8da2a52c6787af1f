// The noise of an IMU from a recording at rest: the deviation and the coefficients of each axis.
#pragma once

#include "imulab/noise/deviation.hpp"
#include "imulab/noise/noise_fit.hpp"
#include "imulab/noise/still_part.hpp"
#include "imulab/recording/recording_view.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

struct NoiseAxis {
  std::string name;  ///< "gyro.x"
  std::string unit;  ///< of its readings: "rad/s", "m/s^2" or "count"
  std::vector<DeviationPoint> deviation;
  std::optional<NoiseFit> fit;  ///< none where the axis has no usable noise:
  std::string problem;          ///< why
};

struct NoiseAnalysis {
  std::string recording;
  double begin_s = 0, end_s = 0, interval_s = 0;
  std::size_t samples = 0;
  DeviationKind kind = DeviationKind::overlapping_allan;
  std::vector<NoiseAxis> axes;        ///< gyros, then accelerometers
  std::vector<std::string> notes;     ///< what was cut
  std::vector<std::string> warnings;  ///< findings, and their consequence for the result
};

struct NoiseOptions {
  DeviationKind kind = DeviationKind::overlapping_allan;
  bool remove_temperature = false;  ///< a least-squares parabola in the triad's temperature is subtracted; this removes some of K and B, too
};

/// Axes in parallel; the result does not depend on the number of threads. From columns on disk: one axis at a time, each in memory as a whole but
/// only once; the result is the same, bit for bit. Throws Unsupported where a temperature is to be removed that the recording does not have, or that
/// does not change.
NoiseAnalysis analyze_noise(const RecordingView& recording, const StillRange& still, const NoiseOptions& options = {});

}  // namespace imulab
