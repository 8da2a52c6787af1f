#include "imulab/fleet/statistics/random_effects.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace imulab {
namespace {

/// `units` drawn with this spread, measured with standard deviations from 0.5 to 1.5.
struct DrawnValues {
  Eigen::ArrayXd values, variances;
  DrawnValues(std::uint64_t seed, Eigen::Index units, double spread) : values(units), variances(units) {
    const RandomStream between(seed, "between units"), error(seed, "measurement"), size(seed, "its size");
    for (Eigen::Index i = 0; i < units; ++i) {
      const auto k = static_cast<std::uint64_t>(i);
      const double u = 0.5 + size.uniform(k);
      variances[i] = u * u;
      values[i] = 10 + spread * between.normal(k) + u * error.normal(k);
    }
  }
};

TEST(RandomEffects, WithEqualVariancesAreTheAnalysisOfVariance) {
  // Then the estimate is s^2 - v, and the likelihood of s^2 with n - 1 degrees of freedom gives the interval.
  const Eigen::ArrayXd y = (Eigen::ArrayXd(6) << 1, 2, 4, 8, 9, 12).finished();
  const RandomEffects r = random_effects(y, Eigen::ArrayXd::Constant(6, 2.0));
  const double s2 = (y - y.mean()).square().sum() / 5;
  EXPECT_NEAR(r.spread, std::sqrt(s2 - 2), 1e-6);
  EXPECT_NEAR(r.mean, y.mean(), 1e-12);
  EXPECT_NEAR(r.mean_high - r.mean, student_quantile(0.975, 5) * std::sqrt(s2 / 6), 1e-9);
  const auto fall = [&](double spread) {
    const double ratio = s2 / (spread * spread + 2);
    return 5 * (ratio - 1 - std::log(ratio));  // twice the fall of the logarithm
  };
  EXPECT_NEAR(fall(r.spread_low), chi_square_quantile(0.95, 1), 1e-4);
  EXPECT_NEAR(fall(r.spread_high), chi_square_quantile(0.95, 1), 1e-4);
}

TEST(RandomEffects, CoverTheTruth) {
  // 4000 fleets: the share that covers is known to 0.35 %, so 93 to 97 % is five standard deviations and more from the stated 95 %.
  for (const auto& [units, spread] : {std::pair<Eigen::Index, double>{10, 2.0}, {40, 1.0}, {200, 0.5}}) {
    int mean = 0, size = 0;
    constexpr int fleets = 4000;
    for (int seed = 1; seed <= fleets; ++seed) {
      const DrawnValues d(static_cast<std::uint64_t>(seed), units, spread);
      const RandomEffects r = random_effects(d.values, d.variances);
      mean += r.mean_low <= 10 && 10 <= r.mean_high;
      size += r.spread_low <= spread && spread <= r.spread_high;
    }
    EXPECT_GE(mean, 0.93 * fleets) << units;
    EXPECT_LE(mean, 0.97 * fleets) << units;
    EXPECT_GE(size, 0.93 * fleets) << units;
    EXPECT_LE(size, 0.97 * fleets) << units;
    printf("%d units, spread %g: the interval of the mean covers in %.2f %%, of the spread in %.2f %%\n", static_cast<int>(units), spread,
           100.0 * mean / fleets, 100.0 * size / fleets);
  }
}

TEST(RandomEffects, UnitsThatAreTheSameHaveNoSpread) {
  int zero_inside = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const DrawnValues d(seed, 30, 0);
    zero_inside += random_effects(d.values, d.variances).spread_low == 0;
  }
  // At the edge of what is possible the profile covers in more than 95 %: in 97.5 % for many units; three standard deviations below.
  EXPECT_GE(zero_inside, 400 * (0.975 - 3 * 0.0078));
}

TEST(RandomEffects, OfFewAndOfWrongValues) {
  const Eigen::ArrayXd one = Eigen::ArrayXd::Constant(1, 3.0), v = Eigen::ArrayXd::Constant(1, 4.0);
  const RandomEffects r = random_effects(one, v);
  EXPECT_NEAR(r.mean_high, 3 + 1.95996 * 2, 1e-4);
  EXPECT_TRUE(std::isinf(r.spread_high));
  const RandomEffects same = random_effects(Eigen::ArrayXd::Constant(5, 3.0), Eigen::ArrayXd::Constant(5, 4.0));
  EXPECT_EQ(same.spread, 0);
  EXPECT_TRUE(std::isfinite(same.spread_high));
  EXPECT_THROW(random_effects(one, Eigen::ArrayXd::Zero(1)), Error);
  EXPECT_THROW(random_effects(Eigen::ArrayXd(), Eigen::ArrayXd()), Error);
}

}  // namespace
}  // namespace imulab
