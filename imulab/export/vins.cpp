// VINS-Fusion and VINS-Mono (HKUST-Aerial-Robotics/VINS-Fusion, commit be55a93: vins_estimator/src/factor/integration_base.h): four numbers of noise.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab::export_io {

std::string vins_text(const ExportInput& input) {
  const NoiseValues n = noise_values(input, "VINS");
  const double root_rate = std::sqrt(n.rate_hz());
  // integration_base.h: per step Var(dv) = 0.5 dt^2 acc_n^2 (two samples, taken as independent) and Var(db) = dt^2 acc_w^2; N^2 dt and K^2 dt are
  // right.
  const double white = input.options.variance_matched ? std::sqrt(2.0) * root_rate : root_rate;
  Sentences facts{
      "Holds: noise, as the standard deviations of a sample.",
      "Discrete values: acc_n, gyr_n are those of a sample, acc_w, gyr_w those that the code multiplies by dt in each step.",
      fmt::format("Factors on the densities N and K, at {:g} Hz: {} for acc_n and gyr_n, sqrt(rate) = {:.6g} for acc_w and gyr_w.", n.rate_hz(),
                  input.options.variance_matched ? fmt::format("sqrt(2 rate) = {:.6g}", white) : fmt::format("sqrt(rate) = {:.6g}", white),
                  root_rate),
      input.options.variance_matched
          ? "Variance-matched: the code takes the two samples of a step as independent, which halves the variance; acc_n and gyr_n make up for that."
          : "acc_n, gyr_n are the standard deviation of a sample; the code's covariance of velocity and angle is then half the right one.",
      "Correct the readings with `imulab compensate` before: no key holds a matrix."};
  const auto line = [](const char* key, const NoiseValue& value, double factor, const char* unit, const char* density) {
    return noise_line(key, value.value * factor, value, unit, density);
  };
  return "%YAML:1.0\n" + noise_head(input, "VINS-Fusion and VINS-Mono", facts, n) + line("acc_n", n.accel_N, white, "m/s^2", "m/s^2/sqrt(Hz)") +
         line("gyr_n", n.gyro_N, white, "rad/s", "rad/s/sqrt(Hz)") + line("acc_w", n.accel_K, root_rate, "m/s^3", "m/s^3/sqrt(Hz)") +
         line("gyr_w", n.gyro_K, root_rate, "rad/s^2", "rad/s^2/sqrt(Hz)") +
         fmt::format("g_norm: {}  # m/s^2, the standard acceleration of free fall: put in the local one\n", exact_number(unit::g));
}

}  // namespace imulab::export_io
