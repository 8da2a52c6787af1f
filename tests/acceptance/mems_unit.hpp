// A MEMS unit of Dai 2011, table 2, drawn and calibrated.
#pragma once

#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/simulate/simulate.hpp"

#include <cstdint>

namespace imulab::acceptance {

struct CalibratedUnit {
  Truth truth;              // with all noise terms of the grade
  SensorModel traditional;  // offsets and matrices alone
  SensorModel whole;
};

/// The unit, the machines' errors and all noise are drawn from the seed.
CalibratedUnit calibrated_unit(std::uint64_t seed);

/// Offsets and matrices from a rate table's six mounts, as in multi-position methods: the accelerometers and the gyros' offset from the rests, the gyros'
/// matrix from opposed rates.
SensorModel traditional_calibration(const Recording& recording, const Session& session);

}  // namespace imulab::acceptance
