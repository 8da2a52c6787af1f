#include "imulab/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

NoiseCoefficient known(double value) { return {value, 0.1 * value, 0.8 * value, 1.2 * value, true}; }

TEST(ImuNoise, AllanVarianceOfEachTerm) {
  NoiseCoefficients noise{.Q = known(2), .N = known(3), .B = known(5), .K = known(7), .R = known(11), .markov = {}};
  const AllanTerms at = allan_variance(noise, 4);
  EXPECT_NEAR(at.Q, 3 * 4 / 16.0, 1e-12);
  EXPECT_NEAR(at.N, 9 / 4.0, 1e-12);
  EXPECT_NEAR(std::sqrt(at.B), 0.6643 * 5, 1e-3) << "the plateau";
  EXPECT_NEAR(at.K, 49 * 4 / 3.0, 1e-12);
  EXPECT_NEAR(std::sqrt(at.R), 11 * 4 / std::sqrt(2), 1e-12);
  noise.K.determined = false;
  EXPECT_EQ(allan_variance(noise, 4).K, 0);
}

TEST(ImuNoise, AMarkovProcessIsAWalkBeforeItsTimeAndWhiteAfterIt) {
  NoiseCoefficients noise;
  noise.markov = {{known(2), known(100)}};
  // For a process driven by white noise of density q^2 = 2 sigma^2 / time, the variance is initially q^2 tau / 3 and finally q^2 time^2 / tau; the
  // maximum is at 1.89 times (IEEE Std 952).
  EXPECT_NEAR(allan_variance(noise, 0.01).markov / (2 * 4 / 100.0 * 0.01 / 3), 1, 1e-3);
  EXPECT_NEAR(allan_variance(noise, 1e6).markov / (2 * 4 * 100 / 1e6), 1, 1e-3);
  EXPECT_GT(allan_variance(noise, 189).markov, allan_variance(noise, 170).markov);
  EXPECT_GT(allan_variance(noise, 189).markov, allan_variance(noise, 210).markov);
  EXPECT_NEAR(allan_variance(noise, 0.1001).markov, allan_variance(noise, 0.0999).markov, 0.003 * allan_variance(noise, 0.1).markov)
      << "at the series";
}

}  // namespace
}  // namespace imulab
