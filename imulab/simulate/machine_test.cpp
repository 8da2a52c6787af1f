// A perfect IMU on a rate table, a centrifuge and in a chamber.
#include "imulab/rig/machine.hpp"

#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace imulab {
namespace {

using unit::deg;
constexpr double latitude = 40 * deg, gravity = 9.8;

const Mount upright{{2, 1}, {0, 1}};

Step hold(double start, double end, const Mount& mount = upright) {
  Step s;
  s.start = start, s.end = end, s.mount = mount;
  return s;
}

Step spin(double start, double end, double rate, std::array<double, 3> radius, const Mount& mount = upright) {
  Step s = hold(start, end, mount);
  s.kind = StepKind::spin, s.rate = rate, s.radius = radius;
  return s;
}

Session machine(RigKind kind, std::vector<Step> steps) {
  Session s;
  s.site.latitude = latitude;
  s.rigs.resize(1);
  s.rigs[0].kind = kind;
  s.steps = std::move(steps);
  return s;
}

const Truth ideal{.model = {}, .gravity = gravity};

Recording simulated(const Session& session, const RigErrors& errors = {}, RecordingSource source = {}) {
  if (!source.rate_hz) source.rate_hz = 50;
  return simulate_recording(session, source, ideal, 1, errors);
}

/// Means over the samples whose stamps are in (start, end].
Motion mean(const Recording& r, double start, double end) {
  Motion sum;
  double count = 0;
  for (std::size_t k = 0; k < r.size(); ++k) {
    if (r.time_s(k) < start + 1e-9 || r.time_s(k) > end + 1e-9) continue;
    sum.force += Vector3d(r.accel[0][k], r.accel[1][k], r.accel[2][k]);
    sum.rate += Vector3d(r.gyro[0][k], r.gyro[1][k], r.gyro[2][k]);
    ++count;
  }
  return {.rate = sum.rate / count, .force = sum.force / count};
}

/// Every mount: a face up, another outward.
std::vector<Mount> mounts() {
  std::vector<Mount> all;
  for (int up = 0; up < 3; ++up)
    for (const int sign : {1, -1})
      for (int out = 0; out < 3; ++out)
        if (out != up) all.push_back({{up, sign}, {out, -sign}});
  return all;
}

TEST(MachineMotion, TheMeanOverWholeTurnsIsTheClosedForm) {
  const MachinePlace<double> place{gravity, earth_rate_enu(latitude)};
  const double rate_error = 1e-3;
  for (const Mount& mount : mounts())
    for (const double turns : {3.0, -11.0}) {
      const double rate = turns * 2 * std::numbers::pi / 10 / (1 + rate_error);  // whole turns of the actual machine in 10 s
      const Session session = machine(RigKind::centrifuge, {hold(0, 10, mount), spin(20, 30, rate, {6.1, 6.102, 6.097}, mount)});
      RigErrors errors{machine_error_sources(session.rigs[0], session.steps), {}};
      for (std::size_t i = 0; i < errors.sources.size(); ++i) {
        const double size = 1e-4 * (static_cast<double>(i) - 2.5);
        errors.values.push_back(errors.sources[i].kind == RigErrorKind::rate ? rate_error : size);
      }
      const Recording r = simulated(session, errors);
      for (const Step& step : session.steps) {
        const Motion seen = mean(r, step.start, step.end);
        const SteadyMotion<double> expected = steady_motion(step, errors_at(errors, mount), place);
        // The closed form leaves out the square of Earth's horizontal rate times the radius, 2e-8, and its mount rotations' fourth order.
        EXPECT_LT((seen.force - expected.force).norm(), 3e-8) << mount_name(mount) << turns;
        EXPECT_LT((seen.rate - expected.rate).norm(), 1e-12) << mount_name(mount) << turns;
      }
    }
}

TEST(MachineMotion, ThirtyGAtSixMetres) {
  const double radius = 6.104, rate = std::sqrt(30 * unit::g / radius);
  EXPECT_NEAR(rate / deg, 397.78, 0.01);  // sqrt(294.1995 / 6.104) = 6.94246 rad/s
  const Session session = machine(RigKind::centrifuge, {spin(0, 10, rate, {radius, radius, radius})});
  const Motion seen = mean(simulated(session), 0, 10);
  const double earth_up = 7.292115e-5 * std::sin(latitude);
  // -x of 30 g, and Coriolis 2 W w_ie r. What is left out is the Earth's rate squared times the radius, 3e-8. The z accelerometer measures Coriolis'
  // part of the Earth's horizontal rate, 2 W w r = 5e-3, in every turn: the mean over 11.05 turns has sin(0.05 pi) / (11 pi) of it.
  EXPECT_NEAR(seen.force.x(), -30 * unit::g - 2 * rate * earth_up * radius, 1e-7);
  EXPECT_NEAR(seen.force.y(), 0, 1e-7);
  EXPECT_NEAR(seen.force.z(), gravity, 5e-5);
  EXPECT_NEAR(seen.rate.z(), rate + earth_up, 1e-12);
}

TEST(MachineMotion, TheRateChangesSmoothlyInTheGap) {
  const double from = 3, to = -1, begin = 10, end = 20;
  const std::array<double, 3> radius{6.1, 6.2, 6.3};
  const Session session = machine(RigKind::rate_table, {spin(0, begin, from, radius), spin(end, 30, to, radius)});
  const RigMotion motion = recorded_motion(session, {});
  ASSERT_EQ(motion.pieces.size(), 3u);
  for (const double t : {begin, end})
    for (const MotionPiece& piece : motion.pieces) {
      if (t != piece.begin && t != piece.end) continue;
      EXPECT_NEAR(axis_states(piece, t)[0].rate, t == begin ? from : to, 1e-13);  // rounding of rates of 3 rad/s
      EXPECT_NEAR(axis_states(piece, t)[0].acceleration, 0, 1e-13);
    }
  // In the middle of the gap the rate is the mean, and changes by 3/2 of the mean change: Euler's force on the accelerometer across the radius.
  const Motion middle = mean(simulated(session), 14.98, 15.02);
  EXPECT_NEAR(middle.rate.z(), 1 + earth_rate_enu(latitude).z(), 1e-12);
  EXPECT_NEAR(middle.force.y(), 1.5 * (to - from) / (end - begin) * radius[1],
              2e-5);  // 6 u (1 - u) over 40 ms of 10 s: (u - 1/2)^2 is 1e-6 in the mean
}

TEST(MachineMotion, AHoldAfterASpinIsReachedAtItsAngle) {
  for (const double angle : {0.0, 170 * deg, -400 * deg}) {
    std::vector<Step> steps{spin(5, 15, 7, {}), hold(25, 30), hold(30, 31), hold(33, 34)};
    for (std::size_t k = 1; k < 3; ++k) steps[k].angles[0] = angle;
    const RigMotion motion = recorded_motion(machine(RigKind::rate_table, steps), {});
    const auto angle_at = [&](double t) {
      return std::remainder(rotation_log(body_state(motion, t).C_nb * mount_attitude(upright).transpose()).z(), 360 * deg);
    };
    EXPECT_NEAR(std::remainder(angle_at(27) - angle, 360 * deg), 0, 1e-12) << angle;
    EXPECT_NEAR(std::remainder(angle_at(30.5) - angle, 360 * deg), 0, 1e-12) << angle;
    EXPECT_NEAR(angle_at(33.5), 0, 1e-12) << angle;
    EXPECT_NEAR(angle_at(0), 0, 1e-12);
    EXPECT_EQ(body_state(motion, 27).rate_nb_b.norm(), 0);
    // Between, the angle continues: the rate in the gap integrates to the difference of the angles.
    double turned = 0;
    const int n = 20000;
    for (int k = 0; k < n; ++k) turned += 10.0 / n * body_state(motion, 15 + (k + 0.5) * 10 / n).rate_nb_b.z();
    EXPECT_NEAR(std::remainder(angle_at(15) + turned - angle, 360 * deg), 0, 1e-6)
        << angle;  // midpoint rule: third derivative of 1 rad/s^3, h^2 / 24
  }
}

TEST(MachineMotion, TheUnitIsMountedAnewAtTheEndOfTheGap) {
  const Mount side{{0, -1}, {2, 1}};
  const Recording r = simulated(machine(RigKind::rate_table, {hold(0, 1), hold(2, 3, side)}));
  EXPECT_NEAR(mean(r, 1, 2).force.z(), gravity, 1e-12);
  EXPECT_NEAR(mean(r, 2, 3).force.x(), -gravity, 1e-12);
  const double north = earth_rate_enu(latitude).y();
  EXPECT_NEAR(mean(r, 1, 2).rate.x(), north, 1e-16);  // outward points north at zero angle
  EXPECT_NEAR(mean(r, 2, 3).rate.z(), north, 1e-16);
}

TEST(MachineMotion, TheUnitsOwnLeverArmsDoNotCount) {
  const Session session = machine(RigKind::rate_table, {spin(0, 1, 5, {})});
  Truth unit = ideal;
  unit.model.lever_arm.setConstant(0.3);
  RecordingSource source;
  EXPECT_EQ(simulate_recording(session, source, unit, 1).accel, simulate_recording(session, source, ideal, 1).accel);
}

TEST(MachineMotion, WhatAMachineCannotDoIsNamed) {
  const auto message = [](RigKind kind, std::vector<Step> steps) -> std::string {
    try {
      recorded_motion(machine(kind, std::move(steps)), {});
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  const auto changed = [](Step step, const std::function<void(Step&)>& change) {
    change(step);
    return step;
  };
  using testing::HasSubstr;
  EXPECT_THAT(message(RigKind::chamber, {hold(0, 1), spin(2, 3, 1, {})}), HasSubstr("step 2 (spin at 2 s): a chamber does not turn; expected hold"));
  EXPECT_THAT(message(RigKind::centrifuge, {spin(0, 1, 1, {6, 0, 6})}), HasSubstr("expected a radius above 0"));
  EXPECT_EQ(message(RigKind::rate_table, {spin(0, 1, 1, {})}), "");
  EXPECT_THAT(message(RigKind::rate_table, {changed(spin(0, 1, 1, {}), [](Step& s) { s.mount.reset(); })}),
              HasSubstr("expected the body axes that point up and outward"));
  EXPECT_THAT(message(RigKind::rate_table, {spin(0, 1, 0, {})}), HasSubstr("the rate is 0"));
  EXPECT_THAT(message(RigKind::rate_table, {changed(hold(0, 1), [](Step& s) { s.kind = StepKind::rotate; })}), HasSubstr("expected hold or spin"));
  EXPECT_THAT(message(RigKind::rate_table, {changed(hold(0, 1), [](Step& s) { s.angles[2] = 1; })}),
              HasSubstr("the machine has one axis, the outer"));
  EXPECT_THAT(message(RigKind::rate_table, {spin(0, 1, 1, {}), spin(1, 2, 2, {})}),
              HasSubstr("its rate differs from that of the previous step, without time to reach it"));
  EXPECT_THAT(message(RigKind::rate_table, {hold(0, 1), hold(1, 2, {{0, 1}, {1, 1}})}), HasSubstr("its mount differs"));
  EXPECT_THAT(message(RigKind::rate_table, {hold(0, 1), changed(hold(1, 2), [](Step& s) { s.angles[0] = 1; })}), HasSubstr("its angle differs"));
  EXPECT_THAT(message(RigKind::rate_table, {hold(0, 2), hold(1, 3)}), HasSubstr("expected a start from 2 s on"));
  EXPECT_THAT(message(RigKind::rate_table, {}), HasSubstr("no steps; expected at least one"));
}

TEST(Simulate, TheStepsAloneAreTheSameSamples) {
  Session session = machine(RigKind::centrifuge, {hold(0.505, 3), spin(13.013, 45, 7, {6, 6, 6}), spin(45, 46, 7, {6, 6, 6}), hold(60, 61.999)});
  session.steps[0].temperature = 20, session.steps[3].temperature = 60;
  RecordingSource source;
  source.accel_temperature.emplace().columns = {"x", "y", "z"};
  source.accel_temperature->noise = 0.01;
  Truth truth = ideal;
  truth.gyro_noise = {.Q = 1e-4, .N = 1e-3, .B = 1e-3, .K = 1e-4};
  truth.accel_noise.N = 0.01, truth.accel_noise.range = 294;
  const RigErrors errors = {};
  const Recording all = simulate_recording(session, source, truth, 3, errors);
  source.extent = Extent::steps;
  const Recording steps = simulate_recording(session, source, truth, 3, errors);
  // Intervals inside (0.505, 3), (13.013, 46) and (60, 61.999) at 100 Hz.
  ASSERT_EQ(steps.size(), 249u + 3298u + 199u);
  EXPECT_EQ(steps.gaps, (std::vector<std::size_t>{249, 249 + 3298}));
  EXPECT_EQ(steps.time_ns[0], 520'000'000);
  std::size_t k = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (k == steps.size() || all.time_ns[i] != steps.time_ns[k]) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(all.gyro[a][i], steps.gyro[a][k]);
      EXPECT_EQ(all.accel[a][i], steps.accel[a][k]);
      EXPECT_EQ(all.accel_temperature[a][i], steps.accel_temperature[a][k]);
    }
    ++k;
  }
  EXPECT_EQ(k, steps.size());
}

}  // namespace
}  // namespace imulab
