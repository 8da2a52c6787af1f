#include "imulab/estimate/kernel/recorded_states.hpp"

#include <algorithm>

namespace imulab::kernel {

RecordedStates::RecordedStates(const Recording& recording, const Session& session, const SensorModel& model, const Scaling& scaling)
    : recording_(&recording), thermometer_(thermometer_of(recording, session.source_of(recording.name))) {
  common_.gravity = session.site.gravity();
  common_.full_force = common_.gravity;
  common_.full_rate = 1;  // rad/s: no gyro has a smaller range, and slower turns do not excite higher-order terms
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const Vector3d force = linear_output(model.accel, scaling.accel(reading_at(recording.accel, i)));
    const Vector3d rate = linear_output(model.gyro, scaling.gyro(reading_at(recording.gyro, i)));
    common_.full_force = std::max(common_.full_force, force.cwiseAbs().maxCoeff());
    common_.full_rate = std::max(common_.full_rate, rate.cwiseAbs().maxCoeff());
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
  if (thermometer_) state.warming = thermometer_->warming(sample);
  return state;
}

}  // namespace imulab::kernel
