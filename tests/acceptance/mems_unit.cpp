#include "tests/acceptance/mems_unit.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/units.hpp"
#include "imulab/model/compensate.hpp"

#include <Eigen/LU>

namespace imulab::acceptance {

namespace {

using namespace unit;

/// Table 2: sizes uniform in its ranges, signs random. It gives no bias, scale, and thermal terms: 0.5 deg/s and 30 mg, 1 %, 1 deg/s and 30 mg over 45 K.
SensorModel drawn_unit(std::uint64_t seed) {
  const RandomStream sizes(seed, "dai unit"), signs(seed, "dai unit signs"), normals(seed, "dai unit normals");
  std::uint64_t next = 0;
  const auto within = [&](double low, double high) {
    const std::uint64_t k = next++;
    return (low + (high - low) * sizes.uniform(k)) * (signs.uniform(k) < 0.5 ? -1 : 1);
  };
  const auto sigma = [&](double size) { return size * normals.normal(next++); };
  SensorModel m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      m.gyro.matrix(i, j) = i == j ? 1 + sigma(0.01) : within(0.001, 0.005);
      m.accel.matrix(i, j) = i == j ? 1 + sigma(0.01) : within(0.001, 0.02);
      m.g_sensitivity(i, j) = within(0.01, 0.04) * deg / g;
    }
    m.gyro.quadratic(i) = within(1.5e-4, 2.5e-4) / deg, m.accel.quadratic(i) = within(2e-5, 1e-4) / g;
    m.gyro.cubic(i) = within(4e-10, 1e-9) / (deg * deg), m.accel.cubic(i) = within(5e-6, 2e-5) / (g * g);
    m.gyro.offset(i) = sigma(0.5 * deg), m.accel.offset(i) = sigma(0.03 * g);
    m.gyro.thermal.row(i) << 0, sigma(1 * deg / 45), sigma(0.33 * deg / (45 * 45));
    m.accel.thermal.row(i) << 0, sigma(0.03 * g / 45), sigma(0.01 * g / (45 * 45));
  }
  m.gyro.temperature = m.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  return m;
}

/// Six positions at rest give the accelerometers and the gyros' offset, opposed rates the gyros' matrix: at 25 degC, without noise.
SensorModel traditional_calibration(const SensorModel& unit) {
  SensorModel out;
  Matrix3d up, raw_up, raw_turned;
  Vector3d rest_accel = Vector3d::Zero(), rest_gyro = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d e = Vector3d::Unit(axis);
    const auto reading = [&](double force, double rate) { return decompensate(unit, {force * g * e, rate * 200 * deg * e}); };
    const RawSample above = reading(1, 0), below = reading(-1, 0);
    raw_up.col(axis) = (above.accel - below.accel) / (2 * g);
    raw_turned.col(axis) = (reading(1, 1).gyro - reading(1, -1).gyro) / (2 * 200 * deg);
    rest_accel += (above.accel + below.accel) / 6;
    rest_gyro += (above.gyro + below.gyro) / 6;
  }
  out.accel.matrix = raw_up.inverse();
  out.gyro.matrix = raw_turned.inverse();
  out.accel.offset = -out.accel.matrix * rest_accel;
  out.gyro.offset = -out.gyro.matrix * rest_gyro;
  return out;
}

}  // namespace

CalibratedUnit calibrated_unit(std::uint64_t seed) {
  CalibratedUnit out;
  out.truth.model = drawn_unit(seed);
  out.truth.gyro_noise.N = 0.02 * deg;
  out.truth.accel_noise.N = 100 * ug_per_sqrt_hz;
  out.truth.gyro_noise.turn_on = {30 * deg_per_h};  // table 1, one sigma
  out.truth.accel_noise.turn_on = {1000 * ug};
  out.traditional = traditional_calibration(out.truth.model);
  out.whole = out.truth.model;  // stands in for its estimate: errors of plausible size
  const RandomStream errors(seed, "dai unit estimate");
  std::uint64_t next = 0;
  for (int i = 0; i < 3; ++i) {
    out.whole.accel.offset(i) += 200 * ug * errors.normal(next++);
    out.whole.gyro.offset(i) += 5 * deg_per_h * errors.normal(next++);
    for (int j = 0; j < 3; ++j) {
      out.whole.accel.matrix(i, j) += 3e-5 * errors.normal(next++);
      out.whole.gyro.matrix(i, j) += 3e-5 * errors.normal(next++);
      out.whole.g_sensitivity(i, j) += 1e-4 * deg / g * errors.normal(next++);
    }
  }
  return out;
}

}  // namespace imulab::acceptance
