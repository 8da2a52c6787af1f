#include "imulab/error.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/integration/local_earth.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab {

using integration::body_step;
using integration::BodyStep;
using integration::earth_at;

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Returns the quaternion of a rotation vector.
Quaterniond rotation_quaternion(const Vector3d& r) {
  const double x2 = r.squaredNorm() / 4;  // square of half the angle
  double c, s;                            // cosine, half the sine over half the angle
  if (x2 < 0.0025) {                      // the series have errors of 1e-16
    c = 1 - x2 * (1. / 2 - x2 * (1. / 24 - x2 * (1. / 720 - x2 * (1. / 40320))));
    s = 0.5 - x2 * (1. / 12 - x2 * (1. / 240 - x2 * (1. / 10080)));
  } else {
    const double x = std::sqrt(x2);
    c = std::cos(x);
    s = 0.5 * std::sin(x) / x;
  }
  return {c, s * r.x(), s * r.y(), s * r.z()};
}

void check(const NavigationState& start, const StrapdownOptions& options) {
  const bool finite = start.q_nb.coeffs().allFinite() && start.velocity.allFinite() && std::isfinite(start.latitude + start.longitude + start.height);
  if (!finite) throw Error("start of navigation: expected finite numbers");
  if (std::abs(start.q_nb.norm() - 1) > 1e-6) throw Error("start of navigation: expected an attitude quaternion of length one");
  if (!(options.latitude_limit > 0 && options.latitude_limit < 90 * unit::deg)) throw Error("latitude limit: expected between 0 and 90 deg");
  if (!(options.barometer_time_constant > 0)) throw Error("time constant of the barometer loop: expected a positive number of seconds");
  integration::expect_latitude(start.latitude, options.latitude_limit);
}

}  // namespace

Strapdown::Strapdown(const NavigationState& start, const StrapdownOptions& options) : state_(start), options_(options) {
  check(start, options);
  state_.q_nb.normalize();
  if (options_.vertical == VerticalChannel::fixed) state_.velocity.z() = 0;
  earth_ = earth_at(state_.latitude, state_.height, options_);
  slow_ = integration::slow_acceleration(earth_, state_.velocity);
}

LocalEarth integration::earth_at(double latitude, double height, const StrapdownOptions& options) {
  LocalEarth earth = local_earth(latitude, height);
  if (options.gravity) earth.gravity = {0, 0, -*options.gravity};
  return earth;
}

Vector3d integration::slow_acceleration(const LocalEarth& earth, const Vector3d& velocity) {
  return earth.gravity - (2 * earth.rate + earth.transport_rate(velocity)).cross(velocity);
}

LocalEarth integration::earth_ahead(const NavigationState& s, double ahead, const LocalEarth& near, const StrapdownOptions& options) {
  return earth_at(s.latitude + ahead * s.velocity.y() / near.meridian_radius, s.height + ahead * s.velocity.z(), options);
}

void integration::expect_latitude(double latitude, double limit) {
  if (std::abs(latitude) <= limit) return;
  throw Error(fmt::format("latitude {:.6f} deg: expected at most {:.6f} deg from the equator, where east-north-up axes can be followed",
                          latitude / unit::deg, limit / unit::deg));
}

void Strapdown::step(const Increment& sample, double interval, std::optional<double> barometer) {
  const BodyStep alone = body_step({&sample, 1});
  if (!options_.previous_sample || !previous_) {
    advance(alone, interval);
    lacking_ = options_.previous_sample;
  } else {
    BodyStep body = body_step(sample, *previous_);
    if (lacking_) {  // adds what the first step lacked, for a constant change of rate; the vertical channel would amplify it to millimeters
      body.rotation += body.rotation - alone.rotation;
      body.velocity += body.velocity - alone.velocity;
      lacking_ = false;
    }
    advance(body, interval);
  }
  previous_ = sample;
  if (barometer) aid(*barometer, interval);
}

void Strapdown::step(std::span<const Increment> samples, double interval, std::optional<double> barometer) {
  if (samples.size() == 1) return step(samples.front(), interval, barometer);
  advance(body_step(samples), interval);
  previous_.reset();
  if (barometer) aid(*barometer, interval);
}

void Strapdown::advance(const BodyStep& body, double interval) {
  if (!(interval > 0)) throw Error(fmt::format("navigation: a step of {} s; expected a positive duration", interval));
  earth_ = integration::earth_ahead(state_, interval / 2, earth_, options_);
  integration::advance(state_, body, interval, earth_, slow_, options_.vertical == VerticalChannel::fixed);
  integration::expect_latitude(state_.latitude, options_.latitude_limit);
}

