// A mission: the motion of a vehicle or a table, and the sampling rate of an IMU.
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

/// Temperatures, linear between the points, constant before the first and after the last, and uniform in the unit. Each axis has its own sensor; only
/// unit, noise, reading at 25 degC and scale of a ThermalSource are used.
struct UnitTemperature {
  std::vector<double> time, celsius;  // s ascending, degC
  ThermalSource gyro, accel;

  double at(double t) const;  // degC
};

struct Mission {
  std::string imu;              // name of the IMU; empty: none
  double rate = 100;            // sampling rate [Hz]
  std::size_t truth_every = 1;  // number of samples per row of the truth
  Carrier carrier;
  FlightStart start;  // used with segments
  std::vector<Segment> segments;
  std::optional<Solution> track;  // replaces start and segments
  TrackSmoothing smoothing;       // smoothing of the track
  std::optional<UnitTemperature> temperature;
  std::vector<Aid> aids;  // aids without records
};

/// Returns the motion. Throws Error if `flight` or `track` does, and for a motion of no sample, of more than ten million, or longer than 1e6 s.
Trajectory trajectory_of(const Mission& mission);

}  // namespace imulab::motion

namespace imulab {

// A drive that validates a calibration, after Cheng 2014 section 3.3: a rest for alignment, then an hour around a city at 60 km/h.

struct CityDrive {
  std::vector<Increment> increments;  ///< increments of a perfect IMU
  Session session;                    ///< place and rest
  Solution truth;                     ///< one row per second
};

/// Returns 301 s of rest, then straight roads of 375 s with bends of 45 deg between them: 3879 s, at a latitude of 40 deg. `interval` is the sample
/// interval [s], a fraction of a second.
CityDrive city_drive(double interval);

}  // namespace imulab
