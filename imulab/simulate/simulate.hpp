// True motion, a true unit and noise -> a recording. In memory on values: the same call serves the command, tests and Monte Carlo.
#pragma once

#include "imulab/model/sensor_model.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <cstdint>
#include <optional>

namespace imulab {

/// Everything a simulation knows and a calibration has to find.
struct Truth {
  SensorModel model;
  double gravity = 0;              ///< m/s^2
  double accel_noise_density = 0;  ///< m/s^2/sqrt(Hz): velocity random walk
  double gyro_noise_density = 0;   ///< rad/s/sqrt(Hz): angle random walk
};

/// Draws the unit from imu.grade (or takes `given`) and gravity from the site's value and sigma. Declared noise densities go before the
/// grade's. In the accelerometers' frame: the accelerometer matrix is lower triangular. Throws Error where a spread is not declared.
Truth draw_truth(const Session& procedure, std::uint64_t seed, const std::optional<SensorModel>& given = {});

/// Samples from 0 to the end of the last step, at rate_hz (100 where absent). Each is the raw value of the mean motion over its interval plus
/// white noise. Without `rig` the rig is exact. Bit-equal on any number of threads.
Recording simulate_recording(const Session& procedure, const RecordingSource& source, const Truth& truth, std::uint64_t seed,
                             const RigErrors& rig = {});

}  // namespace imulab
