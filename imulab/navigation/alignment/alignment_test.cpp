#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/integration/local_earth.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/units.hpp"

#include <Eigen/Dense>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace imulab {
namespace {

using namespace motion;

using std::numbers::pi;
using ::testing::HasSubstr;

constexpr double latitude = 40 * unit::deg, height = 100;
const double gravity = -local_earth(latitude, height).gravity.z();
const EulerAngles pose{0.1, -0.2, -0.7};
constexpr double gyro_noise = 0.005 * unit::deg_per_sqrt_h, accel_noise = 5e-5;

struct Sway {
  double angle = 0, way = 0;  // amplitudes [rad, m]
  double phase = 0;
};

/// Returns a rest with sway about pose and place, with periods of a ship and of engine vibration.
Trajectory swaying(const Sway& sway, double duration) {
  const auto angles = [sway](double t) {
    return EulerAngles{pose.roll + sway.angle * std::sin(2 * pi * t / 8.3 + sway.phase), pose.pitch + sway.angle / 2 * std::sin(2 * pi * t / 6.1),
                       pose.heading + sway.angle / 3 * std::sin(2 * pi * t / 11.7 + 2)};
  };
  Trajectory out;
  out.duration = duration;
  out.at = [sway, angles](double t) {
    const Vector3d amplitude = sway.way * Vector3d(1, 0.6, 0.003), w(2 * pi / 8.3, 2 * pi / 7.1, 2 * pi * 3);
    Vector3d s, v, a;
    for (int i = 0; i < 3; ++i) {
      const double x = w[i] * t + (i + 1) * sway.phase;
      s[i] = amplitude[i] * std::sin(x);
      v[i] = amplitude[i] * w[i] * std::cos(x);
      a[i] = -w[i] * w[i] * s[i];
    }
    const LocalEarth earth = local_earth(latitude, height);
    Kinematics k;
    k.latitude = latitude + s.y() / earth.meridian_radius;
    k.longitude = s.x() / (earth.transverse_radius * earth.cos_latitude);
    k.height = height + s.z();
    k.velocity = v;
    k.acceleration = a;
    const EulerAngles now = angles(t);
    k.C_nb = attitude_matrix(now);
    const double e = 1e-4;  // central differences: their error, e^2/6 of the third derivative, is 1e-10 rad/s with zero mean
    const EulerAngles after = angles(t + e), before = angles(t - e);
    k.rate_nb_b = attitude_rate(
        now, {(after.roll - before.roll) / (2 * e), (after.pitch - before.pitch) / (2 * e), (after.heading - before.heading) / (2 * e)});
    return k;
  };
  return out;
}

struct DrawnRest {
  std::vector<TimedIncrement> samples;
  Matrix3d C_nb;      // at the end
  Vector3d velocity;  // also at the end
};

/// Simulates a rest with white noise and constant errors of these sigmas.
DrawnRest drawn_rest(const Sway& sway, double duration, double interval, double gyro_bias, double accel_bias, std::uint64_t seed) {
  const Trajectory motion = swaying(sway, duration);
  const RandomStream draws(seed, "rest");
  std::uint64_t next = 0;
  const auto normals = [&] {
    const double x = draws.normal(next++), y = draws.normal(next++), z = draws.normal(next++);
    return Vector3d(x, y, z);
  };
  const Vector3d gyro = gyro_bias * normals(), accel = accel_bias * normals();
  DrawnRest out;
  std::vector<Increment> ideal;
  if (sway.angle > 0 || sway.way > 0) {
    ideal = ideal_increments(motion, interval);
  } else {
    const BodyMotion still = body_motion(motion.at(0));
    ideal.assign(static_cast<std::size_t>(std::lround(duration / interval)), {interval * still.rate_ib_b, interval * still.force_b});
  }
  for (Increment sample : ideal) {
    sample.angle += interval * gyro + gyro_noise * std::sqrt(interval) * normals();
    sample.velocity += interval * accel + accel_noise * std::sqrt(interval) * normals();
    out.samples.push_back({sample, interval});
  }
  out.C_nb = navigation_state(motion.at(duration)).q_nb.toRotationMatrix();
  out.velocity = motion.at(duration).velocity;
  return out;
}

AlignmentSensors declared(double gyro_bias = 0, double accel_bias = 0) {
  return {gyro_bias * gyro_bias * Matrix3d::Identity(), accel_bias * accel_bias * Matrix3d::Identity(), gyro_noise, accel_noise};
}

/// Returns phi in C_nb = (I - [phi x]) C_true.
Vector3d error_of(const Alignment& a, const Matrix3d& truth) { return -rotation_log(a.C_nb * truth.transpose()); }

double normalized(const Alignment& a, const Matrix3d& truth) {
  const Vector3d e = error_of(a, truth);
  return e.dot(a.covariance.llt().solve(e));
}

/// Expects a sum of squares of `count` normal numbers within its two-sided interval of p = 2e-6.
void expect_chi_square(double sum, int count) {
  EXPECT_GT(sum, chi_square_quantile(1e-6, count));
  EXPECT_LT(sum, chi_square_quantile(1 - 1e-6, count));
}

constexpr AlignmentSite site() { return {latitude, 9.8017}; }

TEST(Alignment, OfPerfectSensorsIsTheAttitude) {
  const Trajectory still = swaying({}, 100);
  const BodyMotion motion = body_motion(still.at(0));
  const std::vector<TimedIncrement> rest(1000, {{0.1 * motion.rate_ib_b, 0.1 * motion.force_b}, 0.1});
  const Matrix3d truth = attitude_matrix(pose);
  // Normal gravity at 100 m has a north component of about 1e-7 g, which the alignment treats as level.
  EXPECT_LT(error_of(coarse_alignment(rest, {latitude, gravity}, declared()), truth).norm(), 3e-7);
  EXPECT_LT(error_of(fine_alignment(rest, {latitude, gravity}, declared()).attitude, truth).norm(), 3e-7);
}

TEST(Alignment, ConstantErrorsTiltAsTheClosedFormsSay) {
  // The expectation phi_N = df_E / g, phi_E = -df_N / g, phi_U = phi_N tan L - dw_E / (w_ie cos L) is independent of the code's covariance.
  const BodyMotion motion = body_motion(swaying({}, 1).at(0));
  const Matrix3d C = attitude_matrix(pose);
  const Vector3d df(1e-4, -2e-4, 3e-4), dw(2e-9, 0, 0);  // east, north, up
  const Increment sample{0.1 * (motion.rate_ib_b + C.transpose() * dw), 0.1 * (motion.force_b + C.transpose() * df)};
  const std::vector<TimedIncrement> rest(600, {sample, 0.1});
  const double north = df.x() / gravity, up = north * std::tan(latitude) - dw.x() / (earth_rate * std::cos(latitude));
  const Vector3d expected(-df.y() / gravity, north, up);
  for (const Alignment& a : {coarse_alignment(rest, {latitude, gravity}, declared()), fine_alignment(rest, {latitude, gravity}, declared()).attitude})
    EXPECT_LT((error_of(a, C) - expected).norm(), 4e-7) << error_of(a, C).transpose();  // that north component, and squares of phi
}

TEST(Alignment, ErrorsAreAsLargeAsTheCovarianceSays) {
  const double gyro_bias = 0.004 * unit::deg_per_h, accel_bias = 10 * unit::ug;
  double coarse = 0, fine = 0, innovations = 0, coarse_heading = 0, fine_heading = 0, coarse_level = 0, fine_level = 0;
  const int rests = 150;
  std::size_t updates = 0;
  for (int k = 0; k < rests; ++k) {
    const DrawnRest rest = drawn_rest({}, 200, 0.2, gyro_bias, accel_bias, 1 + static_cast<std::uint64_t>(k));
    const Alignment a = coarse_alignment(rest.samples, site(), declared(gyro_bias, accel_bias));
    const FineAlignment b = fine_alignment(rest.samples, site(), declared(gyro_bias, accel_bias));
    coarse += normalized(a, rest.C_nb);
    fine += normalized(b.attitude, rest.C_nb);
    innovations += b.innovation_square;
    updates = b.updates;
    coarse_heading = a.covariance(2, 2);
    fine_heading = b.attitude.covariance(2, 2);
    coarse_level = a.covariance(0, 0);
    fine_level = b.attitude.covariance(0, 0);
  }
  expect_chi_square(coarse, 3 * rests);
  expect_chi_square(fine, 3 * rests);
  // These are mean squares of about 2 x updates x rests normal numbers; five sigma, plus 1/16 of a percent for noise in steps of 0.2 s.
  EXPECT_NEAR(innovations / rests, 1, 5 / std::sqrt(static_cast<double>(updates) * rests) + 0.01);
  // The mean of the east gyro limits the heading; the difference of two halves of an angle has 4/3 of that variance.
  const double north = earth_rate * std::cos(latitude), mean = (gyro_noise * gyro_noise / 200 + gyro_bias * gyro_bias) / (north * north);
  const double of_accelerometers = 16 * accel_noise * accel_noise / (std::pow(200, 3) * 9.8 * 9.8 * north * north);
  const double tilt = std::pow(accel_bias / 9.8 * std::tan(latitude), 2);
  EXPECT_GT(fine_heading, 0.99 * mean);
  EXPECT_LT(fine_heading, 1.1 * mean);
  EXPECT_NEAR(coarse_heading, mean + gyro_noise * gyro_noise / 600 / (north * north) + of_accelerometers + tilt, 0.03 * mean);
  EXPECT_GT(coarse_level - accel_bias * accel_bias / 96, 3 * (fine_level - accel_bias * accel_bias / 96));  // the mean level is half a rest old
}

TEST(Alignment, OfASwayingBaseHasNoBiasAndKnowsItsSize) {
  Vector3d sum = Vector3d::Zero(), variance = Vector3d::Zero();
  double fine = 0;
  const int rests = 12;
  for (int k = 0; k < rests; ++k) {
    const DrawnRest rest = drawn_rest({0.05, 0.3, 0.7 * k}, 150, 0.05, 0, 0, 100 + static_cast<std::uint64_t>(k));
    const FineAlignment a = fine_alignment(rest.samples, site(), declared());
    sum += error_of(a.attitude, rest.C_nb);
    variance += a.attitude.covariance.diagonal();
    fine += normalized(a.attitude, rest.C_nb);
    EXPECT_LT((a.base_velocity - rest.velocity.head<2>()).norm(), 0.01);  // for amplitudes of 0.23 and 0.16 m/s
    EXPECT_GT(a.base_displacement, 0.05);                                 // for amplitudes of 0.3 and 0.18 m
    EXPECT_LT(a.base_displacement, 0.5);
    EXPECT_LT(std::sqrt(a.attitude.covariance(2, 2)), 0.4 * unit::deg);  // although the body swings by 3 deg
  }
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(sum[i]), 5 * std::sqrt(variance[i])) << i;
  // Sway is not white noise: the filter's assumption may make the stated sigma somewhat too large, but not much too small.
  EXPECT_LT(fine, 1.5 * chi_square_quantile(1 - 1e-6, 3 * rests));
  EXPECT_GT(fine, 0.3 * chi_square_quantile(1e-6, 3 * rests));
}

