#include "imulab/estimate/kernel/rest_noise.hpp"

#include "imulab/estimate/kernel/input.hpp"
#include "imulab/recording/mean_noise.hpp"

#include <vector>

namespace imulab::kernel {

namespace {

/// Returns the samples of a recording in the rests that the fit used.
std::vector<Range> used_rests(const Quality& quality, const Recording& recording) {
  std::vector<Range> ranges;
  for (const PartResidual& rest : quality.rests) {
    if (!rest.used || (!rest.recording.empty() && rest.recording != recording.name)) continue;
    const Range range = recording.samples_in(rest.begin_s, rest.end_s);
    if (range.size() > 1) ranges.push_back(range);
  }
  return ranges;
}

/// Returns the variance of the output for independent noise of the readings.
Vector3d output_variance(const Matrix3d& matrix, const Vector3d& sigma) { return matrix.cwiseAbs2() * sigma.cwiseAbs2(); }

}  // namespace

std::optional<RestNoise> rest_noise(const Calibration& calibration, const CalibrationInput& input) {
  RestNoise out;
  Vector3d accel = Vector3d::Zero(), gyro = Vector3d::Zero();  // squared densities times seconds
  for (const Recording& recording : input.recordings) {
    std::vector<Range> ranges = used_rests(calibration.quality, recording);
    if (calibration.quality.rests.empty() && input.recordings.size() == 1) ranges = rests_of(input, recording).ranges;
    std::erase_if(ranges, [](const Range& range) { return range.size() < 2; });
    if (ranges.empty()) continue;
    const MeanNoise noise = measure_mean_noise(recording, summarize_rests(recording, ranges));
    double seconds = 0;
    for (const Range& range : ranges) seconds += static_cast<double>(range.size()) * recording.interval_s;
    const double weight = recording.interval_s * seconds;
    accel += weight * output_variance(calibration.model.accel.matrix, noise.sample.accel);
    gyro += weight * output_variance(calibration.model.gyro.matrix, noise.sample.gyro);
    out.rests += static_cast<int>(ranges.size());
    out.seconds += seconds;
    out.interval_s = recording.interval_s;
  }
  if (!(out.seconds > 0) || !accel.allFinite() || !gyro.allFinite()) return std::nullopt;
  out.accel = (accel / out.seconds).cwiseSqrt(), out.gyro = (gyro / out.seconds).cwiseSqrt();
  return out;
}

}  // namespace imulab::kernel
