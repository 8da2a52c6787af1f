// True motion, a true unit and noise -> a recording. In memory on values: the same call serves the command, tests and Monte Carlo.
#pragma once

#include "imulab/model/noise.hpp"
#include "imulab/model/sensor_model.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace imulab {

/// Everything a simulation knows and a calibration has to find.
struct Truth {
  SensorModel model;
  double gravity = 0;                      ///< m/s^2
  std::optional<double> latitude{};        ///< rad; absent: the site's
  std::string frame = "accelerometers";    ///< or "rig": the body frame of the model
  NoiseModel accel_noise{}, gyro_noise{};  ///< what is no coefficient of the model: neither a calibration of one recording nor the model has it
};

/// Draws the unit from imu.grade (or takes `given`), and gravity and latitude from the site's values and sigmas. Declared noise goes before the
/// grade's, of which only white noise is taken unless imu.noise asks for all terms. In the accelerometers' frame (the accelerometer matrix is lower
/// triangular), but in the rig's for a grade with ranges. Thermal terms are those of the recordings' readings. Throws Error where a spread is not
/// declared.
Truth draw_truth(const Session& procedure, std::uint64_t seed, const std::optional<SensorModel>& given = {});

/// Samples from 0 to the end of the last step, or those inside the steps, at rate_hz (100 where absent). Each is the raw value of the mean motion
/// over its interval plus the noise terms, rounded to the resolution and stopped at the range and at the source's limits (SI or counts). Without
/// `rig` the rig is exact. Bit-equal on any number of threads.
Recording simulate_recording(const Session& procedure, const RecordingSource& source, const Truth& truth, std::uint64_t seed,
                             const RigErrors& rig = {});

}  // namespace imulab
