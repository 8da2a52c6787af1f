// Differences that are visible only in combination with other coefficients, and differences between turn-ons.
#include "imulab/coefficient.hpp"
#include "imulab/compare.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace imulab {
namespace {

/// Returns offset and scale of the vertical accelerometer as a level road determines them: only their combined effect under gravity.
Calibration on_level_road(double offset, double scale) {
  constexpr double g = 9.8, unknown = 1e-2, known = 1e-4;  // of the scale; of offset + g scale, m/s^2
  Calibration c;
  c.estimated = {coefficient_index("accel.offset.z"), coefficient_index("accel.matrix.zz")};
  const Eigen::Vector2d free(-g, 1);
  c.covariance = unknown * unknown * free * free.transpose();
  c.covariance(0, 0) += known * known;
  c.model.accel.offset.z() = offset, c.model.accel.matrix(2, 2) = 1 + scale;
  return c;
}

TEST(Compare, NamesWhatDiffersOnlyTogether) {
  const Calibration a = on_level_road(0, 0);
  const Comparison alike = compare(a, on_level_road(-9.8e-3, 1e-3));
  EXPECT_GT(alike.consistency.p_value, 0.9);
  EXPECT_TRUE(alike.consistency.differing.empty());
  const Comparison c = compare(a, on_level_road(1e-3, 0));  // 7.1 sigmas of the sum, 0.007 of the offset
  for (const CoefficientDifference& d : c.coefficients) EXPECT_LT(std::abs(*d.sigmas()), 0.01);
  EXPECT_NEAR(c.consistency.chi2, 50, 0.1);
  ASSERT_EQ(c.consistency.differing.size(), 1u) << "the other one agrees then";
  EXPECT_NEAR(std::abs(c.consistency.differing[0].sigmas), std::sqrt(50.), 0.01);
  EXPECT_EQ(agreement({a, on_level_road(1e-3, 0)}).consistency.differing.size(), 1u);
}

TEST(Compare, OffsetsAreAsRepeatableAsTheirTurnOn) {
  Calibration a;
  a.estimated = select_coefficients("accel.offset");
  for (const CoefficientIndex index : select_coefficients("gyro.offset")) a.estimated.push_back(index);
  a.covariance = 1e-16 * Eigen::MatrixXd::Identity(6, 6);
  a.turn_on = TurnOn{.accel = 3e-3, .gyro = 1e-4};
  a.model.g_sensitivity(0, 1) = 0.1;  // the gyros' offset refers to zero output of the accelerometers
  Calibration b = a, truth;
  b.model.accel.offset.x() = 6e-3, b.model.gyro.offset.x() = 4e-4;
  truth.model.g_sensitivity = a.model.g_sensitivity;
  const double of_gyro = std::hypot(1e-4, 0.1 * 3e-3);
  const auto sigmas = [](const Comparison& c, const char* name) {
    for (const CoefficientDifference& d : c.coefficients)
      if (d.index == coefficient_index(name)) return *d.sigmas();
    return std::nan("");
  };
  EXPECT_NEAR(sigmas(compare(a, b), "accel.offset.x"), 6e-3 / (3e-3 * std::sqrt(2.)), 1e-6);
  EXPECT_NEAR(sigmas(compare(a, b), "gyro.offset.x"), 4e-4 / (of_gyro * std::sqrt(2.)), 1e-6);
  EXPECT_NEAR(sigmas(compare(truth, b), "accel.offset.x"), 2, 1e-6) << "the truth is the unit's";
  EXPECT_GT(compare(a, b).consistency.p_value, 0.01);
  b.turn_on = a.turn_on = std::nullopt;
  EXPECT_LT(compare(a, b).consistency.p_value, 1e-9);
}

}  // namespace
}  // namespace imulab
