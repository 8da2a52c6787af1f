#include "imulab/navigation/integration/increment.hpp"

#include "imulab/error.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/integration/local_earth.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <boost/math/quadrature/gauss.hpp>
#include <gtest/gtest.h>

#include <numbers>
#include <vector>

namespace imulab {
namespace {

using namespace integration;

constexpr double frequency = 2 * std::numbers::pi * 5;

/// Returns the integral from `begin` over `length`, exact to rounding for these motions (20 points).
template <class F>
double integral(F f, double begin, double length) {
  return boost::math::quadrature::gauss<double, 20>::integrate(f, begin, begin + length);
}

/// Returns coning increments: pitch and roll of `amplitude` in quadrature at 5 Hz, heading zero.
std::vector<Increment> coning(double amplitude, double interval, double duration) {
  const auto rate = [&](double t, int axis) {
    const double s = std::sin(frequency * t), c = std::cos(frequency * t);
    return attitude_rate({amplitude * s, amplitude * c, 0}, {amplitude * frequency * c, -amplitude * frequency * s, 0})[axis];
  };
  const auto period = static_cast<std::size_t>(std::lround(2 * std::numbers::pi / frequency / interval));
  std::vector<Increment> one(period), out(static_cast<std::size_t>(std::lround(duration / interval)));
  for (std::size_t i = 0; i < period; ++i)
    for (int axis = 0; axis < 3; ++axis)
      one[i].angle[axis] = integral([&](double t) { return rate(t, axis); }, static_cast<double>(i) * interval, interval);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = one[i % period];
  return out;
}

/// Returns the heading drift [rad] of an integrated coning motion; `step` computes a rotation vector from samples i to i + n - 1.
template <class Step>
double heading_drift(double amplitude, double interval, double duration, std::size_t n, Step step) {
  const std::vector<Increment> all = coning(amplitude, interval, duration);
  Eigen::Quaterniond q(attitude_matrix({0, amplitude, 0}));
  for (std::size_t i = 0; i + n <= all.size(); i += n) {
    const Eigen::Vector3d r = step(all, i);
    q = (q * Eigen::AngleAxisd(r.norm(), r.normalized())).normalized();
  }
  return std::abs(euler_angles(q.toRotationMatrix()).heading);
}

/// Returns the drift of body_step; 0 samples mean one and the previous.
double heading_drift(double amplitude, double interval, double duration, std::size_t samples) {
  const std::size_t n = std::max<std::size_t>(samples, 1);
  return heading_drift(amplitude, interval, duration, n, [&](const std::vector<Increment>& all, std::size_t i) {
    const Increment& before = i ? all[i - 1] : all.back();  // the motion is periodic
    return (samples ? body_step(std::span(all).subspan(i, n)) : body_step(all[i], before)).rotation;
  });
}

TEST(Coning, DriftsAsTheAlgorithmsDo) {
  // One degree at 5 Hz, 100 Hz, 600 s; 3 % because the figures have three digits.
  EXPECT_NEAR(heading_drift(1 * unit::deg, 0.01, 600, 0) / unit::arcsec, 190, 0.03 * 190);
  EXPECT_NEAR(heading_drift(1 * unit::deg, 0.01, 600, 3) / unit::arcsec, 4.03, 0.03 * 4.03);
  // With four samples, third-order products are as large as the error of the algorithm. The published algorithm (Ignagni 1996), with the whole weight
  // of a lag on the last sample, has an error of 0.54 here; weights distributed over the step give less.
  const double published = heading_drift(1 * unit::deg, 0.01, 600, 4, [](const std::vector<Increment>& s, std::size_t i) -> Eigen::Vector3d {
    const Eigen::Vector3d &a = s[i].angle, &b = s[i + 1].angle, &c = s[i + 2].angle, &d = s[i + 3].angle;
    return a + b + c + d + (54. / 105 * a + 92. / 105 * b + 214. / 105 * c).cross(d);
  });
  EXPECT_NEAR(published / unit::arcsec, 0.54, 0.03 * 0.54 + 0.005);  // the figure has two digits
  EXPECT_LT(heading_drift(1 * unit::deg, 0.01, 600, 4), published);
}

/// Returns the velocity error per second if the body turns about y as A sin and is pushed along x as B sin (sculling).
double sculling_error(double amplitude, double interval, std::size_t samples) {
  const auto angle = [&](double t) { return amplitude * std::sin(frequency * t); };
  const auto force = [&](double t) { return std::sin(frequency * t); };
  const std::size_t n = std::max<std::size_t>(samples, 1), count = static_cast<std::size_t>(std::lround(6 / interval));
  const auto sample = [&](double begin) {
    Increment s;
    s.angle.y() = angle(begin + interval) - angle(begin);
    s.velocity.x() = integral(force, begin, interval);
    return s;
  };
  double sum = 0;
  for (std::size_t i = 0; i + n <= count; i += n) {
    const double begin = static_cast<double>(i) * interval;
    std::vector<Increment> step;
    for (std::size_t k = 0; k < n; ++k) step.push_back(sample(begin + static_cast<double>(k) * interval));
    const Eigen::Vector3d v = (samples ? body_step(step) : body_step(step[0], sample(begin - interval))).velocity;
    sum += (Eigen::AngleAxisd(angle(begin), Eigen::Vector3d::UnitY()) * v).z();
  }
  const double truth = 6 * 5 * integral([&](double t) { return -std::sin(angle(t)) * force(t); }, 0, 0.2);  // thirty periods
  return std::abs(sum - truth) / 6;
}

TEST(ConingAndSculling, FallWithTheOrderOfTheAlgorithm) {
  // For N samples, a step of length T has an error per second of order T^(2N), one sample and the previous T^4, one alone T^2. At 0.1 deg,
  // third-order products are below that. 0.35 is the effect of the next order at these rates (w T = 0.3 to 0.6 a sample).
  const double a = 0.1 * unit::deg;
  const auto order = [](double coarse, double fine) { return std::log2(coarse / fine); };
  const std::vector<std::pair<std::size_t, double>> algorithms{{0, 4}, {1, 2}, {2, 4}, {3, 6}};
  for (const auto& [samples, expected] : algorithms) {
    EXPECT_NEAR(order(heading_drift(a, 0.02, 60, samples), heading_drift(a, 0.01, 60, samples)), expected, 0.35) << samples;
    EXPECT_NEAR(order(sculling_error(a, 0.02, samples), sculling_error(a, 0.01, samples)), expected, 0.35) << samples;
  }
  EXPECT_NEAR(order(heading_drift(a, 0.02, 60, 4), heading_drift(a, 0.01, 60, 4)), 8, 0.35);
}

TEST(BodyStep, ASteadyTurnUnderASteadyForceIsExact) {
  const Eigen::Vector3d rate(0.3, -0.5, 0.9), force(1, 2, 9);
  for (double duration : {1e-4, 0.05, 2.}) {  // both branches of the closed form
    const Increment whole{rate * duration, force * duration};
    Eigen::Vector3d velocity;
    for (int axis = 0; axis < 3; ++axis)
      velocity[axis] = integral([&](double t) { return (Eigen::AngleAxisd(rate.norm() * t, rate.normalized()) * force)[axis]; }, 0, duration);
    for (std::size_t n = 1; n <= 5; ++n) {
      const double part = 1. / static_cast<double>(n);
      const BodyStep step = body_step(std::vector<Increment>(n, {whole.angle * part, whole.velocity * part}));
      EXPECT_LT((step.velocity - velocity).norm(), 1e-14 * velocity.norm() * 10) << n;  // rounding
      EXPECT_LT((step.rotation - whole.angle).norm(), 1e-15) << n;
    }
  }
}

TEST(BodyStep, TakesOneToFiveSamples) {
  EXPECT_THROW(body_step(std::span<const Increment>{}), Error);
  EXPECT_THROW(body_step(std::vector<Increment>(6)), Error);
}

}  // namespace
}  // namespace imulab
