#include "imulab/error.hpp"
#include "imulab/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace imulab {
namespace {

NoiseAnalysis log_of(const char* name, NoiseCoefficient N) {
  NoiseAnalysis analysis;
  analysis.recording = name;
  NoiseAxis axis;
  axis.name = "gyro.x", axis.unit = "rad/s";
  axis.fit.emplace();
  axis.fit->N = N;
  axis.fit->K = {NAN, NAN, 0, N.upper, false};
  analysis.axes = {axis};
  return analysis;
}

NoiseCoefficient known(double value, double u) { return {value, u, value - 1.96 * u, value + 1.96 * u, true}; }

TEST(NoiseBatch, AgreeingLogsGiveTheirWeightedMean) {
  const NoiseBatch batch = noise_batch({log_of("a", known(1.0, 0.1)), log_of("b", known(1.1, 0.2))});
  const BatchCoefficient& N = batch.axes[0].coefficients[1];
  EXPECT_EQ(N.determined, 2);
  EXPECT_NEAR(N.mean.value, (100 * 1.0 + 25 * 1.1) / 125, 1e-12);
  EXPECT_NEAR(N.mean.standard_uncertainty, 1 / std::sqrt(125), 1e-12);
  EXPECT_EQ(N.spread, 0);
  EXPECT_EQ(N.worst, 1.1);
  EXPECT_EQ(N.worst_log, 1u);
}

TEST(NoiseBatch, UnitsThatDifferHaveASpread) {
  // For equal uncertainties, spread^2 is the sample variance minus u^2.
  const NoiseBatch batch = noise_batch({log_of("a", known(1, 0.1)), log_of("b", known(2, 0.1)), log_of("c", known(3, 0.1))});
  const BatchCoefficient& N = batch.axes[0].coefficients[1];
  EXPECT_NEAR(N.spread, std::sqrt(1 - 0.01), 1e-9);
  EXPECT_NEAR(N.mean.value, 2, 1e-9);
  EXPECT_NEAR(N.mean.standard_uncertainty, 1 / std::sqrt(3), 1e-9);
  EXPECT_NEAR(N.mean.upper, 2 + 4.3027 / std::sqrt(3), 1e-3) << "Student's 97.5 % point with 2 degrees of freedom";
}

TEST(NoiseBatch, WhatNoLogDeterminesHasTheLargestBound) {
  const NoiseBatch batch = noise_batch({log_of("a", known(1, 0.1)), log_of("b", known(5, 0.1))});
  const BatchCoefficient& K = batch.axes[0].coefficients[3];
  EXPECT_EQ(K.determined, 0);
  EXPECT_FALSE(K.mean.determined);
  EXPECT_NEAR(K.mean.upper, 5.196, 1e-9);
  EXPECT_TRUE(std::isnan(K.spread));
}

TEST(NoiseBatch, RefusesLogsInOtherUnits) {
  NoiseAnalysis other = log_of("b", known(1, 0.1));
  other.axes[0].unit = "count";
  EXPECT_THROW(noise_batch({log_of("a", known(1, 0.1)), other}), Error);
}

}  // namespace
}  // namespace imulab
