// The noise of an IMU from a recording at rest: which part is still, and the deviation and the coefficients of each axis.
#pragma once

#include "imulab/estimate/noise/deviation.hpp"
#include "imulab/estimate/noise/noise_fit.hpp"
#include "imulab/recording/recording_view.hpp"
#include "imulab/recording/session.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The longest stretch at rest without a gap or a saturated sample. A shorter one than 30 s or 1024 samples says too little.
struct StillPart {
  Recording recording;             ///< the whole one; lost samples filled, one or two at a time
  Range range;                     ///< of its samples
  std::vector<std::string> notes;  ///< what was cut, and why
};

/// Where the session has holds, they are the rests, else they are found. Throws Unsupported where no stretch is long enough: in motion, interrupted,
/// saturated or short; Error as detect_rests.
StillPart still_part(Recording recording, const Session& session);

/// The same of a recording in memory or on disk, which is valid and whose lost samples were filled.
struct StillRange {
  Range range;
  std::vector<std::string> notes;
  double interval_s = 0;  ///< of its samples: nominal, or of the even clock of stamps that scatter
};
StillRange still_range(const RecordingView& recording, const Session& session, std::size_t filled = 0);

struct NoiseAxis {
  std::string name;  ///< "gyro.x"
  std::string unit;  ///< of its readings: "rad/s", "m/s^2" or "count"
  std::vector<DeviationPoint> deviation;
  std::optional<NoiseFit> fit;  ///< none where the axis says nothing:
  std::string problem;          ///< why
};

struct NoiseAnalysis {
  std::string recording;
  double begin_s = 0, end_s = 0, interval_s = 0;
  std::size_t samples = 0;
  DeviationKind kind = DeviationKind::overlapping_allan;
  std::vector<NoiseAxis> axes;        ///< gyros, then accelerometers
  std::vector<std::string> notes;     ///< what was cut
  std::vector<std::string> warnings;  ///< what was found, and what it means for the result
};

struct NoiseOptions {
  DeviationKind kind = DeviationKind::overlapping_allan;
  bool remove_temperature = false;  ///< a parabola of the triad's temperature, fitted by least squares, is subtracted; it takes some of K and B along
};

/// Axes in parallel; the result does not depend on the number of threads. Throws Unsupported where a temperature is to be removed that the recording
/// does not have, or that does not change.
NoiseAnalysis analyze_noise(const StillPart& still, const NoiseOptions& options = {});
/// Of columns on disk one axis after the other, each in memory as a whole but once; the result is the same, bit for bit.
NoiseAnalysis analyze_noise(const RecordingView& recording, const StillRange& still, const NoiseOptions& options = {});

}  // namespace imulab
