// MATLAB's insEKF (R2022a; its documentation: fuse, estimateStates, AdditiveProcessNoise): a reading is fused with the covariance of a sample; the
// prediction is in continuous time, so that the process noise of a bias is the square of its walk's density.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

/// The squares of a density times a factor as a vector of MATLAB.
std::string squares(const NoiseValue& density, double factor) {
  const std::array<double, 3> d = each_axis(density);
  return fmt::format("[{}, {}, {}]", exact_number(factor * d[0] * d[0]), exact_number(factor * d[1] * d[1]), exact_number(factor * d[2] * d[2]));
}

std::string sensor_lines(const char* sensor, const NoiseValue& N, const NoiseValue& K, double rate_hz, const char* unit) {
  return triad_text(N,
                    fmt::format("measurementNoise.{0}Noise = {1}; % ({2})^2; densities [({2})/sqrt(Hz)]: {3}\n"
                                "filter.AdditiveProcessNoise(states.{0}_Bias, states.{0}_Bias) = diag({4}); % ({2}/s)^2/Hz; densities: {5}\n",
                                sensor, squares(N, rate_hz), unit, N.comment, squares(K, 1), K.comment),
                    "%");
}

}  // namespace

std::string matlab_ins_text(const ExportInput& input) {
  const NoiseValues n = noise_values_by_axis(input, "MATLAB");
  const double rate_hz = n.rate_hz();
  const Sentences facts{
      fmt::format("Holds: measurementNoise, N^2 rate of each axis, a DISCRETE value at {:g} Hz, at which every reading is fused.", rate_hz),
      "AdditiveProcessNoise of the biases: K^2, a CONTINUOUS value.",
      "estimateStates(filter, data, measurementNoise), or fuse(filter, sensor, reading, measurementNoise.GyroscopeNoise).",
      "Not set: process noise of the motion, which is that of the platform; first covariance of the biases. For insMotionOrientation, replace "
      "insMotionPose.",
      "Correct the readings with `imulab compensate` before: insEKF has no matrix."};
  return noise_head(input, "MATLAB (insEKF)", facts, n, "%") +
         "filter = insEKF(insAccelerometer, insGyroscope, insMotionPose);\nstates = stateinfo(filter);\n" +
         sensor_lines("Accelerometer", n.accel_N, n.accel_K, rate_hz, "m/s^2") + sensor_lines("Gyroscope", n.gyro_N, n.gyro_K, rate_hz, "rad/s");
}

}  // namespace imulab::export_io
