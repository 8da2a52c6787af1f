// The unit's temperature while a chamber (or a room) has its set points, and how a thermal sensor reads it.
//
//   air    goes to the set point at the chamber's ramp
//   T      follows the air: T' = (air - T) / time constant
//   zeros  what the unit's zeros follow: T with play, min(max(zeros, T - h), T + h): h behind, against the direction of change
#pragma once

#include "imulab/model/sensor_model.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/motion.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace imulab {

inline constexpr double room_temperature = 25;  ///< degC: of a unit whose first step has no set point

/// Temperatures as functions of time, in closed form.
class TemperatureCourse {
 public:
  /// Of a motion's set points, each from the gap before its step on; the unit begins at the first step's. Without a chamber it has them at once.
  TemperatureCourse(const RigMotion& motion, const RigDeclaration* rig);

  struct State {
    double unit, zeros;  ///< degC
  };
  State at(double t) const;

 private:
  struct Segment {  // air on a line, the unit's temperature monotone
    double begin, air, slope;
    State at_begin;
  };
  State in(const Segment& segment, double t) const;
  void append(double begin, double end, double air, double slope, State& now);

  double time_constant_ = 0, hysteresis_ = 0;
  std::vector<Segment> segments_;
};

/// A reading as a linear function of the temperature.
struct ThermalScale {
  double at_25_degC = 25, per_K = 1;
  double reading(double degC) const { return at_25_degC + per_K * (degC - 25); }
};

/// What a sensor declares; else degC and K themselves. Throws Error for raw readings that do not say.
ThermalScale thermal_scale(const ThermalSource& source);
/// Of readings in degC or K.
ThermalScale thermal_scale(const std::string& unit);

/// At the middles of these samples.
std::vector<TemperatureCourse::State> temperatures_at(std::span<const Range> samples, const TemperatureCourse& course, double interval_s);

/// What a triad's thermal sensor reads at them: three columns, equal ones of one sensor; empty where there is none.
Columns3 thermal_readings(const std::optional<ThermalSource>& source, std::span<const TemperatureCourse::State> temperatures,
                          std::span<const Range> samples, std::uint64_t seed, const std::string& purpose);

/// What a triad's zeros follow, in the readings of its model; empty where that has none.
std::vector<double> followed_readings(const TriadModel& model, const std::optional<ThermalSource>& source,
                                      std::span<const TemperatureCourse::State> temperatures);

/// The same drift as a function of another reading.
TriadModel with_readings(TriadModel model, const ThermalScale& from, const ThermalScale& to, const std::string& unit);

}  // namespace imulab
