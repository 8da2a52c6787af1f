// The noise of an IMU from a recording at rest: the deviation and the coefficients of each axis.
#pragma once

#include "imulab/noise/deviation.hpp"
#include "imulab/noise/noise_fit.hpp"
#include "imulab/noise/still_part.hpp"
#include "imulab/recording/recording_view.hpp"

#include <array>
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

// Several logs together, of one unit or of a batch: mean, spread and worst of each coefficient.

struct BatchCoefficient {
  int determined = 0;  ///< number of logs that determine it
  /// Mean of these, with the larger of the uncertainty that the logs state and that their scatter shows; where none determines it, the largest bound.
  NoiseCoefficient mean;
  double spread = 0;  ///< standard deviation from log to log beyond what the logs' uncertainties explain; NaN for fewer than two
  double worst = 0;   ///< largest value, or bound of a log that does not determine it
  std::size_t worst_log = 0;
};

/// Q, N, B, K, R of one axis, in this order.
struct BatchAxis {
  std::string name, unit;
  std::array<BatchCoefficient, 5> coefficients;
};

struct NoiseBatch {
  std::vector<NoiseAnalysis> logs;
  std::vector<BatchAxis> axes;
};

/// Throws Error where the logs' units differ.
NoiseBatch noise_batch(std::vector<NoiseAnalysis> logs);

}  // namespace imulab
