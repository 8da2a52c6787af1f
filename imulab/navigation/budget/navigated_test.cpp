#include "imulab/navigation/budget/navigated.hpp"

#include "imulab/core/units.hpp"
#include "imulab/navigation/navigation_error.hpp"

#include <gtest/gtest.h>

#include "tests/flight_session.hpp"

namespace imulab {
namespace {

/// A calibration whose x gyro offset is wrong by exactly the sigma that it states.
Calibration one_sigma_wrong(double sigma) {
  Calibration c;
  c.model.gyro.offset.x() = sigma;
  c.estimated = select_coefficients("gyro.offset.x");
  c.covariance = Eigen::MatrixXd::Constant(1, 1, sigma * sigma);
  return c;
}

const NavigateOptions with_motion{.motion_steps = 1'000'000};

TEST(NavigatedBudget, AnErrorOfOneSigmaIsAtTheEdgeOfTheBand) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  const Calibration c = one_sigma_wrong(1 * unit::deg_per_h);
  const Navigated n = navigate(c, f.session, f.recording, with_motion);
  const auto budget = navigated_budget(c, f.session, n);
  ASSERT_TRUE(budget);
  const NavigationError error = navigation_errors(n.solution, f.truth).history.back();
  const BudgetMatrix& covariance = budget->covariance.back();
  EXPECT_NEAR(budget->time.back(), n.solution.time.back(), 1e-6);
  EXPECT_NEAR(std::sqrt(covariance.diagonal().head<2>().sum()), error.horizontal(),
              0.02 * error.horizontal());  // first order, and the integrator's own error
  EXPECT_NEAR(std::sqrt(covariance.diagonal().tail<3>().sum()), error.attitude.norm(), 0.02 * error.attitude.norm());
}

TEST(NavigatedBudget, AfterAnAlignmentItHasTheNoiseThatThisSaw) {
  const FlightSession f = flight_session(1, 10);
  const Calibration c = one_sigma_wrong(1e-3 * unit::deg_per_h);
  const Navigated n = navigate(c, f.session, f.recording, with_motion);
  ASSERT_TRUE(n.aligned);
  const auto budget = navigated_budget(c, f.session, n);
  ASSERT_TRUE(budget);
  EXPECT_TRUE(std::any_of(budget->groups.begin(), budget->groups.end(), [](const Contribution& g) { return g.name == "gyro white noise"; }));
}

TEST(NavigatedBudget, NeighborsTogetherGiveTheSame) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  const Calibration c = one_sigma_wrong(1 * unit::deg_per_h);
  const Navigated all = navigate(c, f.session, f.recording, with_motion), few = navigate(c, f.session, f.recording, {.motion_steps = 300});
  ASSERT_EQ(all.motion.increments.size(), 10 * few.motion.increments.size()) << "of 0.2 s each";
  const BudgetMatrix a = navigated_budget(c, f.session, all)->covariance.back(), b = navigated_budget(c, f.session, few)->covariance.back();
  // Within a joined step the attitude is that of its middle.
  for (Eigen::Index i = 0; i < a.rows(); ++i) EXPECT_NEAR(std::sqrt(b(i, i)), std::sqrt(a(i, i)), 2e-3 * std::sqrt(a(i, i))) << i;
}

TEST(NavigatedBudget, WithoutUncertaintiesThereIsNone) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  EXPECT_FALSE(navigated_budget({}, f.session, navigate({}, f.session, f.recording, with_motion)));
}

}  // namespace
}  // namespace imulab
