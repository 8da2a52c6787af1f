#include "imulab/estimate/kernel/terms.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/input.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace imulab::kernel {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::ElementsAre;

TEST(Wald, IsTheSquaredDistanceInSigmas) {
  const TermTest test = wald("two", Eigen::Vector2d(3, 0.4), Eigen::Vector2d(1, 0.01).asDiagonal(), 0.01);
  EXPECT_NEAR(test.statistic, 9 + 16, 1e-12);
  EXPECT_EQ(test.degrees_of_freedom, 2);
  EXPECT_NEAR(test.p_value, std::exp(-12.5), 1e-15);  // chi-square with two degrees of freedom
  EXPECT_TRUE(test.kept);
  EXPECT_FALSE(wald("two", Eigen::Vector2d(1, 0.1), Eigen::Vector2d(1, 0.01).asDiagonal(), 0.01).kept);
  EXPECT_FALSE(wald("none", VectorXd(), MatrixXd(), 0.01).kept);
}

TEST(ChooseTerms, TheLeastSignificantGoesFirstAndTheOthersAreTestedAgain) {
  // b becomes significant only after a, with which it is correlated, has been removed.
  std::vector<std::string> left_out;
  const auto test = [&](const std::vector<TermGroup>& groups) {
    std::vector<TermTest> tests;
    for (const TermGroup& group : groups) {
      const double p = group.name == "a" ? 0.8 : group.name == "b" ? (groups.size() == 3 ? 0.5 : 1e-4) : 1e-9;
      tests.push_back({group.name, 0, 1, p, p < 0.01});
    }
    return tests;
  };
  const auto tests = choose_terms({{"a", {0}}, {"b", {1}}, {"c", {2}}}, test, [&](const TermGroup& group) { left_out.push_back(group.name); });
  EXPECT_THAT(left_out, ElementsAre("a"));
  ASSERT_EQ(tests.size(), 3u);
  EXPECT_FALSE(tests[0].kept);
  EXPECT_TRUE(tests[1].kept && tests[2].kept);
  EXPECT_TRUE(choose_terms({}, test, {}).empty());
}

TEST(CrossValidation, PredictsEachPartFromTheOthers) {
  // A constant is fitted: each value is compared with the mean of the others.
  const VectorXd value = (VectorXd(4) << 1, 2, 4, 9).finished();
  std::vector<Information> parts;
  Information all;
  for (Eigen::Index i = 0; i < 4; ++i) all += parts.emplace_back(MatrixXd::Ones(1, 1), -value.segment<1>(i));
  double squares = 0;
  for (Eigen::Index i = 0; i < 4; ++i) squares += std::pow(value[i] - (16 - value[i]) / 3, 2);
  const CrossValidation found = cross_validation(parts, all, Parameters(1), {{"the constant", {0}}});
  EXPECT_NEAR(found.with, std::sqrt(squares / 4), 1e-12);
  ASSERT_EQ(found.without.size(), 1u);
  EXPECT_NEAR(found.without[0], value.norm() / 2, 1e-12);
}

TEST(ChosenCoefficients, OfAWholeTermAreThoseThatTheMethodHas) {
  const std::vector<CoefficientIndex> supplied = select_each({"accel.offset", "accel.thermal.x1", "accel.thermal.x2"});
  EXPECT_THAT(chosen_coefficients(select_each({"accel.thermal.x1", "accel.thermal.x2", "accel.thermal.x3"}), supplied, "m"),
              ElementsAre(coefficient_index("accel.thermal.x1"), coefficient_index("accel.thermal.x2")));
  EXPECT_THROW(chosen_coefficients(select_each({"accel.offset", "accel.thermal.x3"}), supplied, "m"), TermsError);
  EXPECT_THROW(chosen_coefficients(select_each({"accel.offset", "accel.matrix_thermal1"}), supplied, "m"), TermsError);
}

}  // namespace
}  // namespace imulab::kernel
