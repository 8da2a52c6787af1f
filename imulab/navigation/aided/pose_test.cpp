// Poses: their law, and a calibration of the frame, the tracked body and the Earth's rate from readings in closed form.
#include "imulab/navigation/aided/pose.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/aided/start.hpp"
#include "imulab/navigation/motion/trajectory.hpp"
#include "imulab/units.hpp"

#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

namespace imulab::aided {
namespace {

using ::testing::HasSubstr;

constexpr double latitude = 48 * unit::deg, longitude = 0.2, height = 500;

/// A hand that turns a unit about all axes and moves it by some decimeters.
motion::Kinematics hand_at(double t) {
  const auto attitude = [](double at) {
    return Matrix3d(rotation_about(Vector3d::UnitZ(), std::sin(1.7 * at + 2)) * rotation_about(Vector3d::UnitY(), 0.9 * std::sin(2.7 * at + 1)) *
                    rotation_about(Vector3d::UnitX(), 1.2 * std::sin(2 * at)));
  };
  const Vector3d size(0.2, 0.15, 0.1), frequency(2.1, 3.1, 2.6), phase = frequency * t;
  constexpr double h = 1e-4;
  motion::Kinematics k;
  const LocalEarth earth = local_earth(latitude, height);
  const Vector3d way = size.array() * phase.array().sin();
  k.latitude = latitude + way.y() / earth.meridian_radius;
  k.longitude = longitude + way.x() / (earth.transverse_radius * earth.cos_latitude);
  k.height = height + way.z();
  k.velocity = size.array() * frequency.array() * phase.array().cos();
  k.acceleration = -(way.array() * frequency.array().square());
  k.C_nb = attitude(t);
  k.rate_nb_b = rotation_log(attitude(t - h).transpose() * attitude(t + h)) / (2 * h);
  return k;
}

/// Markers on the unit, in a frame that is tilted and unlike the IMU's axes.
struct Tracked {
  motion::Trajectory flight{.duration = 40, .breaks = {}, .at = hand_at};
  motion::NominalMotion motion = motion::nominal_motion(flight, 0.01);
  Vector3d lever{0.2, -0.1, 0.3};
  Matrix3d body = rotation_exp({1, -0.5, 2}), frame = rotation_exp({0.4, 0.3, 0});  // markers to IMU; level axes to frame, the shortest way
  Recording readings = ideal_readings(motion);
  Session session;

  Tracked() { session.site = {.latitude = latitude, .longitude = longitude, .height = height}; }

