#include "imulab/model/effects.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/effect_setting.hpp"
#include <cmath>
#include <numbers>
#include <set>
#include <string>

namespace imulab {
namespace {

constexpr double gravity = 9.81;

/// Returns the mean of a function over the directions of gravity, evenly in height and azimuth.
template <class Function>
OutputChange mean_over_attitudes(const Function& of) {
  OutputChange sum;
  constexpr int heights = 200, around = 160;
  for (int i = 0; i < heights; ++i)
    for (int k = 0; k < around; ++k) {
      const double z = -1 + (2.0 * i + 1) / heights, angle = 2 * std::numbers::pi * (k + 0.37) / around, r = std::sqrt(1 - z * z);
      const OutputChange change = of(Vector3d(gravity * Vector3d(r * std::cos(angle), r * std::sin(angle), z)));
      sum.force += change.force / (heights * around), sum.rate += change.rate / (heights * around);
    }
  return sum;
}

// An offset is the mean over attitudes at 1 g: no effect of the force alone may contribute to it.
TEST(Effects, OfTheForceHaveNoMeanOverAttitudes) {
  for (const Effect& effect : effects()) {
    if (effect.name.starts_with("mount.")) continue;  // a rotation does not shift an offset
    for (int k = 0; k < effect.columns(everything); ++k) {
      if (effect.name.ends_with("turn_on") || effect.name.ends_with(".drift")) continue;  // effects of time
      const auto of = [&](const Vector3d& force) { return effect.phi({.force = force, .gravity = gravity, .full_force = gravity}, k); };
      const OutputChange mean = mean_over_attitudes(of), at_rest = of(Vector3d::Zero());
      const double size = std::max({1.0, at_rest.force.norm(), at_rest.rate.norm()});
      EXPECT_LT(mean.force.norm() + mean.rate.norm(), 3e-4 * size) << effect.name << " " << k;
    }
  }
}

// Effects of time have no mean over a recording or the recordings.
TEST(Effects, OfTimeHaveNoMean) {
  for (const Effect& effect : effects())
    for (int k = 0; k < effect.columns(everything); ++k) {
      OutputChange over_time, over_recordings;
      constexpr int instants = 4000;
      EffectState state{.force = Vector3d(1, 2, 3), .rate = Vector3d(0.3, 0.2, 0.1), .gravity = gravity};
      const bool of_time = effect.name.ends_with("drift"), of_recordings = effect.name.ends_with("turn_on");
      for (int i = 0; i < instants && of_time; ++i) {
        state.time = (i + 0.5) / instants - 0.5;
        const OutputChange change = effect.phi(state, k);
        over_time.force += change.force / instants, over_time.rate += change.rate / instants;
      }
      for (int r = 0; r < everything.recordings && of_recordings; ++r) {
        state.recording = r;
        const OutputChange change = effect.phi(state, k);
        over_recordings.force += change.force, over_recordings.rate += change.rate;
      }
      EXPECT_LT(over_time.force.norm() + over_time.rate.norm(), 1e-6) << effect.name << " " << k;
      EXPECT_LT(over_recordings.force.norm() + over_recordings.rate.norm(), 1e-12) << effect.name << " " << k;
    }
}

// Turn-ons are independent switch-ons minus their mean: shifts with covariance I - 1/n.
TEST(Effects, TurnOnsAreIndependentLessTheirMean) {
  const Effect& effect = *find_effect("accel.turn_on");
  const int n = everything.recordings;
  Eigen::MatrixXd shifts(n, n - 1);
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < n - 1; ++k) shifts(r, k) = effect.phi({.recording = r}, 3 * k).force.x();
  EXPECT_EQ(effect.columns(everything), 3 * (n - 1));
  EXPECT_LT((shifts * shifts.transpose() - (Eigen::MatrixXd::Identity(n, n) - Eigen::MatrixXd::Constant(n, n, 1.0 / n))).norm(), 1e-12);
}

TEST(Effects, ThePlayFollowsTheDirectionOfApproach) {
  PlayOperator play(10);  // a play of 1 m/s^2
  EXPECT_EQ(play(Vector3d(0, 0, 0)), Vector3d(0, 0, 0));
  EXPECT_EQ(play(Vector3d(3, -3, 0.2)), Vector3d(1, -1, 0.4));
  EXPECT_LT((play(Vector3d(2.75, -2, 0.2)) - Vector3d(0.5, 1, 0.4)).norm(), 1e-12);
}

// A unit rotated by K f reads force and rate in axes rotated by that angle.
TEST(Effects, AnElasticMountTurnsTheUnit) {
  const Effect& effect = *find_effect("mount.elastic");
  const EffectState state{.force = Vector3d(1, -2, 9), .rate = Vector3d(0.1, 0.5, -0.3)};
  const double c = 1e-7;
  for (int k = 0; k < 9; ++k) {
    const Matrix3d turned = rotation_exp(c * state.force[k % 3] * Vector3d::Unit(k / 3)).transpose();
    const OutputChange change = effect.phi(state, k);
    EXPECT_LT((turned * state.force - state.force - c * change.force).norm(), 1e-11);
    EXPECT_LT((turned * state.rate - state.rate - c * change.rate).norm(), 1e-11);
  }
}

TEST(Effects, AreThoseThatTheSettingCanHave) {
  const EffectSetting by_hand{.accel = true, .gyro = true};
  for (const Effect& effect : effects()) {
    EXPECT_EQ(effect.columns({}), 0) << effect.name;
    EXPECT_GT(effect.columns(everything), 0) << effect.name;
    const bool of_unit = effect.name.starts_with("accel.") || effect.name.starts_with("gyro."), several = effect.name.ends_with("turn_on"),
               thermal = effect.name.ends_with("temperature") || effect.name.ends_with("thermal"), heading = effect.name.ends_with("heading"),
               change = effect.name.ends_with("change");
    EXPECT_EQ(effect.columns(by_hand) > 0, of_unit && !several && !thermal && !heading && !change) << effect.name;
  }
}

TEST(Effects, HaveNamesAndKeysOfTheirOwn) {
  std::set<std::string, std::less<>> names;
  for (const Effect& effect : effects()) {
    EXPECT_TRUE(names.emplace(effect.name).second);
    EXPECT_TRUE(names.emplace(effect.declared()).second);
    EXPECT_EQ(find_effect(effect.name), &effect);
    for (const double sigma : effect.prior) EXPECT_GT(sigma, 0);
  }
  EXPECT_EQ(find_effect("accel.asymmetry")->simulated(), "accel_asymmetry_ppm");
  EXPECT_EQ(find_effect("gyro.g_squared")->declared(), "gyro_g_squared_sigma_deg_per_h_per_g2");
}

TEST(Effects, ADeclaredSizeComesBeforeThatOfTheGrade) {
  const Effect& effect = *find_effect("accel.asymmetry");
  EXPECT_DOUBLE_EQ(effect_sigma(effect, {}, "navigation"), 10 * unit::ppm);
  EXPECT_DOUBLE_EQ(effect_sigma(effect, {{"accel.asymmetry", 3e-6}}, "navigation"), 3e-6);
}

}  // namespace
}  // namespace imulab
