#include "imulab/navigation/budget/navigated.hpp"

#include "imulab/error.hpp"
#include "imulab/navigate.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include "tests/flight_session.hpp"

namespace imulab {
namespace {

/// Returns a calibration whose x gyro offset has an error of exactly its stated sigma.
Calibration one_sigma_wrong(double sigma) {
  Calibration c;
  c.model.gyro.offset.x() = sigma;
  c.estimated = select_coefficients("gyro.offset.x");
  c.covariance = Eigen::MatrixXd::Constant(1, 1, sigma * sigma);
  return c;
}

struct Explained {
  Navigated navigated;
  std::optional<ErrorBudget> budget;
};

Explained explained(const Calibration& c, const FlightSession& f, NavigateOptions options = {}) {
  NavigatedBudget budget(c, f.session, options);
  Navigated navigated = navigate(c, f.session, f.recording, options);
  return {std::move(navigated), budget.finish()};
}

TEST(NavigatedBudget, AnErrorOfOneSigmaIsAtTheEdgeOfTheBand) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  const Calibration c = one_sigma_wrong(1 * unit::deg_per_h);
  const auto [n, budget] = explained(c, f);
  ASSERT_TRUE(budget);
  const NavigationError error = navigation_errors(n.solution, f.truth).history.back();
  const BudgetMatrix& covariance = budget->covariance.back();
  EXPECT_NEAR(budget->time.back(), n.solution.time.back(), 1e-6);
  EXPECT_NEAR(std::sqrt(covariance.diagonal().head<2>().sum()), error.horizontal(),
              0.02 * error.horizontal());  // first order, and error of the integrator itself
  EXPECT_NEAR(std::sqrt(covariance.diagonal().tail<3>().sum()), error.attitude.norm(), 0.02 * error.attitude.norm());
}

TEST(NavigatedBudget, AfterAnAlignmentItHasTheNoiseThatThisSaw) {
  const FlightSession f = flight_session(1, 10);
  const Calibration c = one_sigma_wrong(1e-3 * unit::deg_per_h);
  const auto [n, budget] = explained(c, f);
  ASSERT_TRUE(n.aligned);
  ASSERT_TRUE(budget);
  EXPECT_TRUE(std::any_of(budget->groups.begin(), budget->groups.end(), [](const Contribution& g) { return g.name == "gyro white noise"; }));
}

TEST(NavigatedBudget, IsTheBudgetOfTheNavigatedMotion) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  const Calibration c = one_sigma_wrong(1 * unit::deg_per_h);
  motion::NominalMotion motion;
  NavigateOptions options;
  options.each = [&](double time, const NavigationState& state) { motion.time.push_back(time), motion.states.push_back(state); };
  NavigatedBudget growing(c, f.session, options);
  options.step = [&, step = options.step](double time, const NavigationState& state, const Increment& sample) {
    motion.increments.push_back(sample);
    step(time, state, sample);
  };
  navigate(c, f.session, f.recording, options);
  const double interval = (motion.time.back() - motion.time.front()) / 120;
  const ErrorBudget whole = error_budget(motion, error_sources(c), {.output_interval = interval, .algorithm = false}), grown = *growing.finish();
  EXPECT_EQ(grown.time, whole.time);
  ASSERT_EQ(grown.covariance.size(), whole.covariance.size());
  for (std::size_t i = 0; i < whole.covariance.size(); ++i) EXPECT_EQ(grown.covariance[i], whole.covariance[i]) << i;
}

TEST(NavigatedBudget, WhatCannotBeFollowedIsSaidAtTheEndAndNavigatedAllTheSame) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  Calibration c = one_sigma_wrong(1 * unit::deg_per_h);
  c.covariance *= -1;
  NavigateOptions options;
  NavigatedBudget budget(c, f.session, options);
  EXPECT_GT(navigate(c, f.session, f.recording, options).solution.size(), 2u);
  EXPECT_THROW(budget.finish(), Error);
}

TEST(NavigatedBudget, WithoutUncertaintiesThereIsNone) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  EXPECT_FALSE(explained({}, f).budget);
}

}  // namespace
}  // namespace imulab
