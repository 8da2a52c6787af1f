// Slow changes of a log with vibration or motion: the mean, and its drift.
#pragma once

#include "imulab/noise.hpp"
#include "imulab/recording/recording_view.hpp"

namespace imulab::noise {

/// Factors of at least one for sizes from `low` to `high`.
struct FactorRange {
  double value = 1, low = 1, high = 1;
};
/// A factor with its interval as a coefficient; the interval is the 95 % interval.
NoiseCoefficient determined_factor(const FactorRange& factor);

/// The parts of a log in which its slow change is measured: the whole log at rest (`second` is empty), or the first and last rest of one that moves.
struct SlowParts {
  Range first, second;
  bool at_rest() const { return second.size() == 0; }
};

/// Returns the bias instability: 0.664 B, or the least deviation, or the bound of 0.664 B.
double bias_instability(const NoiseAxis& rest);

/// Equation (6) of moving.hpp. Of the accelerometers of a log that moves, only the force along the vertical is known. `column`: of the axis in the
/// log; `floor`: F_w^2.
MovingCause drift_cause(const NoiseAxis& rest, const RecordingView& log, std::size_t column, const SlowParts& parts, double floor);

/// Equation (5), for a log at rest in `range`; `axis`: the noise of the axis at rest.
MovingCause rectification_cause(const NoiseAnalysis& rest, const NoiseAxis& axis, const RecordingView& log, std::size_t column, const Range& range,
                                double floor);

}  // namespace imulab::noise
