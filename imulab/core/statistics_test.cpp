#include "imulab/core/statistics.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace imulab {
namespace {

/// Residuals of nothing, as in data without noise, with as many degrees of freedom as a long recording has.
TEST(ChiSquareTail, OfNothingIsOne) {
  for (const double dof : {1., 99., 101., 4'000., 1e6})
    for (const double part : {0., 1e-300, 1e-16}) EXPECT_NEAR(chi_square_tail(part * dof, dof), 1, 1e-7) << dof << " " << part;
}

TEST(Tails, NothingIsBeyondInfinity) {
  const double infinite = std::numeric_limits<double>::infinity(), none = std::numeric_limits<double>::quiet_NaN();
  for (const double x : {infinite, none}) {
    EXPECT_EQ(chi_square_tail(x, 5), 0) << x;
    EXPECT_EQ(log_chi_square_tail(x, 5), -infinite) << x;
    EXPECT_EQ(f_tail(x, 3, 7), 0) << x;
  }
}

TEST(ChiSquareTail, AgreesWithTheTables) { EXPECT_NEAR(chi_square_tail(124.342, 100), 0.05, 1e-6); }  // Abramowitz and Stegun, table 26.8

}  // namespace
}  // namespace imulab
