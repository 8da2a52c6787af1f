// Correlated errors of aids, in simulated innovations.
#include "imulab/navigation/aided/lasting.hpp"

#include "imulab/core/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace imulab::aided {
namespace {

/// Simulates innovations of a receiver and a vehicle at 200 s: white, with a Markov error of `size` sigmas and `time` s on the velocities.
AidedNavigation drawn(std::uint64_t seed, double size, double time) {
  const RandomStream draw(seed, "innovations");
  AidedNavigation out;
  out.factors = {{"gnss.position"}, {"gnss.velocity"}, {"vehicle.side"}, {"vehicle.up"}};
  std::uint64_t n = 0;
  std::array<double, 3> slow{};
  const double a = std::exp(-1 / time);
  for (double t = 0; t < 200; ++t) {
    for (int k = 0; k < 3; ++k) out.innovations.push_back({t, 0, draw.normal(n++)});
    for (double& error : slow) {
      error = a * error + std::sqrt(1 - a * a) * size * draw.normal(n++);
      out.innovations.push_back({t, 1, draw.normal(n++) + error});
    }
    for (std::size_t k = 2; k < 4; ++k) out.innovations.push_back({t + 0.5, k, draw.normal(n++)});
  }
  return out;
}

TEST(LastingErrors, WhiteInnovationsAreNotNamed) {
  int named = 0;
  constexpr int drives = 1000;
  for (std::uint64_t seed = 1; seed <= drives; ++seed)
    named += std::ranges::any_of(serial_correlations(drawn(seed, 0, 1)), [](const auto& s) { return s.times > 1; });
  EXPECT_LE(named, 4);  // 36 tests at 2e-5: 0.7 of a thousand drives; five or more with p = 1/1400
}

TEST(LastingErrors, ThatAreThereAreNamed) {
  for (const auto& [size, time] : {std::pair(1., 4.), {1., 10.}, {0.7, 30.}}) {
    int named = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
      const std::vector<SerialCorrelation> found = serial_correlations(drawn(seed, size, time));
      named += found[1].times > 1.4 && found[0].times == 1;
    }
    EXPECT_GE(named, 90) << size << " sigmas over " << time << " s";
  }
}

}  // namespace
}  // namespace imulab::aided