  Aid markers(AidKind kind = AidKind::pose, double late = 0) const {
    Aid aid{.kind = kind, .scale = TimeScale::recording};
    const NavigationState first = at_place({latitude, longitude, height});
    for (double t = 0.05; t < flight.duration - 0.2; t += 0.02) {
      const motion::Kinematics k = flight.at(t);
      aid.record.time.push_back(std::llround(1e9 * (t + late)));
      const Vector3d here = minus(motion::navigation_state(k), first).segment<3>(At::position);
      if (kind != AidKind::attitude) aid.record.place.emplace_back(frame * (here + k.C_nb * lever));
      aid.record.attitude.push_back(Eigen::Quaterniond(frame * k.C_nb * body).coeffs());
    }
    return aid;
  }
  Problem problem(const Aid& aid) const { return make_problem(readings, sensor_priors({}, {}), {aid}, session); }
};

FullState changed(const FullState& state, Eigen::Index k, double by) {
  Eigen::VectorXd error = Eigen::VectorXd::Zero(state.x.size());
  error[k] = by;
  return plus(state, error);
}

class PoseLaw : public ::testing::TestWithParam<AidKind> {};

TEST_P(PoseLaw, HasTheDerivativesOfItsResiduals) {
  const Tracked t;
  const Problem p = t.problem(t.markers(GetParam()));
  const Channel& c = p.channels[0];
  Eigen::VectorXd x = prior_of(p).mean;
  x.segment<3>(c.body) << 0.01, -0.006, 0.004;
  x.segment<2>(c.tilt) << 0.008, 0.004;
  if (c.lever >= 0) x.segment<3>(c.lever) = t.lever;
  if (c.slow_turn >= 0) x.segment<3>(c.slow_turn) << 0.01, 0.02, -0.01;
  constexpr std::size_t sample = 999;  // 3 ms before the row 497
  const FullState state{t.motion.states[sample], x};
  const Observation o{.stamp = t.motion.time[sample] + 0.003, .channel = 0, .row = 497};
  const auto at = [&](const FullState& s) { return observe(p, o, instant_at(p, sample, s)); };
  const Eigen::MatrixXd derivative = at(state).derivative;
  for (Eigen::Index k = 0; k < p.size; ++k) {
    constexpr double h = 1e-5;
    if (k >= p.accel_offset && k < p.earth_rate && k != p.gyro_matrix && k != p.gyro_delay)
      continue;  // their effect over 3 ms is that of the rate, tested by the first
    const Eigen::VectorXd difference = (at(changed(state, k, -h)).residual - at(changed(state, k, h)).residual) / (2 * h);
    EXPECT_LT((difference - derivative.col(k)).norm(), 0.02 * difference.norm() + 2e-3) << k << "\n" << difference << "\n" << derivative.col(k);
  }
}
INSTANTIATE_TEST_SUITE_P(Kinds, PoseLaw, ::testing::Values(AidKind::pose, AidKind::attitude, AidKind::odometry));

TEST(Poses, AreAlignedFromTurnsAndGravity) {
  const Tracked t;
  for (const double late : {0., 0.3}) {
    const Problem p = t.problem(t.markers(AidKind::pose, late));
    const Channel& c = p.channels[0];
    EXPECT_NEAR(*c.aid.delay, late, 2e-3);
    EXPECT_LT(rotation_log(c.body_start.transpose() * t.body).norm(), 0.01) << "from the markers to the IMU";
    EXPECT_LT((c.frame_start * t.frame * Vector3d::UnitZ() - Vector3d::UnitZ()).norm(), 0.03) << "up";
    const FoundStart start = find_start(p, t.session);
    EXPECT_EQ(start.candidates, 1);
    const Vector3d up = start.start.mean.motion.q_nb.conjugate() * Vector3d::UnitZ(),
                   true_up = t.motion.states[5].q_nb.conjugate() * Vector3d::UnitZ();
    EXPECT_LT((up - true_up).norm(), 0.05);
  }
}

TEST(Poses, TheirFrameDoesNotPointNorth) {
  const Tracked t;
  const Problem p = t.problem(t.markers());
  ASSERT_GE(p.earth_rate, 0);
  const Prior prior = prior_of(p);
  EXPECT_NEAR(prior.mean[p.earth_rate + 2], earth_rate_enu(latitude).z(), 1e-12);
  EXPECT_NEAR(prior.sigma[p.earth_rate], earth_rate_enu(latitude).y() / std::sqrt(2.), 1e-12);
  // A change of the Earth's rate turns the axes.
  FullState state{t.motion.states[0], prior.mean};
  const auto reached = [&](double by) { return integrate(p, 0, 500, changed(state, p.earth_rate, by), false).end; };
  const Eigen::Matrix<double, 9, 1> difference = minus(reached(1e-4), reached(-1e-4)) / 2e-4,
                                    column = integrate(p, 0, 500, state, true).transition.motion.col(p.earth_rate);
  EXPECT_LT((difference - column).norm(), 2e-3 * column.norm());
  Aid north = t.markers();
  north.frame = AidFrame::north;
  EXPECT_LT(t.problem(north).earth_rate, 0);
}

TEST(GyroDelay, MovesTheMotionAsLaterReadingsDo) {
  const Tracked t;
  const Problem p = t.problem(t.markers());
  const FullState state{t.motion.states[0], prior_of(p).mean};
  const auto reached = [&](double by) { return integrate(p, 0, 500, changed(state, p.gyro_delay, by), false).end; };
  constexpr double h = 1e-4;
  const Eigen::Matrix<double, 9, 1> difference = (minus(reached(h), reached(0)) / h),
                                    column = integrate(p, 0, 500, state, true).transition.motion.col(p.gyro_delay);
  ASSERT_GT(difference.head<3>().norm(), 0.5) << "the rate has changed";
  EXPECT_LT((difference - column).norm(), 0.01 * column.norm());  // a sample turns by 0.02 rad, which the column takes as small
}

// Markers see the attitude of the gyros and the places of the accelerometers.
TEST(GyroDelay, IsFoundByPoses) {
  Tracked t;
  constexpr std::size_t samples = 3;
  for (auto& axis : t.readings.gyro) axis.insert(axis.begin(), samples, axis.front()), axis.resize(t.readings.size());
  const AidedNavigation n = navigate_under(sensor_priors({}, {}), t.session, t.readings, {t.markers()}, {});
  const auto delay = std::ranges::find(n.constants, "imu.gyro_delay", &AidedConstant::name);
  ASSERT_NE(delay, n.constants.end());
  EXPECT_NEAR(delay->value, 0.03, 4 * delay->sigma);
  EXPECT_LT(delay->sigma, 1e-3);
  EXPECT_TRUE(n.findings.has(Code::triads_delayed));
}

// Angles are the unit's own, whatever its stamps: a rate over their intervals would follow the jitter.
TEST(GyroDelay, ShiftsAnglesThatJitteredStampsLeaveAsTheyAre) {
  Tracked t;
  t.readings.gyro_increment = t.readings.accel_increment = true;  // means over the nominal interval
  const Recording even = t.readings;
  for (std::size_t i = 1; i < t.readings.size(); i += 2) t.readings.time_ns[i] += 4'000'000;
  const Problem p = t.problem(t.markers());
  Eigen::VectorXd x = prior_of(p).mean;
  x[p.gyro_delay] = 0.025;  // two and a half samples
  for (const std::size_t i : {500u, 501u}) {
    const auto angle = [&](std::size_t at) { return Vector3d(0.01 * Vector3d(even.gyro[0][at], even.gyro[1][at], even.gyro[2][at])); };
    const DelayedSample later = delayed_sample(p, i, x);
    EXPECT_LT((later.sample.increment.angle - (angle(i + 2) + angle(i + 3)) / 2).norm(), 1e-12);
    EXPECT_LT((later.angle_slope - (angle(i + 3) - angle(i + 2)) / 0.01).norm(), 1e-9);
  }
}

TEST(GyroDelay, IsNotShownByNoiseAtRest) {
  const Tracked t;
  const Problem p = t.problem(t.markers());
  const Channel rest{.name = "zero_velocity", .aid = {.kind = AidKind::zero_velocity}};
  const Instant now = instant_at(p, 999, {t.motion.states[999], prior_of(p).mean});
  ASSERT_GT(now.turning.norm(), 1);
  EXPECT_TRUE(aid_law(AidKind::zero_velocity).observe(p, rest, {.stamp = now.time}, now).derivative.col(p.gyro_delay).isZero(0));
}

std::string problem_of(const Tracked& t, const Aid& aid) {
  try {
    t.problem(aid);
  } catch (const std::exception& e) {
    return e.what();
  }
  return "none";
}

TEST(Poses, ThatDoNotFitAreNamed) {
  const Tracked t;
  Aid inverse = t.markers(), mirrored = inverse, millimetres = inverse, other = inverse;
  for (Eigen::Vector4d& q : inverse.record.attitude) q.head<3>() = -q.head<3>();
  EXPECT_THAT(problem_of(t, inverse), HasSubstr("from the frame to the tracked body"));
  for (std::size_t i = 0; i < mirrored.record.time.size(); ++i)
    mirrored.record.place[i].y() *= -1, mirrored.record.attitude[i].x() *= -1, mirrored.record.attitude[i].z() *= -1;
  EXPECT_THAT(problem_of(t, mirrored), HasSubstr("right-handed"));
  for (Vector3d& place : millimetres.record.place) place *= 1000;
  EXPECT_THAT(problem_of(t, millimetres), HasSubstr("one unit of its positions is 0.001 m"));
  Aid still = t.markers();
  for (Eigen::Vector4d& q : still.record.attitude) q = still.record.attitude.front();
  EXPECT_NE(problem_of(t, still), "none");
}

}  // namespace
}  // namespace imulab::aided
