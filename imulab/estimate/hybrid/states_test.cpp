#include "imulab/estimate/hybrid/states.hpp"

#include "imulab/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace imulab::hybrid {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

const Place here{0.8, 9.8, 1e-3, 3e-4};
const Terms all{.optional = {Group::lever_arm, Group::quadratic, Group::g_sensitivity, Group::delay}};

TEST(HybridStates, GroupsStandOneAfterTheOther) {
  const States states(all, here);
  Index next = 0;
  for (const Group group : states.groups()) {
    EXPECT_EQ(states.first(group), next) << name(group);
    next += states.size(group);
  }
  EXPECT_EQ(next, states.constants());
  EXPECT_EQ(states.size(), 21 + 1 + 3 + 1 + 9 + 3 + 9 + 1 + 1 + 1 + 6);
  EXPECT_FALSE(States({}, {0.8, 9.8}).has(Group::latitude)) << "it is known";
}

TEST(HybridStates, EveryCoefficientIsCorrectedOnceUnderAPrior) {
  const States states(all, here);
  std::vector<CoefficientIndex> corrected;
  for (const Index s : states.corrections()) {
    corrected.push_back(states.corrects(s));
    EXPECT_GT(states.prior[s], 0);
    EXPECT_EQ(states.needed()[s], (is_optional(coefficient(states.corrects(s)).term) ? 0.9 : 0.5) * states.prior[s]);
  }
  EXPECT_THAT(corrected, testing::UnorderedElementsAreArray(all_coefficients()));
  EXPECT_TRUE(std::isinf(states.needed()[states.first(Group::gravity)]));
  EXPECT_EQ(optional_groups(all_coefficients()), (Groups{Group::lever_arm, Group::quadratic, Group::g_sensitivity}));
}

TEST(HybridStates, WhatIsNotWantedIsHeld) {
  const States states({.wanted = select_coefficients("gyro.matrix")}, here);
  EXPECT_EQ(states.corrections().size(), 9u);
  EXPECT_EQ(states.prior[states.first(Group::accel_offset)], 0);
  EXPECT_GT(states.prior[states.first(Group::gravity)], 0);
}

TEST(HybridStates, ACorrectionTakesTheErrorsAway) {
  SensorModel model;
  model.accel.offset << 0.1, -0.2, 0.3;
  model.gyro.offset << 1e-3, 2e-3, -1e-3;
  model.g_sensitivity(0, 1) = 1e-4;
  const States states(all, here);
  VectorXd x = VectorXd::Zero(states.constants());
  for (const Index s : states.corrections()) x[s] = 1e-3 * states.prior[s];
  const SensorModel out = corrected(model, x, states);
  // The expected output is f - (ba + Ma f + q f^2), w - (bg + Mg w + Cg f) for the model at these readings, to first order.
  const Vector3d V(3, -2, 9), W(0.2, 0.1, -0.3), f = model.accel.offset + V, w = model.gyro.offset + W + model.g_sensitivity * f;
  Matrix3d Ma = Matrix3d::Zero();
  Ma << x[3], 0, 0, x[4], x[5], 0, x[6], x[7], x[8];
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> Mg(&x[12]), Cg(&x[states.first(Group::g_sensitivity)]);
  const Vector3d q = x.segment<3>(states.first(Group::quadratic));
  const Vector3d force = f - (x.head<3>() + Ma * f + q.cwiseProduct(f.cwiseAbs2())), rate = w - (x.segment<3>(9) + Mg * w + Cg * f);
  const Vector3d new_force = out.accel.offset + out.accel.matrix * V + out.accel.quadratic.cwiseProduct(V.cwiseAbs2());
  EXPECT_LT((new_force - force).norm(), 1e-12);
  EXPECT_LT((out.gyro.offset + out.gyro.matrix * W + out.g_sensitivity * new_force - rate).norm(), 1e-7);
}

TEST(HybridStates, APlaceHasALatitude) {
  Site site;
  site.given_gravity = 9.8;
  EXPECT_THROW(place_of(site), Error);
}

}  // namespace
}  // namespace imulab::hybrid
