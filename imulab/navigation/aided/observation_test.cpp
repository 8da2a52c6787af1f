#include "imulab/navigation/aided/observation.hpp"

#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab::aided {
namespace {

// A velocity's derivative by the delay is the antenna's acceleration with that of its swing, which tells a delay from a lever arm forward.
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
  EXPECT_LT(worst, 0.035);  // means over a tenth of a second where the rate begins to change, 0.4 rad/s^3 over 0.05 s, at 3.6 m
}

}  // namespace
}  // namespace imulab::aided
