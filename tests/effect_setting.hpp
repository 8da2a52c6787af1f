// A session that has all that any effect needs.
#pragma once

#include "imulab/model/effects.hpp"

namespace imulab {

inline constexpr EffectSetting everything{.accel = true,
                                          .gyro = true,
                                          .thermometer = true,
                                          .mount = true,
                                          .changed = true,
                                          .centrifuge = true,
                                          .latitude = true,
                                          .heading = true,
                                          .thermal = true,
                                          .sweep = true,
                                          .recordings = 4};

}  // namespace imulab
