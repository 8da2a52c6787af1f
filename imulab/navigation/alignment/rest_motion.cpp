#include "imulab/navigation/alignment/rest_motion.hpp"

#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/integration/increment.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <array>
#include <cmath>

namespace imulab::alignment {
namespace {

/// Returns the white noise density that explains the differences of means over twenty parts of the rest. It uses second differences, which are
/// independent of a steady drift. On a swaying base it contains the sway, far above the sensors' noise, which must then be declared.
double noise_density(const RestMotion& rest, Vector3d integration::BodyStep::*integral) {
  constexpr std::size_t parts = 20;
  std::array<Vector3d, parts> mean;
  const std::size_t steps = rest.steps.size();
  const double part = rest.duration / parts;
  for (std::size_t k = 0; k < parts; ++k) {
    const std::size_t begin = steps * k / parts, end = steps * (k + 1) / parts;
    mean[k].setZero();
    for (std::size_t i = begin; i < end; ++i) mean[k] += rest.steps[i].*integral;
    mean[k] /= part * static_cast<double>((end - begin) * parts) / static_cast<double>(steps);
  }
  double square = 0;
  for (std::size_t k = 2; k < parts; ++k) square += (mean[k] - 2 * mean[k - 1] + mean[k - 2]).squaredNorm();
  return std::sqrt(square / (6. * 3 * (parts - 2)) * part);
}

}  // namespace

RestMotion rest_motion(std::span<const TimedIncrement> samples, const AlignmentSite& site) {
  if (!(std::abs(site.latitude) <= 89.9 * unit::deg))
    throw Error(fmt::format("alignment at latitude {:.6f} deg: expected at most 89.9 deg from the equator, where there is a north to find",
                            site.latitude / unit::deg));
  if (!(site.gravity > 0)) throw Error("alignment: expected a positive gravity");
  RestMotion rest;
  rest.earth = earth_rate_enu(site.latitude);
  rest.gravity = site.gravity;
  rest.steps.reserve(samples.size());
  rest.intervals.reserve(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Increment& sample = samples[i].increment;
    rest.steps.push_back(i > 0 ? integration::body_step(sample, samples[i - 1].increment) : integration::body_step({&sample, 1}));
    rest.intervals.push_back(samples[i].interval);
    rest.duration += samples[i].interval;
  }
  if (rest.duration < shortest_alignment || samples.size() < 20)
    throw Unsupported(fmt::format("alignment: the rest has {} samples over {:.3f} s, at least 20 over {} s are needed", samples.size(), rest.duration,
                                  shortest_alignment));
  return rest;
}

CarriedRest carried(const RestMotion& rest) {
  CarriedRest out;
  out.velocity.reserve(rest.steps.size());
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  for (const integration::BodyStep& step : rest.steps) {
    out.velocity.push_back(q * step.velocity);
    q = (q * Eigen::Quaterniond(rotation_exp(step.rotation))).normalized();
  }
  out.C_0b = q.toRotationMatrix();
  return out;
}

Densities densities(const RestMotion& rest, const AlignmentSensors& sensors) {
  return {sensors.gyro_noise ? *sensors.gyro_noise : noise_density(rest, &integration::BodyStep::rotation),
          sensors.accel_noise ? *sensors.accel_noise : noise_density(rest, &integration::BodyStep::velocity)};
}

void check_has_heading(const Matrix3d& C_nb) {
  if (C_nb.col(1).head<2>().norm() < std::sin(1 * unit::deg))
    throw Error("alignment: the IMU's forward axis (y) is within 1 deg of the vertical, where a heading is not defined; expected none to be given");
}

Eigen::RowVector3d heading_gradient(const Matrix3d& C_nb) {
  const Vector3d forward = C_nb.col(1);
  const double level = forward.head<2>().squaredNorm();
  return {forward.x() * forward.z() / level, forward.y() * forward.z() / level, -1};
}

}  // namespace imulab::alignment
