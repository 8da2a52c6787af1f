// LIO-SAM (TixiaoShan/LIO-SAM, commit 0be1fbe: src/imuPreintegration.cpp): densities; their squares are GTSAM's covariances, and the biases of two
// scans differ by the walk's density times the root of the time between them.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"

namespace imulab::export_io {

std::string lio_sam_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "LIO-SAM");
  const Sentences facts{"Holds: noise densities in CONTINUOUS time; no rate is needed.",
                        "Keys of params.yaml for ROS 1. For ROS 2, put them below /** and ros__parameters, without lio_sam.",
                        "Correct the readings with `imulab compensate` before. Set imuGravity to the local gravity."};
  return noise_head(input, "LIO-SAM", facts, n) + "lio_sam:\n" + noise_line("  imuAccNoise", n.accel_N, "m/s^2/sqrt(Hz)") +
         noise_line("  imuGyrNoise", n.gyro_N, "rad/s/sqrt(Hz)") + noise_line("  imuAccBiasN", n.accel_K, "m/s^3/sqrt(Hz)") +
         noise_line("  imuGyrBiasN", n.gyro_K, "rad/s^2/sqrt(Hz)");
}

}  // namespace imulab::export_io
