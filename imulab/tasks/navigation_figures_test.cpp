#include "imulab/tasks/navigation_figures.hpp"

#include "imulab/error.hpp"
#include "imulab/model/conclusion.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace imulab {
namespace {

using testing::HasSubstr;

/// Every 100 s to 1000 s: sigma 2 m/s times the time, east and north alike; 1 m/s up.
ErrorBudget budget_that_grows() {
  ErrorBudget b;
  b.mean = BudgetRows::Zero(budget_quantities, 11);
  for (int i = 0; i <= 10; ++i) {
    b.time.push_back(100. * i);
    BudgetMatrix P = BudgetMatrix::Zero();
    P(0, 0) = P(1, 1) = std::pow(2 * b.time.back(), 2), P(2, 2) = std::pow(b.time.back(), 2);
    b.covariance.push_back(P);
  }
  return b;
}

NavigatedSession session_that_drifts(const std::string& name, double rate) {
  NavigatedSession s{.session = name, .navigated = {}, .errors = NavigationErrors{}};
  constexpr double begin = 1.7e9;  // a clock from 1970
  s.navigated.solution.time = {begin, begin + 600};
  for (int i = 0; i <= 6; ++i) s.errors->history.push_back({begin + 100. * i, {rate * 100 * i, 0, -1. * i}, {rate, 0, 0}, {0, 0, 1e-3}});
  s.errors->rate = rate;
  return s;
}

std::string refusal_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(RadiusOf, HoldsItsPartOfAGaussianError) {
  const Eigen::Vector2d none = Eigen::Vector2d::Zero();
  EXPECT_NEAR(radius_of(0.5, none, Eigen::Matrix2d::Identity()), std::sqrt(2 * std::log(2)), 1e-4);
  EXPECT_NEAR(radius_of(0.95, none, 9 * Eigen::Matrix2d::Identity()), 3 * std::sqrt(2 * std::log(20)), 1e-3);
  EXPECT_NEAR(radius_of(0.5, none, Eigen::Vector2d(4, 0).asDiagonal()), 2 * 0.67449, 1e-3) << "along a line";
  EXPECT_NEAR(radius_of(0.5, {30, 40}, 1e-6 * Eigen::Matrix2d::Identity()), 50, 0.01) << "a fixed error alone";
  EXPECT_EQ(radius_of(0.5, none, Eigen::Matrix2d::Zero()), 0);
}

TEST(BudgetRequirement, AtTheEndOrAtATimeInMetersOrAsARate) {
  const ErrorBudget b = budget_that_grows();
  const double cep = std::sqrt(2 * std::log(2)) * 2;  // m/s
  const auto results = assess(b, std::nullopt, "CEP <= 1 km at 250 s, RMS <= 1 nmi, CEP <= 5 nmi/h, vertical <= 1000 m");
  EXPECT_NEAR(results[0].reached, cep * 250, 1e-3 * cep * 250);
  EXPECT_TRUE(results[0].met);
  EXPECT_NEAR(results[1].reached, 2000 * std::sqrt(2), 1e-9);
  EXPECT_FALSE(results[1].met);
  EXPECT_NEAR(results[2].reached, cep, 1e-3);
  EXPECT_TRUE(results[2].met) << reached_text(results[2]);
  EXPECT_TRUE(results[3].met);
  EXPECT_THAT(results[0].note, HasSubstr("without a Monte Carlo"));
}

/// 100 runs that end 1 m, 2 m ... 100 m off: fewer than half of them within 40 m, or more within 61 m, would have p < 0.025 (a binomial's sigma is
/// 5).
TEST(BudgetRequirement, RunsLeaveAnIntervalOfARadius) {
  const ErrorBudget b = budget_that_grows();
  ErrorDistribution sampled{.time = b.time, .runs = 100};
  sampled.median.setConstant(budget_quantities + 1, static_cast<Eigen::Index>(b.time.size()), 51);
  sampled.mean = sampled.sigma = sampled.low = sampled.high = sampled.median;
  sampled.end = BudgetRows::Zero(budget_quantities, 100);
  for (Eigen::Index i = 0; i < 100; ++i) sampled.end(i % 2, i) = static_cast<double>(100 - i);
  const auto results = assess(b, sampled, "CEP <= 60 m, CEP <= 62 m, CEP <= 39 m");
  EXPECT_FALSE(results[0].met);
  EXPECT_THAT(results[0].note, HasSubstr("undecided, with 95 % in 40 to 61 m"));
  EXPECT_TRUE(results[1].met);
  EXPECT_FALSE(results[2].met);
}

TEST(BudgetRequirement, RefusesWhatThereIsNot) {
  const auto refused = [](const char* limits) { return refusal_of([&] { assess(budget_that_grows(), std::nullopt, limits); }); };
  EXPECT_THAT(refused("CEP <= 1 nmi/h at 600 s"), HasSubstr("a rate is of the whole motion"));
  EXPECT_THAT(refused("CEP <= 1 m at 2000 s"), HasSubstr("there are errors until 1000 s"));
  EXPECT_THAT(refused("CPE <= 1 m"), HasSubstr("no figure of this result; did you mean CEP?"));
  EXPECT_THAT(refused("wind <= 1 m"), HasSubstr("no figure of this result; expected one of CEP, RMS, 95 %, vertical, velocity, heading"));
}

TEST(NavigationRequirement, EachSessionOrAllTogether) {
  const std::vector<NavigatedSession> two{session_that_drifts("one", 0.1), session_that_drifts("two", 0.3)};
  const auto results = assess(two, "horizontal <= 50 m at 250 s, CEP <= 0.4 nmi/h, vertical <= 6 m, heading <= 1 deg");
  EXPECT_NEAR(results[0].reached, 75, 1e-3);
  EXPECT_FALSE(results[0].met);
  EXPECT_EQ(results[0].note, "the worst is two");
  EXPECT_NEAR(results[1].reached, 0.2, 1e-12);
  EXPECT_EQ(results[1].met, 0.2 <= 0.4 * unit::nmi_per_h);
  EXPECT_TRUE(results[2].met && results[3].met);
}

TEST(NavigationRequirement, NeedsATruth) {
  std::vector<NavigatedSession> one{session_that_drifts("one", 0.1)};
  one.front().errors.reset();
  EXPECT_THAT(refusal_of([&] { assess(one, "horizontal <= 1 m"); }), HasSubstr("one: has no truth"));
}

}  // namespace
}  // namespace imulab
