#include "imulab/estimate/extrinsics/bordered_band.hpp"

#include "imulab/core/random.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace imulab::extrinsics {
namespace {

TEST(BorderedBand, SolvesAsADenseMatrix) {
  constexpr Eigen::Index band = 40, width = 5, border = 4;
  const RandomStream random(1, "bordered band");
  std::uint64_t drawn = 0;
  BorderedBand equations(band, width, border);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(band + border, band + border);
  std::vector<int> columns{2, 0, 3};
  for (Eigen::Index first = 0; first + width < band; ++first) {
    BorderedBand::ThreeRows of_band(3, width + 1), of_border(3, 3);
    for (double& x : of_band.reshaped()) x = random.normal(drawn++);
    for (double& x : of_border.reshaped()) x = random.normal(drawn++);
    equations.add(first, of_band, columns, of_border, 2);
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, band + border);
    rows.middleCols(first, width + 1) = of_band;
    for (std::size_t j = 0; j < columns.size(); ++j) rows.col(band + columns[j]) = of_border.col(static_cast<Eigen::Index>(j));
    dense += 2 * rows.transpose() * rows;
  }
  equations.corner.diagonal().array() += 1;
  dense.diagonal().tail(border).array() += 1;
  equations.factor(true);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(band + border, -1, 2);
  const BorderedBand::Solution x = equations.solve(b.head(band), b.tail(border));
  const Eigen::MatrixXd inverse = inverse_of(dense);
  const Eigen::VectorXd expected = inverse * b;
  EXPECT_LT((x.band - expected.head(band)).norm(), 1e-8 * expected.norm());
  EXPECT_LT((x.border - expected.tail(border)).norm(), 1e-8 * expected.norm());
  EXPECT_NEAR(equations.squared_norm(b.head(band), b.tail(border)), b.dot(expected), 1e-8 * b.dot(expected));
  EXPECT_LT((equations.border_covariance() - inverse.bottomRightCorner(border, border)).norm(), 1e-8);
  // A right side in the middle of the band: all of it is reduced, since it reaches the end.
  Eigen::VectorXd part = Eigen::VectorXd::Zero(band);
  part.segment(10, 8).setOnes();
  const Eigen::VectorXd whole = equations.reduced(0, part, b.tail(border)), near = equations.reduced(10, part.segment(10, 8), b.tail(border));
  EXPECT_LT((whole - near).norm(), 1e-9);
}

TEST(BorderedBand, AHeldBorderLeavesTheBandAlone) {
  BorderedBand equations(3, 1, 1);
  BorderedBand::ThreeRows of_band = BorderedBand::ThreeRows::Zero(3, 2), of_border = BorderedBand::ThreeRows::Ones(3, 1);
  of_band(0, 0) = of_band(1, 1) = 2;
  equations.add(0, of_band, {0}, of_border, 1), equations.add(1, of_band, {0}, of_border, 1);
  equations.factor(false);
  const BorderedBand::Solution x = equations.solve(Eigen::Vector3d(4, 8, 4), Eigen::VectorXd::Zero(1));
  EXPECT_LT((x.band - Eigen::Vector3d(1, 1, 1)).norm(), 1e-12);
}

}  // namespace
}  // namespace imulab::extrinsics
