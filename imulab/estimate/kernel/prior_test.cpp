#include "imulab/estimate/kernel/prior.hpp"

#include "imulab/grade.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

namespace imulab::kernel {
namespace {

/// An estimate under a prior of sigma 1, and its variance, where the data alone say `value` +- `sigma`.
double widening_of(double value, double sigma) {
  const double variance = sigma * sigma / (1 + sigma * sigma);
  return widening(Eigen::VectorXd::Constant(1, value * (1 - variance)), Eigen::VectorXd::Ones(1), Eigen::MatrixXd::Constant(1, 1, variance));
}

TEST(OptionalTerms, APriorIsWidenedWhereTheDataContradictIt) {
  EXPECT_GT(widening_of(10, 0.1), 10);
  EXPECT_GT(widening_of(10000, 100), 100) << "although the estimate stays at one sigma";
  EXPECT_EQ(widening_of(2, 0.1), 1);
  EXPECT_EQ(widening_of(200, 100), 1) << "noise";
}

TEST(OptionalTerms, OnlyTheContradictedTermIsWidened) {
  PriorSizes sizes;
  sizes.accel.quadratic = sizes.gyro.quadratic = 1;
  const std::vector<CoefficientIndex> indices{coefficient_index("gyro.offset.x"), coefficient_index("accel.quadratic.x"),
                                              coefficient_index("gyro.quadratic.x")};
  const auto widened = widen_priors(sizes, indices, Eigen::Vector3d(100, 1, 100), Eigen::Vector3d::Ones(), 0.01 * Eigen::Matrix3d::Identity());
  EXPECT_EQ(widened, std::vector<std::string>{"gyro.quadratic"});
  EXPECT_EQ(sizes.accel.quadratic, 1);
  EXPECT_GT(sizes.gyro.quadratic, 100);
}

TEST(OptionalTerms, GyrosSetToZeroAreNoBetterThanTheAccelerometers) {
  const auto of_offsets = [](double accel, double gyro) { return optional_priors({}, Vector3d::Constant(accel), Vector3d::Constant(gyro)); };
  const TermSizes &mems = grade("mems").terms, &navigation = grade("navigation").terms;
  EXPECT_EQ(of_offsets(30e-3 * unit::g, 0).g_sensitivity, mems.g_sensitivity);
  EXPECT_EQ(of_offsets(30e-3 * unit::g, 0).gyro.quadratic, mems.gyro_quadratic);
  EXPECT_EQ(of_offsets(70 * unit::ug, 0).g_sensitivity, navigation.g_sensitivity);
  EXPECT_GT(of_offsets(70 * unit::ug, 1 * unit::deg).g_sensitivity, mems.g_sensitivity) << "a gyro whose zero is far off";
}

}  // namespace
}  // namespace imulab::kernel
