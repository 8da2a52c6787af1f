// FAST-LIO2 (hku-mars/FAST_LIO, commit 7cc4175: src/IMU_Processing.hpp, include/IKFoM_toolkit/esekfom/esekfom.hpp): variances of a sample. A step of
// dt adds dt^2 times them to the covariance of velocity, angle and biases, where N^2 dt and K^2 dt are right.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

std::string fast_lio_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "FAST-LIO2");
  const double rate_hz = n.rate_hz();
  const Sentences facts{
      fmt::format("Holds: variances of a sample, DISCRETE values at {:g} Hz: N^2 rate and K^2 rate. At another rate they are others.", rate_hz),
      "The code multiplies each of them by dt^2 in a step, the biases' too.", "Correct the readings with `imulab compensate` before."};
  const auto line = [&](const char* key, const NoiseValue& density, const char* unit, const char* density_unit) {
    return noise_line(fmt::format("  {}", key), density.value * density.value * rate_hz, density, unit, density_unit);
  };
  return noise_head(input, "FAST-LIO2", facts, n) + "mapping:\n" + line("acc_cov", n.accel_N, "(m/s^2)^2", "m/s^2/sqrt(Hz)") +
         line("gyr_cov", n.gyro_N, "(rad/s)^2", "rad/s/sqrt(Hz)") + line("b_acc_cov", n.accel_K, "(m/s^3)^2", "m/s^3/sqrt(Hz)") +
         line("b_gyr_cov", n.gyro_K, "(rad/s^2)^2", "rad/s^2/sqrt(Hz)");
}

}  // namespace imulab::export_io
