// A mission: the motion of a vehicle or a table, and how often an IMU samples it.
#pragma once

#include "imulab/navigation/motion/flight.hpp"
#include "imulab/navigation/motion/track.hpp"
#include "imulab/navigation/motion/unit_temperature.hpp"

#include <optional>
#include <string>

namespace imulab::motion {

struct Mission {
  std::string imu = "ideal IMU";  // its name
  double rate = 100;              // samples [Hz]
  std::size_t truth_every = 1;    // samples to a row of the truth
  Carrier carrier;
  FlightStart start;  // with segments
  std::vector<Segment> segments;
  std::optional<Solution> track;  // in their place
  TrackSmoothing smoothing;       // of the track
  std::optional<UnitTemperature> temperature;
};

/// The motion. Throws Error for what `flight` and `track` refuse, and for a motion of no sample, of more than ten million, or longer than 1e6 s.
Trajectory trajectory_of(const Mission& mission);

}  // namespace imulab::motion
