// A mission: the motion of a vehicle or a table, and how often an IMU samples it.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/session.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab::motion {

// The temperature profile of an IMU on a mission, and the readings of its thermal sensors.

/// Linear between the points; constant before the first and after the last. The same throughout the unit; each axis has a sensor of its own (of a
/// ThermalSource the unit, noise, reading at 25 degC and scale count).
struct UnitTemperature {
  std::vector<double> time, celsius;  // s ascending, degC
  ThermalSource gyro, accel;

  double at(double t) const;  // degC
};

struct Mission {
  std::string imu;              // its name; empty: none
  double rate = 100;            // samples [Hz]
  std::size_t truth_every = 1;  // samples to a row of the truth
  Carrier carrier;
  FlightStart start;  // with segments
  std::vector<Segment> segments;
  std::optional<Solution> track;  // in their place
  TrackSmoothing smoothing;       // of the track
  std::optional<UnitTemperature> temperature;
  std::vector<Aid> aids;  // without records
};

/// The motion. Throws Error for what `flight` and `track` refuse, and for a motion of no sample, of more than ten million, or longer than 1e6 s.
Trajectory trajectory_of(const Mission& mission);

}  // namespace imulab::motion

namespace imulab {

// The drive that proves a calibration, after Cheng 2014 section 3.3: a rest to align on, then an hour around a city at 60 km/h.

struct CityDrive {
  std::vector<Increment> increments;  ///< of a perfect IMU
  Session session;                    ///< place and rest
  Solution truth;                     ///< each second
};

/// 301 s of rest, then straight roads of 375 s with bends of 45 deg between them: 3879 s, at 40 deg of latitude. `interval` of the samples [s], a
/// part of a second.
CityDrive city_drive(double interval);

}  // namespace imulab
