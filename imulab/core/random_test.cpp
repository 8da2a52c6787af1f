#include "imulab/core/random.hpp"

#include "imulab/core/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace imulab {
namespace {

constexpr double rare = 1e-6;  // false-alarm probability of a bound

TEST(RandomStream, NormalsAreNormalIntoTheTails) {
  const std::size_t n = 4'000'000;
  std::vector<double> x(n);
  RandomStream(1, "normals").normals(0, x);
  std::sort(x.begin(), x.end());
  // Bins a quarter wide out to +-4.5, which includes the layers' edges and the tail beyond 3.65; the last ones are open, with 14 expected.
  double chi_square = 0, below = 0;
  std::size_t counted = 0, bins = 0;
  for (double edge = -4.5;; edge += 0.25, ++bins) {
    const bool last = edge > 4.5;
    const double up_to = last ? 1 : 0.5 * std::erfc(-edge / std::sqrt(2));
    const std::size_t count = last ? n : static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), edge) - x.begin());
    const double expected = static_cast<double>(n) * (up_to - below);
    chi_square += std::pow(static_cast<double>(count - counted) - expected, 2) / expected;
    below = up_to, counted = count;
    if (last) break;
  }
  EXPECT_GT(chi_square, chi_square_quantile(rare / 2, static_cast<double>(bins)));
  EXPECT_LT(chi_square, chi_square_quantile(1 - rare / 2, static_cast<double>(bins)));
}

TEST(RandomStream, ADrawDependsOnItsNumberAlone) {
  const RandomStream stream(7, "numbers");
  std::vector<double> many(1000);
  stream.normals(3, many);
  for (std::size_t k = 0; k < many.size(); ++k) EXPECT_EQ(many[k], stream.normal(3 + k));
  EXPECT_NE(stream.normal(5), RandomStream(8, "numbers").normal(5));
  EXPECT_NE(stream.normal(5), RandomStream(7, "others").normal(5));
}

TEST(RandomStream, NeighborsAreUncorrelated) {
  const std::size_t n = 1'000'000;
  std::vector<double> x(n);
  RandomStream(1, "lags").normals(0, x);
  for (const std::size_t lag : {1u, 2u, 3u, 4u, 5u, 8u, 512u}) {
    double sum = 0;
    for (std::size_t k = lag; k < n; ++k) sum += x[k] * x[k - lag];
    EXPECT_LT(std::abs(sum), -normal_quantile(rare / 2) * std::sqrt(static_cast<double>(n))) << lag;
  }
}

}  // namespace
}  // namespace imulab
