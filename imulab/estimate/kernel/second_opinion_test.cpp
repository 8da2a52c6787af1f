#include "imulab/estimate/kernel/second_opinion.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/kernel/findings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace imulab::kernel {
namespace {

/// Returns a calibration with offsets known to `sigma` and wrong by `error`.
Calibration offsets(double sigma, const Vector3d& error) {
  Calibration c;
  c.method = "some";
  c.estimated = select_coefficients("accel.offset");
  c.covariance = sigma * sigma * Eigen::MatrixXd::Identity(3, 3);
  c.model.accel.offset = error;
  return c;
}

TEST(SecondOpinion, IsByTheDifferenceOfTheVariances) {
  const auto opinion = second_opinion(offsets(3, {0, 0, 0}), offsets(5, {4, -8, 2}));
  ASSERT_TRUE(opinion.has_value());
  EXPECT_EQ(opinion->coefficient, "accel.offset.y");
  EXPECT_NEAR(opinion->sigmas, -2, 1e-12);  // sqrt(25 - 9) = 4
}

TEST(SecondOpinion, EstimatesOfOneVarianceTellNothing) { EXPECT_FALSE(second_opinion(offsets(1, {0, 0, 0}), offsets(1.02, {9, 9, 9})).has_value()); }

TEST(SecondOpinion, TakesErrorsAsIndependentWhereNeitherIsEfficient) {
  Calibration one = offsets(3, {0, 0, 0}), other = offsets(3, {4, -8, 2});
  one.covariance(0, 0) = other.covariance(2, 2) = 25;
  EXPECT_NEAR(second_opinion(one, other)->sigmas, -8 / std::sqrt(18.0), 1e-12);
}

TEST(SecondOpinion, BecomesADoubtBeyondChance) {
  Calibration c = offsets(3, {0, 0, 0});
  c.quality.verdict = Verdict::good;
  add_second_opinion(c, offsets(5, {0, 14, 0}));  // 3.5
  EXPECT_EQ(c.quality.verdict, Verdict::good);
  add_second_opinion(c, offsets(5, {0, 16, 0}));
  EXPECT_EQ(c.quality.verdict, Verdict::doubtful);
  EXPECT_EQ(c.quality.findings.reasons().size(), 1u);
}

TEST(SecondOpinion, OfOneThatDoubtsItselfCountsForTheSessionAlone) {
  Calibration c = offsets(3, {0, 0, 0}), doubtful = offsets(5, {0, 16, 0});
  c.quality.verdict = Verdict::good;
  doubtful.quality.findings.add<Code::not_converged>();
  judge(doubtful.quality);
  add_second_opinion(c, doubtful);
  EXPECT_EQ(c.quality.verdict, Verdict::good);
  Findings of_session;
  of_session.add<Code::wrong_latitude>(), of_session.add<Code::wrong_turn>();
  for (const Finding& found : of_session) {
    Calibration other = doubtful, mine = c;
    other.quality.findings.push_back(found);
    judge(other.quality);
    add_second_opinion(mine, other);
    EXPECT_EQ(mine.quality.findings.reasons(), std::vector<std::string>{found.text + ", by the method some from the same data"});
    EXPECT_EQ(mine.quality.cause, other.quality.cause);
  }
}

// The mean of n readings and the mean of n / 4 of them: their difference has the difference of the variances.
TEST(SecondOpinion, HoldsForAnEfficientEstimateAndAPartOfItsData) {
  const RandomStream random(7, "second opinion");
  constexpr int trials = 4000, n = 16;
  double square = 0;
  for (int t = 0; t < trials; ++t) {
    double all = 0, part = 0;
    for (int i = 0; i < n; ++i) {
      const double x = random.normal(static_cast<std::uint64_t>(t * n + i));
      all += x / n, part += i < n / 4 ? x / (n / 4) : 0;
    }
    const auto opinion = second_opinion(offsets(0.25, {all, 0, 0}), offsets(0.5, {part, 0, 0}));
    square += opinion->sigmas * opinion->sigmas / trials;
  }
  EXPECT_NEAR(square, 1, 4 * std::sqrt(2.0 / trials));
}

}  // namespace
}  // namespace imulab::kernel
