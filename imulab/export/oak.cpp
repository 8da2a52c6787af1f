// OAK cameras (luxonis/depthai-core, commit ca7d6dea1: src/basalt/BasaltVIO.cpp): BasaltVIO takes the square root of the numbers that it calls
// standard deviations, as densities of Basalt, which multiplies them by the root of the rate (VladyslavUsenko/basalt-headers:
// include/basalt/calibration/calibration.hpp). The calibration in the camera's EEPROM (include/depthai/common/EepromData.hpp) has the IMU's position
// and orientation (imuExtrinsics) alone. setAccelBias and setGyroBias put their numbers, and a one for each scale, where Basalt has the biases.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab::export_io {

namespace {

std::string noise_call(const char* setter, const NoiseValue& density, const char* unit) {
  const std::array<double, 3> d = each_axis(density);
  return triad_text(
      density,
      fmt::format("    vio.{}({})  # {}; densities: {}\n", setter, row_text(Vector3d(d[0] * d[0], d[1] * d[1], d[2] * d[2])), unit, density.comment),
      "    #");
}

}  // namespace

std::string oak_text(const ExportInput& input) {
  const NoiseValues n = noise_values_by_axis(input, "BasaltVIO");
  const Sentences facts{"Holds: N^2 of each axis, CONTINUOUS values, and the rate by which BasaltVIO makes those of a sample from them.",
                        "The names end in Std, but BasaltVIO takes the root of each number.",
                        "An OAK camera stores where its IMU is, and no biases, scale factors or axes. Correct the readings with `imulab compensate` "
                        "before.",
                        "Do not call setAccelBias and setGyroBias: DepthAI 3 puts their numbers in the wrong places."};
  return noise_head(input, "OAK cameras (DepthAI's BasaltVIO)", facts, n, "#", "N") + "\n\ndef set_imu_noise(vio):\n" +
         noise_call("setAccelNoiseStd", n.accel_N, "(m/s^2)^2/Hz") + noise_call("setGyroNoiseStd", n.gyro_N, "(rad/s)^2/Hz") +
         fmt::format("    vio.setImuUpdateRate({})  # Hz\n", std::lround(n.rate_hz()));
}

}  // namespace imulab::export_io