TEST(Alignment, AGivenHeadingLeavesTheLevels) {
  const double poor = 1e-4;  // rad/s, 20 deg/h: the Earth's rate is not resolved
  const DrawnRest rest = drawn_rest({}, 60, 0.1, poor, 1e-3, 7);
  const GivenHeading given{pose.heading, 2 * unit::deg};
  const FineAlignment blind = fine_alignment(rest.samples, site(), declared(poor, 1e-3));
  EXPECT_GT(std::sqrt(blind.attitude.covariance(2, 2)), 10 * unit::deg);
  for (const Alignment& a : {coarse_alignment(rest.samples, site(), declared(poor, 1e-3), given),
                             fine_alignment(rest.samples, site(), declared(poor, 1e-3), given).attitude}) {
    EXPECT_NEAR(std::sqrt(a.covariance(2, 2)) / unit::deg, 2, 0.05);
    EXPECT_NEAR(euler_angles(a.C_nb).heading, pose.heading, 0.2 * unit::deg);  // the gyros contribute a little
    EXPECT_LT(std::abs(euler_angles(a.C_nb).roll - pose.roll), 5 * std::sqrt(a.covariance(0, 0)));
    EXPECT_LT(std::sqrt(a.covariance(0, 0)), 8e-3);
  }
  const Alignment exact = fine_alignment(rest.samples, site(), declared(poor, 1e-3), GivenHeading{pose.heading, 0}).attitude;
  EXPECT_NEAR(euler_angles(exact.C_nb).heading, pose.heading, 1e-6);
}

