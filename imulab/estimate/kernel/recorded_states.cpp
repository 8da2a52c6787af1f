#include "imulab/estimate/kernel/recorded_states.hpp"

#include "imulab/rig/thermal_scale.hpp"

#include <algorithm>
#include <numeric>

namespace imulab::kernel {

RecordedStates::RecordedStates(const Recording& recording, const Session& session, const SensorModel& model, const Scaling& scaling)
    : recording_(&recording) {
  common_.gravity = session.site.gravity();
  common_.full_force = common_.gravity;
  common_.full_rate = 1;  // rad/s: no gyro has a smaller range, and turns that are all slower show no higher order
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const Vector3d force = linear_output(model.accel, scaling.accel(reading_at(recording.accel, i)));
    const Vector3d rate = linear_output(model.gyro, scaling.gyro(reading_at(recording.gyro, i)));
    common_.full_force = std::max(common_.full_force, force.cwiseAbs().maxCoeff());
    common_.full_rate = std::max(common_.full_rate, rate.cwiseAbs().maxCoeff());
  }
  const RecordingSource source = session.source_of(recording.name);
  for (const bool of_gyros : {false, true}) {
    const std::vector<double>& readings = (of_gyros ? recording.gyro_temperature : recording.accel_temperature)[0];
    const std::optional<ThermalSource>& sensor = of_gyros ? source.gyro_temperature : source.accel_temperature;
    // Raw readings without a scale say nothing in K.
    if (temperature_ != nullptr || readings.empty() || !sensor || (sensor->unit == "raw" && !sensor->per_K)) continue;
    temperature_ = &readings;
    per_K_ = thermal_scale(*sensor).per_K;
    mean_ = std::accumulate(readings.begin(), readings.end(), 0.0) / static_cast<double>(readings.size());
  }
}

EffectState RecordedStates::at(std::size_t sample) const {
  EffectState state = common_;
  const std::vector<std::size_t>& starts = recording_->starts;
  const auto after = std::upper_bound(starts.begin(), starts.end(), sample);
  state.recording = static_cast<int>(after - starts.begin());
  const double begin = recording_->time_s(after == starts.begin() ? 0 : *(after - 1));
  const double end = recording_->time_s((after == starts.end() ? recording_->size() : *after) - 1);
  state.time = (recording_->time_s(sample) - begin) / std::max(end - begin, 1e-9) - 0.5;
  if (temperature_ != nullptr) state.warming = ((*temperature_)[sample] - mean_) / per_K_;
  return state;
}

}  // namespace imulab::kernel
