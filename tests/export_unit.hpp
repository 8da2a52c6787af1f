// Calibrations and noise for tests of exports and imports.
#pragma once

#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/exchange.hpp"
#include "imulab/noise/bound.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <regex>
#include <string>
#include <utility>
#include <vector>

namespace imulab::export_test {

inline Vector3d random_vector(const RandomStream& random, std::uint64_t i, double size) {
  return size * Vector3d(random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2));
}
inline Matrix3d random_matrix(const RandomStream& random, std::uint64_t i, double size) {
  Matrix3d m;
  for (int k = 0; k < 3; ++k) m.col(k) = random_vector(random, 3 * i + static_cast<std::uint64_t>(k), size);
  return m;
}
inline Vector3d random_direction(const RandomStream& random, std::uint64_t i) { return random_vector(random, i, 1).normalized(); }

/// A low-grade unit in SI on a rig whose axes are turned by some degrees: every matrix is full, and no two elements are alike.
inline Calibration si_unit(std::uint64_t seed = 1) {
  const RandomStream random(seed, "unit of exports");
  Calibration c;
  c.imu = "unit";
  c.method = "truth";
  c.created = "2026-11-20T12:00:00Z";
  c.software = "imulab";
  c.frame = BodyFrame::rig;
  c.model.accel.raw_unit = "m/s^2";
  c.model.gyro.raw_unit = "rad/s";
  c.model.accel.matrix = rotation_exp(random_vector(random, 1, 0.05)) * (Matrix3d::Identity() + random_matrix(random, 2, 0.01));
  c.model.gyro.matrix = rotation_exp(random_vector(random, 10, 0.05)) * (Matrix3d::Identity() + random_matrix(random, 12, 0.01));
  c.model.accel.offset = random_vector(random, 30, 0.2);
  c.model.gyro.offset = random_vector(random, 31, 0.01);
  c.model.g_sensitivity = random_matrix(random, 20, 1e-4);
  c.covariance.resize(0, 0);
  return c;
}

/// That unit with drift of the readings over temperature.
inline Calibration thermal_unit(std::uint64_t seed = 1, const char* unit = "degC", double zero = 0) {
  Calibration c = si_unit(seed);
  const RandomStream random(seed, "drift of exports");
  for (auto* triad : {&c.model.accel, &c.model.gyro}) {
    const double size = triad == &c.model.accel ? 1e-2 : 1e-4;
    triad->thermal.col(1) = random_vector(random, triad == &c.model.accel ? 1 : 2, size);
    triad->thermal.col(2) = random_vector(random, triad == &c.model.accel ? 3 : 4, size / 100);
    triad->temperature = ThermalReading{unit, 22.5 + zero, {-5 + zero, 60 + zero}};
  }
  return c;
}

inline NoiseCoefficient determined(double value) { return {value, 0.01 * value, 0.98 * value, 1.02 * value, true}; }
inline NoiseCoefficient undetermined(double upper) {
  return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN(), 0, upper, false};
}

/// At 200 Hz. The gyros' K of the y axis is not determined: its bound, 4e-6, is the largest.
/// A bound above white noise and walk of these sizes.
inline NoiseBound bound_above(double N, double K) {
  constexpr double interval_s = 0.005;
  std::vector<UpperDensity> upper;
  for (const double hz : noise::bound_frequencies(interval_s, 600))
    upper.push_back({hz, N * N + K * K / std::pow(2 * std::numbers::pi * hz, 2) + 0.1 * N * N / (1 + 100 * hz * hz)});
  return noise::tightest_bound(std::move(upper), interval_s, {});
}

inline ImuNoise some_noise() {
  ImuNoise n;
  n.recording = "rest.csv";
  n.interval_s = 0.005;
  n.gyro_unit = "rad/s";
  n.accel_unit = "m/s^2";
  for (std::size_t i = 0; i < 3; ++i) {
    const double k = 1 + 0.25 * static_cast<double>(i);
    n.gyro[i].emplace();
    n.gyro[i]->N = determined(1e-4 * k);
    n.gyro[i]->K = i == 1 ? undetermined(4e-6) : determined(2e-6 * k);
    n.accel[i].emplace();
    n.accel[i]->N = determined(1e-3 * k);
    n.accel[i]->K = determined(5e-5 * k);
    n.gyro[i]->bound = bound_above(1e-4 * k, 2e-6 * k), n.accel[i]->bound = bound_above(1e-3 * k, 5e-5 * k);
  }
  return n;
}

/// Readings of a motion in the range of a handheld unit: up to some g and 400 deg/s.
struct Reading {
  RawSample raw;
  Motion compensated;
};
inline Reading random_reading(const SensorModel& model, const RandomStream& random, std::uint64_t i, double accel_tau = 0, double gyro_tau = 0) {
  Reading r;
  r.raw.accel = random_vector(random, 2 * i, 15);
  r.raw.gyro = random_vector(random, 2 * i + 1, 3);
  r.raw.accel_tau.setConstant(accel_tau);
  r.raw.gyro_tau.setConstant(gyro_tau);
  r.compensated = compensate(model, r.raw);
  return r;
}

/// The bias that is subtracted from readings.
inline Vector3d bias_of(const TriadModel& m) { return -m.matrix.inverse() * m.offset; }

/// Largest difference, relative to the size of the motion.
struct Worst {
  double force = 0, rate = 0;
  void add(const Motion& found, const Motion& expected) {
    force = std::max(force, (found.force - expected.force).norm() / (1 + expected.force.norm()));
    rate = std::max(rate, (found.rate - expected.rate).norm() / (1 + expected.rate.norm()));
  }
};

/// The numbers with a point behind a word of a text.
inline std::vector<double> numbers_after(const std::string& text, const std::string& word, std::size_t count) {
  static const std::regex number(R"([-+]?[0-9]+\.[0-9]*(e[-+]?[0-9]+)?)");
  const std::size_t at = text.find(word);
  EXPECT_NE(at, std::string::npos) << word;
  const std::string rest = text.substr(at + word.size());
  std::vector<double> out;
  for (std::sregex_iterator i(rest.begin(), rest.end(), number), end; i != end && out.size() < count; ++i) out.push_back(std::stod(i->str()));
  EXPECT_EQ(out.size(), count) << word;
  return out;
}

inline constexpr double double_rounding = 1e-12;  // some tens of operations, numbers in the file exact

inline std::string exported(const char* target, const ExportInput& input) { return export_target(target).text(input); }

}  // namespace imulab::export_test