TEST(Alignment, EstimatesTheNoiseThatIsNotDeclared) {
  const DrawnRest rest = drawn_rest({}, 200, 0.2, 0, 0, 11);
  const FineAlignment a = fine_alignment(rest.samples, site(), {});
  // 54 correlated second differences: their mean square scatters by 26 %; five sigma of its root.
  EXPECT_NEAR(a.gyro_noise / gyro_noise, 1, 0.65);
  EXPECT_NEAR(a.accel_noise / accel_noise, 1, 0.65);
}

TEST(Alignment, RefusesWhatCannotBeAligned) {
  const auto message = [](const std::function<void()>& align) -> std::string {
    try {
      align();
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  };
  const std::vector<TimedIncrement> rest(200, {{{0, 0, 0}, {0, 0, 0.98}}, 0.1}), brief(50, rest[0]);
  EXPECT_THAT(message([&] { coarse_alignment(brief, site(), {}); }), HasSubstr("50 samples over 5.000 s, at least 20 over 10 s"));
  EXPECT_THROW(coarse_alignment(brief, site(), {}), Unsupported);
  EXPECT_THAT(message([&] { fine_alignment(rest, {90 * unit::deg, 9.83}, {}); }), HasSubstr("latitude 90.000000 deg"));
  for (const double pitch : {89.2, 89.9, 90., -89.9}) {  // nose up: gravity along y
    const double p = pitch * unit::deg;
    std::vector<TimedIncrement> upright(200, {{{0, 0, 0}, {0, 0.98 * std::sin(p), 0.98 * std::cos(p)}}, 0.1});
    EXPECT_THAT(message([&] { coarse_alignment(upright, site(), {}, GivenHeading{0.5, 0}); }), HasSubstr("a heading is not defined")) << pitch;
    EXPECT_THAT(message([&] { fine_alignment(upright, site(), {}, GivenHeading{0.5, 0.1}); }), HasSubstr("a heading is not defined")) << pitch;
  }
  std::vector<TimedIncrement> driven(200, rest[0]);  // 3 m/s^2 east and back with a period of 20 s, 30 m
  for (std::size_t i = 0; i < 200; ++i) driven[i].increment.velocity.x() = 0.3 * std::sin(0.031416 * static_cast<double>(i));
  AlignmentSensors declared_noise;
  declared_noise.gyro_noise = 1e-7;
  declared_noise.accel_noise = 1e-5;
  EXPECT_THAT(message([&] { fine_alignment(driven, site(), declared_noise, GivenHeading{0, 0}); }), HasSubstr("not even a base that moves by 10 m"));
  EXPECT_THAT(message([&] { fine_alignment(rest, {latitude, 1}, {}); }), HasSubstr("mean specific force at rest is 9.8 m/s^2, expected 1"));
}

}  // namespace
}  // namespace imulab
