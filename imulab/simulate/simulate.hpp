// True motion, a true IMU and noise -> a recording. In memory, on values: the command, tests and Monte Carlo runs use the same call.
//
//   const Session procedure = dai_unit_procedure({});
//   const Truth truth = draw_truth(procedure, 1);
//   const RecordingSource& source = procedure.recordings.front();
//   const Recording recording = simulate_recording(procedure, source, truth, 1, draw_rig_errors(procedure, source, 1));
#pragma once

#include "imulab/model/effects.hpp"
#include "imulab/model/imu_noise.hpp"
#include "imulab/model/sensor_model.hpp"
#include "imulab/recording/recording.hpp"
#include "imulab/recording/session.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The exact values of a simulation, which a calibration should find.
struct Truth {
  SensorModel model;
  double gravity = 0;                      ///< m/s^2
  std::optional<double> latitude{};        ///< rad; absent: the site's
  std::string frame = "accelerometers";    ///< or "rig": the body frame of the model
  NoiseModel accel_noise{}, gyro_noise{};  ///< errors that are not coefficients of the model; a calibration of one recording does not find them
  std::vector<EffectValue> effects{};      ///< of [imu.effects]
};

/// Draws the IMU from imu.grade (or takes `given`), and gravity and latitude from the site's values and sigmas. Declared noise replaces the
/// grade's, of which only white noise is taken unless imu.noise asks for all terms. In the accelerometers' frame (the accelerometer matrix is lower
/// triangular), but in the rig's for a grade with ranges. Thermal terms are those of the recordings' readings. Throws Error where a spread is not
/// declared.
Truth draw_truth(const Session& procedure, std::uint64_t seed, const std::optional<SensorModel>& given = {});

/// Samples from 0 to the end of the last step, or those inside the steps, at rate_hz (100 where absent). Each is the raw value of the mean motion
/// over its interval plus the noise terms, rounded to the resolution and clipped to the range and to the source's limits (SI or counts). Without
/// `rig` the rig is exact. Bit-equal on any number of threads.
Recording simulate_recording(const Session& procedure, const RecordingSource& source, const Truth& truth, std::uint64_t seed,
                             const RigErrors& rig = {});

}  // namespace imulab
