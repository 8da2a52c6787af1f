#include "imulab/navigation/budget/run_statistics.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

/// Returns errors of a run at two outputs, so far from zero that sums of squares alone would lose them.
BudgetRows drawn_run(std::uint64_t number) {
  const RandomStream stream(1, "run " + std::to_string(number));
  BudgetRows errors(budget_quantities, 2);
  for (Eigen::Index k = 0; k < errors.size(); ++k) errors(k) = 1000 + static_cast<double>(k) + stream.normal(static_cast<std::uint64_t>(k));
  return errors;
}

TEST(RunStatistics, OfBlocksAreThoseOfAllRuns) {
  constexpr std::uint64_t runs = 300, block = 7;
  RunStatistics all(2);
  std::vector<double> height, horizontal;
  for (std::uint64_t begin = 0; begin < runs; begin += block) {
    RunStatistics own(2), read(2);
    for (std::uint64_t k = begin; k < std::min(runs, begin + block); ++k) {
      const BudgetRows errors = drawn_run(k);
      own.add(errors);
      height.push_back(static_cast<double>(static_cast<float>(errors(2, 1))));
      horizontal.push_back(std::hypot(errors(0, 1), errors(1, 1)));
    }
    std::string bytes;
    own.write(bytes);
    std::string_view left = bytes;
    read.read(left);
    EXPECT_TRUE(left.empty());
    all.add(read);
    for (const std::size_t size : {0u, 10u, 24u, 40u, 100u}) {
      left = std::string_view(bytes).substr(0, size);
      EXPECT_THROW(read.read(left), Error) << size;
    }
  }
  ErrorDistribution out;
  out.time = {1, 2};
  all.summarize(out, 10);
  double mean = 0, square = 0;
  for (const double h : height) mean += h / runs;
  for (const double h : height) square += (h - mean) * (h - mean) / (runs - 1);
  EXPECT_NEAR(out.mean(2, 1), mean, 1e-9);
  EXPECT_NEAR(out.sigma(2, 1), std::sqrt(square), 1e-9);
  // All errors are in one or two bins of the histograms: quantiles depend only on a mean and the width of a bin.
  EXPECT_NEAR(out.median(2, 1), median(height), mean * Histogram::relative_width);
  EXPECT_NEAR(out.drift_95, quantile(horizontal, 0.95) / 10, 1500 * Histogram::relative_width / 10);
  double rms = 0;
  for (const double h : horizontal) rms += h * h / runs;
  EXPECT_NEAR(out.drift_rms, std::sqrt(rms) / 10, 1e-5);  // floats
}

}  // namespace
}  // namespace imulab
