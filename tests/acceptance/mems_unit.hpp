// A MEMS IMU of Dai 2011, table 2, drawn and calibrated.
#pragma once

#include "imulab/sensor_model.hpp"

#include <cstdint>

namespace imulab::acceptance {

struct CalibratedUnit {
  SensorModel truth;
  SensorModel traditional;  // offsets and matrices alone, from rests in 24 positions and turns about three axes at 10 deg/s
  SensorModel whole;        // from chamber, rate table and centrifuge
};

/// The IMU, the errors of all machines and all noise are drawn from the seed.
CalibratedUnit calibrated_unit(std::uint64_t seed);

}  // namespace imulab::acceptance
