// The traffic pattern of Xu 2024, section 3, against an independent simulation of the same setting (1000 noise draws): medians and 5..95 % bands.
#include "imulab/core/statistics.hpp"
#include "imulab/formats/session/mission.hpp"
#include "imulab/navigation/budget/monte_carlo.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

using namespace motion;

TEST(Xu2024, ErrorsOfTheTrafficPatternAreDistributedAsElsewhere) {
  const MissionFile file = read_mission(std::filesystem::path(IMULAB_SOURCE) / "docs" / "evidence" / "papers" / "xu2024" / "pattern.toml");
  const NominalMotion motion = nominal_motion(trajectory_of(file.mission), 1 / file.mission.rate);
  EXPECT_EQ(motion.increments.size(), 7120u);
  StrapdownOptions strapdown;
  strapdown.vertical = file.errors->vertical;
  const ErrorDistribution d = error_monte_carlo(motion, error_sources(*file.errors), {.strapdown = strapdown, .output_interval = 4, .runs = 1000});

  const auto expect_band = [](const std::string& what, std::vector<double> values, double median_, double low, double high) {
    for (double& v : values) v = std::abs(v);
    // A factor of 1.5: turns, rolls and draws of the other simulation differ somewhat.
    for (const auto& [found, expected] : {std::pair{median(values), median_}, {quantile(values, 0.05), low}, {quantile(values, 0.95), high}}) {
      EXPECT_GT(found, expected / 1.5) << what;
      EXPECT_LT(found, expected * 1.5) << what;
    }
  };
  const auto row = [](const BudgetRows& rows, Eigen::Index q) {
    std::vector<double> out(static_cast<std::size_t>(rows.cols()));
    for (Eigen::Index k = 0; k < rows.cols(); ++k) out[static_cast<std::size_t>(k)] = rows(q, k);
    return out;
  };
  expect_band("east velocity", row(d.end, 3), 2.9, 0.28, 7.6);
  expect_band("north velocity", row(d.end, 4), 2.5, 0.23, 6.7);
  expect_band("up velocity", row(d.end, 5), 0.93, 0.74, 1.13);
  std::vector<double> horizontal = d.drift;
  for (double& x : horizontal) x *= 712;
  expect_band("horizontal position", horizontal, 1710, 550, 2910);
  expect_band("largest height error", row(d.peak, 2), 5.9, 5.4, 6.8);
}

}  // namespace
}  // namespace imulab
