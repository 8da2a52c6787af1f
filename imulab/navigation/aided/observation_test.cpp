#include "imulab/navigation/aided/observation.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/aided/start.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace imulab::aided {
namespace {

// The derivative of a velocity by the delay is the antenna's acceleration including its swing, which separates a delay from a forward lever arm.
TEST(Observation, TheDelaySeesTheSwingOfTheAntenna) {
  const motion::Trajectory drive = motion::flight(
      {48 * unit::deg, 0.2, 500, 10, 0}, {motion::straight(2), motion::turn(120 * unit::deg, 0.35, 1.5), motion::straight(2)}, {.banks = false});
  constexpr double interval = 0.01;
  const Recording readings = ideal_readings(motion::nominal_motion(drive, interval));
  Aid aid{.scale = TimeScale::recording, .velocity_sigma = 0.05};
  aid.record.time = {0}, aid.record.velocity = {Vector3d::Zero()};
  const Problem p = make_problem(readings, sensor_priors({}, {}), {aid}, {});
  const Vector3d lever(3, 2, 1);
  const auto velocity = [&](double t, const Vector3d& arm) {
    const motion::Kinematics k = drive.at(t);
    return Vector3d(k.velocity + k.C_nb * k.rate_nb_b.cross(arm));
  };
  double worst = 0, swing = 0;
  for (int sample = 100; sample + 100 < drive.duration / interval; sample += 10) {
    const double t = interval * sample, h = 0.02;
    FullState state{motion::navigation_state(drive.at(t)), prior_of(p).mean};
    state.x.segment<3>(p.channels[0].lever) = lever;
    const ObservedRows rows = observe(p, {.stamp = t, .channel = 0, .row = 0}, instant_at(p, static_cast<std::size_t>(sample), state));
    const auto acceleration = [&](const Vector3d& arm) { return Vector3d((velocity(t + h, arm) - velocity(t - h, arm)) / (2 * h)); };
    worst = std::max(worst, (rows.derivative.col(p.channels[0].delay) + acceleration(lever)).norm());
    swing = std::max(swing, (acceleration(lever) - acceleration(Vector3d::Zero())).norm());
  }
  EXPECT_GT(swing, 0.5);    // m/s^2
  EXPECT_LT(worst, 0.035);  // means over 0.1 s when the rate begins to change, 0.4 rad/s^3 over 0.05 s, at 3.6 m
}

/// A hovering helicopter with the antenna of its receiver at a distance of about a meter.
struct Hovering {
  motion::Trajectory flight = motion::flight(
      {48 * unit::deg, 0.2, 500, 0, 10 * unit::deg},
      {motion::rest(60, {.angle = 4 * unit::deg, .angle_frequency = 0.4, .displacement = 0.2, .displacement_frequency = 0.27})}, {.banks = false});
  motion::NominalMotion motion = motion::nominal_motion(flight, 0.02);
  Vector3d lever{0.9, 0.5, -0.8};
  Recording readings = ideal_readings(motion);

  Aid receiver() const {
    Aid aid{.scale = TimeScale::recording, .lever_arm = lever, .position_sigma = 0.01, .velocity_sigma = 0.02};
    for (double t = 0.2; t < flight.duration; t += 0.2) {
      const motion::Kinematics k = flight.at(t);
      Eigen::Matrix<double, 9, 1> arm = Eigen::Matrix<double, 9, 1>::Zero();
      arm.tail<3>() = k.C_nb * lever;
      const NavigationState antenna = plus(motion::navigation_state(k), arm);
      aid.record.time.push_back(std::llround(1e9 * t));
      aid.record.position.emplace_back(antenna.latitude, antenna.longitude, antenna.height);
      aid.record.velocity.emplace_back(k.velocity + k.C_nb * k.rate_nb_b.cross(lever));
    }
    return aid;
  }
};

// A common rotation of both triads and of the lever arm is an attitude that no aid can distinguish: information about it would be false.
TEST(Observation, TheAttitudeIsAsUncertainAsACommonRotationOfTheTriads) {
  const Hovering h;
  const Problem p = make_problem(h.readings, sensor_priors({}, {}), {h.receiver()}, {}, {.gyro_delay_sigma = 0});
  const FilterStart start = start_near(p, h.motion.states.front());
  const AboutTrajectory truth{.at = [&](std::size_t samples) { return h.motion.states[samples]; }, .x = start.mean.x, .weights = {}};
  Eigen::MatrixXd rotation = Eigen::MatrixXd::Zero(p.size, 3);  // of the states, by a rotation about each body axis
  rotation.middleRows<3>(At::attitude) = -h.motion.states.front().q_nb.toRotationMatrix();
  for (Eigen::Index j = 0; j < 3; ++j)
    for (const Eigen::Index matrix : {p.gyro_matrix, p.accel_matrix}) rotation.middleRows<3>(matrix + 3 * j) = -skew<double>(Vector3d::Unit(j));
  rotation.middleRows<3>(p.channels[0].lever) = -skew<double>(h.lever);
  Matrix3d information = Matrix3d::Zero();  // of the start alone
  for (Eigen::Index k = 0; k < p.size; ++k)
    if (!rotation.row(k).isZero(0)) information += rotation.row(k).transpose() * rotation.row(k) / std::pow(start.sigma[k], 2);
  const Matrix3d root = information.llt().matrixU();
  double least = INFINITY, most = 0;
  for (const SmoothedNode& node : smooth(p, filter(p, start, {.about = &truth})).nodes) {
    const Matrix3d C = node.state.motion.q_nb.toRotationMatrix(), P = C.transpose() * node.covariance.topLeftCorner<3, 3>() * C;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> over_bound(root * P * root.transpose());
    least = std::min(least, over_bound.eigenvalues().minCoeff()), most = std::max(most, over_bound.eigenvalues().maxCoeff());
  }
  EXPECT_GT(least, 0.99);  // the transition sums samples over 0.05 s
  EXPECT_LT(most, 4);      // the aids leave little other uncertainty
}

}  // namespace
}  // namespace imulab::aided
