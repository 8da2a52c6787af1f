#include "imulab/model/grade.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"

#include <array>
#include <string>

namespace imulab {

namespace {

using namespace unit;

// Biases, scales and misalignments lie inside the ranges of Xu 2024 table 1; docs/simulate.md gives those ranges and the source of every number.
constexpr std::array<Grade, 4> catalogue{{
    {.name = "strategic",
     .gyro_bias = 1e-3 * deg_per_h,
     .accel_bias = 10 * ug,
     .gyro_scale = 5 * ppm,
     .accel_scale = 5 * ppm,
     .gyro_misalignment = 0.5 * arcsec,
     .accel_misalignment = 0.5 * arcsec,
     .g_sensitivity = 0,
     .gyro_noise_density = 1e-4 * deg_per_sqrt_h,
     .accel_noise_density = 1 * ug_per_sqrt_hz},
    {.name = "navigation",
     .gyro_bias = 0.01 * deg_per_h,
     .accel_bias = 70 * ug,
     .gyro_scale = 20 * ppm,
     .accel_scale = 20 * ppm,
     .gyro_misalignment = 10 * arcsec,
     .accel_misalignment = 10 * arcsec,
     .g_sensitivity = 0,
     .gyro_noise_density = 1e-3 * deg_per_sqrt_h,
     .accel_noise_density = 5 * ug_per_sqrt_hz},
    {.name = "tactical",
     .gyro_bias = 3 * deg_per_h,
     .accel_bias = 300 * ug,
     .gyro_scale = 150 * ppm,
     .accel_scale = 150 * ppm,
     .gyro_misalignment = 60 * arcsec,
     .accel_misalignment = 60 * arcsec,
     .g_sensitivity = 0,
     .gyro_noise_density = 0.1 * deg_per_sqrt_h,
     .accel_noise_density = 100 * ug_per_sqrt_hz},
    {.name = "mems",
     .gyro_bias = 1 * deg,
     .accel_bias = 0.3,
     .gyro_scale = 0.01,
     .accel_scale = 0.01,
     .gyro_misalignment = 0.01,
     .accel_misalignment = 0.01,
     .g_sensitivity = 0.05 * deg / g,
     .gyro_noise_density = 0.3 * deg_per_sqrt_h,
     .accel_noise_density = 150 * ug_per_sqrt_hz},
}};

}  // namespace

std::span<const Grade> grades() { return catalogue; }

const Grade& grade(std::string_view name) {
  std::string known;
  for (const Grade& g : catalogue) {
    if (g.name == name) return g;
    known += (known.empty() ? "" : ", ") + std::string(g.name);
  }
  throw Error("[imu] grade = \"" + std::string(name) + "\": one of " + known + " was expected");
}

}  // namespace imulab
