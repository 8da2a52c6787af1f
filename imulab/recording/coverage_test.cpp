#include "imulab/recording/coverage.hpp"

#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace imulab {
namespace {

std::vector<Vector3d> six() { return {{9.8, 0, 0}, {-9.8, 0, 0}, {0, 9.8, 0}, {0, -9.8, 0}, {0, 0, 9.8}, {0, 0, -9.8}}; }

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

TEST(Coverage, SixPositionsDetermineSixParameters) {
  const std::vector<double> h = leverages(six());
  EXPECT_NEAR(sum(h), 6, 1e-9);  // three offsets and three scales
  for (const double v : h) EXPECT_NEAR(v, 1, 1e-9);
}

TEST(Coverage, DiagonalDirectionsAddTheMisalignments) {
  std::vector<Vector3d> directions = six();
  for (const double a : {1.0, -1.0}) directions.insert(directions.end(), {{1, a, 0}, {1, 0, a}, {0, 1, a}});
  EXPECT_NEAR(sum(leverages(directions)), 9, 1e-9);
}

TEST(Coverage, ARepeatedRestSharesItsPart) {
  std::vector<Vector3d> directions = six();
  directions.push_back(directions[0]);
  const std::vector<double> h = leverages(directions);
  EXPECT_NEAR(h[0], 0.5, 1e-9);
  EXPECT_NEAR(h[6], 0.5, 1e-9);
  EXPECT_NEAR(h[1], 1, 1e-9);
}

TEST(Coverage, TheGapIsWhereNoRestIs) {
  std::vector<Vector3d> directions = six();
  directions.pop_back();
  const auto gaps = coverage_gaps(directions, 60 * unit::deg, 1);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_LT(gaps[0].direction.z(), -0.99);
  EXPECT_NEAR(gaps[0].angle, 90 * unit::deg, 3 * unit::deg);  // the lattice
  EXPECT_EQ(coverage_gaps(six(), 40 * unit::deg, 8).size(), 8u) << "the corners";
  EXPECT_TRUE(coverage_gaps(six(), 60 * unit::deg).empty());
}

TEST(Coverage, NoRestsNoStatement) {
  EXPECT_TRUE(leverages({}).empty());
  EXPECT_TRUE(coverage_gaps({}, 0.1).empty());
}

}  // namespace
}  // namespace imulab
