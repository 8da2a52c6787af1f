#include "imulab/estimate/kernel/optional_terms.hpp"

#include "imulab/core/units.hpp"
#include "imulab/model/grade.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::kernel {

namespace {

/// By the offsets. The least are those of a navigation-grade IMU; MEMS sensors with 30 mg and 1 deg/s get 300 ug/g^2, 2 ppm/(deg/s) and 0.1 deg/s/g.
TermSizes sizes_of_offsets(double accel, double gyro) {
  using namespace unit;
  const double a = accel / g, w = gyro / deg;  // g, deg/s
  return {.accel_quadratic = std::max(30 * ug, 0.01 * a * g) / (g * g),
          .accel_cubic = std::max(10 * ug, 0.003 * a * g) / (g * g * g),
          .gyro_quadratic = std::max(1e-3, 2 * w) * ppm / deg,
          .gyro_cubic = std::max(1e-3, 2 * w) * 1e-9 / (deg * deg),
          .g_sensitivity = std::max(0.01 * deg_per_h, 0.1 * gyro) / g};
}

double rms(const Vector3d& v) { return v.norm() / std::sqrt(3.0); }

}  // namespace

PriorSizes optional_priors(const ImuDeclaration& imu, const Vector3d& accel_offset, const Vector3d& gyro_offset) {
  const TermSizes usual = imu.grade ? grade(*imu.grade).terms : sizes_of_offsets(rms(accel_offset), rms(gyro_offset));
  const TermSigmas& declared = imu.term_sigmas;
  constexpr double lever_arm = 0.05;  // m: of a unit that a hand holds
  PriorSizes sizes;
  sizes.accel.quadratic = declared.accel_quadratic.value_or(usual.accel_quadratic);
  sizes.accel.cubic = declared.accel_cubic.value_or(usual.accel_cubic);
  sizes.gyro.quadratic = declared.gyro_quadratic.value_or(usual.gyro_quadratic);
  sizes.gyro.cubic = declared.gyro_cubic.value_or(usual.gyro_cubic);
  sizes.g_sensitivity = declared.g_sensitivity.value_or(usual.g_sensitivity);
  sizes.lever_arm = declared.lever_arm.value_or(lever_arm);
  return sizes;
}

double delay_prior(const ImuDeclaration& imu, double interval_s) { return imu.term_sigmas.delay.value_or(std::max(1e-3, 0.5 * interval_s)); }

}  // namespace imulab::kernel
