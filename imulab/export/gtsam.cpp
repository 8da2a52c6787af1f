// GTSAM (borglab/gtsam 4.2: navigation/ImuFactor.cpp, CombinedImuFactor.cpp): noise as covariances in continuous time. A step of dt adds
// accelerometerCovariance / dt to the covariance of its acceleration, and biasAccCovariance dt to that of its bias.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

std::string covariance_call(const char* setter, const NoiseValue& density, const char* unit) {
  const std::array<double, 3> d = each_axis(density);
  return triad_text(density,
                    fmt::format("  params.{}(gtsam::Vector3({}, {}, {}).asDiagonal());  // {}; densities: {}\n", setter, exact_number(d[0] * d[0]),
                                exact_number(d[1] * d[1]), exact_number(d[2] * d[2]), unit, density.comment),
                    fmt::format("  // {}", setter));
}

}  // namespace

std::string gtsam_text(const ExportInput& input) {
  const NoiseValues n = noise_values_by_axis(input, "GTSAM");
  const Sentences facts{
      "Holds: noise in CONTINUOUS time, N^2 and K^2 of each axis; GTSAM divides and multiplies by the step, so no rate is needed.",
      "With ImuFactor in place of CombinedImuFactor, the biases' BetweenFactor over a time t has the standard deviations K sqrt(t).",
      "Not set: gravity, integrationCovariance, covariance of the first bias. Correct the readings with `imulab compensate` before."};
  return noise_head(input, "GTSAM", facts, n, "//") +
         "#pragma once\n\n#include <gtsam/navigation/CombinedImuFactor.h>\n\n"
         "inline void setImuNoise(gtsam::PreintegrationCombinedParams& params) {\n" +
         covariance_call("setAccelerometerCovariance", n.accel_N, "(m/s^2)^2/Hz") +
         covariance_call("setGyroscopeCovariance", n.gyro_N, "(rad/s)^2/Hz") + covariance_call("setBiasAccCovariance", n.accel_K, "(m/s^3)^2/Hz") +
         covariance_call("setBiasOmegaCovariance", n.gyro_K, "(rad/s^2)^2/Hz") + "}\n";
}

}  // namespace imulab::export_io
