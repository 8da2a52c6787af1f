// The part of the effects' states that follows from a recording alone: time, temperature, and the largest force and rate.
#pragma once

#include "imulab/model/effects.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/scaling.hpp"
#include "imulab/rig/thermal_scale.hpp"
#include "imulab/session.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab::kernel {

/// A change of temperature from which thermal terms can be estimated: 10 K or more, in one recording or between several.
struct TemperatureSweep {
  ThermalReading reading;              ///< its reference is the recording's mean
  double per_K = 1;                    ///< change of the reading
  double range_K = 0, shortest_s = 0;  ///< size of the change, and its duration at the fastest rate over 30 s
  bool accel = false, gyro = false;    ///< triads whose thermometer it is
};

/// States of one recording or of joined recordings, which must outlive this object. Time is relative to each recording.
class RecordedStates {
 public:
  /// The model applies to scaled readings.
  RecordedStates(const Recording& recording, const Session& session, const SensorModel& scaled_model, const Scaling& scaling);

  /// Returns the state of a sample without force and rate.
  EffectState at(std::size_t sample) const;
  /// Returns the state in the middle of a range, in a sweep with the mean temperature and rate over it.
  EffectState over(const Range& range) const;
  int recordings() const { return static_cast<int>(recording_->starts.size()) + 1; }
  bool thermometer() const { return thermometer_.has_value(); }
  const std::optional<TemperatureSweep>& sweep() const { return sweep_; }

 private:
  /// Returns the number of the joined recording that has this sample.
  int recording_of(std::size_t sample) const;
  /// The blocks of one recording.
  struct Blocks {
    std::size_t first_sample, first, size;
  };
  /// Sets the temperature of a sample in a sweep, between the means of the blocks around it, and its rate, the slope between their neighbors.
  void set_warming(std::size_t sample, EffectState& state) const;

  const Recording* recording_;
  EffectState common_;
  std::optional<Thermometer> thermometer_;
  std::optional<TemperatureSweep> sweep_;
  std::size_t block_ = 1;          ///< samples of a mean of the thermometer
  std::vector<double> warming_{};  ///< K, of each block in a sweep
  std::vector<Blocks> blocks_{};   ///< of each recording in a sweep
};

}  // namespace imulab::kernel
