// A MEMS unit of Dai 2011, table 2, and what calibrations of it say.
#pragma once

#include "imulab/simulate/simulate.hpp"

#include <cstdint>

namespace imulab::acceptance {

struct CalibratedUnit {
  Truth truth;
  SensorModel traditional;  // offsets and matrices alone
  SensorModel whole;
};

/// Drawn from the seed, as are the errors of its calibrations.
CalibratedUnit calibrated_unit(std::uint64_t seed);

}  // namespace imulab::acceptance
