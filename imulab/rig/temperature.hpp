// The temperature of an IMU in a chamber, a room or a hand with set points, and the reading of a thermal sensor.
//
//   air    moves to the set point at the chamber's ramp
//   T      follows the air: T' = (air - T) / time constant
//   zeros  the temperature that the IMU's zeros follow: T with play, min(max(zeros, T - h), T + h): h behind, against the direction of change
#pragma once

#include "imulab/recording.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/rig/thermal_scale.hpp"
#include "imulab/sensor_model.hpp"
#include "imulab/session.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace imulab {

/// Temperatures as functions of time, in closed form.
class TemperatureProfile {
 public:
  /// The profile of a motion's set points, each from the gap before its step on; the IMU begins at the first step's. On a machine that is no chamber
  /// it has them at once; in a hand it reaches each at its step's end, linearly from the one before.
  TemperatureProfile(const RigMotion& motion, const RigDeclaration* rig);

  struct State {
    double unit, zeros;  ///< degC
  };
  State at(double t) const;

 private:
  struct Segment {  // air linear in time, the IMU's temperature monotone
    double begin, air, slope;
    State at_begin;
  };
  State in(const Segment& segment, double t) const;
  void append(double begin, double end, double air, double slope, State& now);

  double time_constant_ = 0, hysteresis_ = 0;
  std::vector<Segment> segments_;
};

/// At the middles of these samples.
std::vector<TemperatureProfile::State> temperatures_at(std::span<const Range> samples, const TemperatureProfile& profile, double interval_s);

/// The readings of a triad's thermal sensor at them: three columns, equal for one sensor; empty if there is none.
Columns3 thermal_readings(const std::optional<ThermalSource>& source, std::span<const TemperatureProfile::State> temperatures,
                          std::span<const Range> samples, std::uint64_t seed, const std::string& purpose);

/// The temperature that a triad's zeros follow, in the readings of its model; empty if that has none.
std::vector<double> followed_readings(const TriadModel& model, const std::optional<ThermalSource>& source,
                                      std::span<const TemperatureProfile::State> temperatures);

/// This drift as a function of another reading.
TriadModel with_readings(TriadModel model, const ThermalScale& from, const ThermalScale& to, const std::string& unit);

}  // namespace imulab