/// All slow quantities (Earth, gravity, transport rate, Coriolis) are evaluated at the middle of the step. The middle follows from the increments and
/// the middle of the last step: the remaining velocity error is 1e-7 m/s at 100 Hz.
void integration::advance(NavigationState& s, const BodyStep& body, double interval, const LocalEarth& earth, Vector3d& slow, bool level) {
  const double half = interval / 2;
  const Eigen::Matrix3d C_nb = s.q_nb.toRotationMatrix();
  const Vector3d pushed = C_nb * body.velocity;  // in the axes of the start

  // The middle.
  Vector3d middle = s.velocity + half * slow + pushed / 2;
  if (level) middle.z() = 0;
  const Vector3d transport = earth.transport_rate(middle);
  const Vector3d turn = interval * (earth.rate + transport);  // rotation of east-north-up relative to inertial space

  // Velocity: n turns while the force acts, on average by half of its turn; a force that turns with the body weights the later part more.
  const Vector3d turned = turn.cross(pushed / 2 + (C_nb * body.rotation - 2 * turn).cross(pushed) / 12);
  slow = earth.gravity - (2 * earth.rate + transport).cross(middle);
  Vector3d end = s.velocity + pushed - turned + interval * slow;
  if (level) end.z() = 0;

  // Position uses the mean velocity; attitude C_nb <- exp(-turn) C_nb exp(rotation).
  const Vector3d path = half * (s.velocity + end);
  s.latitude += path.y() / earth.meridian_radius;
  s.longitude += path.x() / (earth.transverse_radius * earth.cos_latitude);
  s.height += path.z();
  s.velocity = end;
  s.q_nb = rotation_quaternion(-turn) * s.q_nb * rotation_quaternion(body.rotation);
  s.q_nb.coeffs() *= 1.5 - s.q_nb.squaredNorm() / 2;  // keeps unit length despite rounding
}

/// The aided channel has three equal poles at -1/T; the third state represents the accelerometer bias.
void Strapdown::aid(double barometer, double interval) {
  if (options_.vertical == VerticalChannel::held) state_.height = barometer;
  if (options_.vertical != VerticalChannel::aided) return;
  const double pole = 1 / options_.barometer_time_constant;
  const double curvature = 2 * earth_.gravity.norm() / earth_.transverse_radius;  // feedback of a free channel: h'' = 2 g/R h
  const double error = state_.height - barometer;
  barometer_integral_ += interval * pole * pole * pole * error;
  state_.velocity.z() -= interval * ((3 * pole * pole + curvature) * error + barometer_integral_);
  state_.height -= interval * 3 * pole * error;
}

Eigen::Matrix3d attitude_matrix(const EulerAngles& angles) {
  const double sr = std::sin(angles.roll), cr = std::cos(angles.roll), sp = std::sin(angles.pitch), cp = std::cos(angles.pitch);
  const double sh = std::sin(angles.heading), ch = std::cos(angles.heading);
  Eigen::Matrix3d c;                                              // Rz(-heading) Rx(pitch) Ry(roll)
  c << ch * cr + sh * sp * sr, sh * cp, ch * sr - sh * sp * cr,   //
      -sh * cr + ch * sp * sr, ch * cp, -sh * sr - ch * sp * cr,  //
      -cp * sr, sp, cp * cr;
  return c;
}

EulerAngles euler_angles(const Eigen::Matrix3d& c) {
  const double level = std::hypot(c(2, 0), c(2, 2));
  const double pitch = std::atan2(c(2, 1), level);
  if (level < 1e-12) return {0, pitch, std::atan2(-c(1, 0), c(0, 0))};
  return {std::atan2(-c(2, 0), c(2, 2)), pitch, std::atan2(c(0, 1), c(1, 1))};
}

Eigen::Vector3d attitude_rate(const EulerAngles& angles, const EulerAngles& derivative) {
  const double sr = std::sin(angles.roll), cr = std::cos(angles.roll), sp = std::sin(angles.pitch), cp = std::cos(angles.pitch);
  const double vertical = -derivative.heading * cp;  // part of the heading rate along the body's up axis before the roll
  return {derivative.pitch * cr - vertical * sr, derivative.roll - derivative.heading * sp, derivative.pitch * sr + vertical * cr};
}

}  // namespace imulab
