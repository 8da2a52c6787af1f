// The drive that proves a calibration, after Cheng 2014 section 3.3: a rest to align on, then an hour around a city at 60 km/h.
#pragma once

#include "imulab/navigation/integration/increment.hpp"
#include "imulab/navigation/integration/solution.hpp"
#include "imulab/recording/session.hpp"

#include <vector>

namespace imulab {

struct CityDrive {
  std::vector<Increment> increments;  ///< of a perfect IMU
  Session session;                    ///< place and rest
  Solution truth;                     ///< each second
};

/// 301 s of rest, then straight roads of 375 s with bends of 45 deg between them: 3879 s, at 40 deg of latitude. `interval` of the samples [s], a
/// part of a second.
CityDrive city_drive(double interval);

}  // namespace imulab
