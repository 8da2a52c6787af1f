// Warm-ups and sweeps of temperature in calibrations from rests.
#include "imulab/coefficient.hpp"
#include "imulab/finding_code.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calibration_input.hpp"
#include "tests/simulated_session.hpp"
#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

/// Returns the readings of a unit whose offsets follow a logged temperature, from 5 degC up by 22 K or another range.
Recording warming(const SimulatedSession& s, const Vector3d& accel_per_K, const Vector3d& gyro_per_K, double range_K = 22) {
  Recording out = s.recording;
  for (Columns3* const triad : {&out.accel_temperature, &out.gyro_temperature})
    for (auto& column : *triad) column.resize(out.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(out.size()), degC = 5 + range_K * std::sin(1.5 * part);
    for (std::size_t j = 0; j < 3; ++j) {
      out.accel_temperature[j][i] = out.gyro_temperature[j][i] = degC;
      out.accel[j][i] += accel_per_K[static_cast<Eigen::Index>(j)] * (degC - 16),
          out.gyro[j][i] += gyro_per_K[static_cast<Eigen::Index>(j)] * (degC - 16);
    }
  }
  return out;
}

Session with_thermometers(const SimulatedSession& s) {
  Session session;
  session.imu.grade = "mems";
  session.site = s.site();
  session.recordings = {s.session.recordings.front()};
  session.recordings[0].accel_temperature = session.recordings[0].gyro_temperature = ThermalSource{.unit = "degC"};
  return session;
}

const Vector3d accel_per_K = Vector3d(8, -7, 8) * 1e-3, gyro_per_K = Vector3d(0.05, 0.05, -0.04) * unit::deg;

TEST(Sweep, OffsetsThatFollowTheThermometerAreNamed) {
  const SimulatedSession s = simulate_session(short_hand_held(), 5);
  const Recording recording = warming(s, accel_per_K, gyro_per_K, 8);
  const Calibration c = calibrate("handheld", input_of(with_thermometers(s), recording, s.rests)).calibration;
  for (const EffectEstimate& effect : c.quality.effects)
    if (effect.name == "gyro.drift" || effect.name == "gyro.offset_temperature")
      EXPECT_EQ(effect.significant, effect.name == "gyro.offset_temperature") << effect.name;
  EXPECT_FALSE(c.model.gyro.temperature) << "8 K are too few for thermal terms";
}

TEST(Sweep, TooFastForAThermometerIsDoubtful) {
  const SimulatedSession s = simulate_session(short_hand_held(), 5);
  const Calibration c = calibrate("handheld", input_of(with_thermometers(s), warming(s, accel_per_K, gyro_per_K), s.rests)).calibration;
  EXPECT_EQ(c.quality.verdict, Verdict::doubtful);
  EXPECT_TRUE(c.quality.findings.has(Code::fast_sweep));
}

TEST(Sweep, OneAttitudeDeterminesWhatFollowsTheTemperature) {
  HandHeldOptions still;
  still.poses = 1, still.first_rest = 400, still.rate_hz = 50;
  const SimulatedSession s = simulate_session(still, 6);
  const Recording exact = warming(s, accel_per_K, gyro_per_K, 40);
  for (const auto& [method, step_K] : {std::pair("static", 0.0), {"handheld", 0.0}, {"static", 1.0}, {"static", 5.0}}) {
    Recording recording = exact;
    for (Columns3* const triad : {&recording.accel_temperature, &recording.gyro_temperature})
      for (auto& column : *triad)
        for (double& degC : column) degC = step_K > 0 ? step_K * std::round(degC / step_K) : degC;
    const Calibration c = calibrate(method, input_of(with_thermometers(s), recording)).calibration;
    EXPECT_EQ(c.quality.verdict, Verdict::good) << verdict_text(c.quality);
    EXPECT_TRUE(c.quality.findings.has(Code::one_attitude));
    EXPECT_TRUE(c.model.accel.offset.isZero(1e-12) && c.model.accel.matrix.isIdentity()) << "not determined: as declared";
    int terms = 0;
    for (const CoefficientIndex index : c.estimated) {
      const Coefficient& row = coefficient(index);
      EXPECT_TRUE(row.triad == Triad::gyro || is_thermal(row.term)) << row.name;
      if (row.term != Term::thermal) continue;
      const double truth = row.column == 1 ? (row.triad == Triad::accel ? accel_per_K : gyro_per_K)[row.row] : 0;
      EXPECT_LT(std::abs(coefficient_value(c.model, index) - truth), 4 * *standard_uncertainty(c, index))
          << row.name << ", " << method << ", " << step_K;
      if (row.column < 3) ++terms;
    }
    EXPECT_EQ(terms, 12);
  }
}

/// Readings times 1 + m (T - 16): the matrix of the compensation changes by -m. Without a thermometer the same is drift, which is doubted or covered.
TEST(Sweep, ScalesThatFollowTheTemperatureAreDetermined) {
  const Vector3d accel_scale = Vector3d(300, -200, 250) * unit::ppm, gyro_scale = Vector3d(-300, 250, 200) * unit::ppm;
  HandHeldOptions slow = short_hand_held();
  slow.rest = 12;
  const SimulatedSession s = simulate_session(slow, 5);
  Recording recording = warming(s, accel_per_K, gyro_per_K, 40);
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < recording.size(); ++i) {
      const auto axis = static_cast<Eigen::Index>(j);
      const double tau = recording.accel_temperature[j][i] - 16;
      recording.accel[j][i] *= 1 + accel_scale[axis] * tau, recording.gyro[j][i] *= 1 + gyro_scale[axis] * tau;
    }
  const Calibration c = calibrate("handheld", input_of(with_thermometers(s), recording, s.rests)).calibration;
  EXPECT_EQ(c.quality.verdict, Verdict::good) << verdict_text(c.quality);
  int scales = 0;
  for (const CoefficientIndex index : c.estimated) {
    const Coefficient& row = coefficient(index);
    if (!is_matrix_thermal(row.term)) continue;
    const double m = (row.triad == Triad::accel ? accel_scale : gyro_scale)[row.row], u = *standard_uncertainty(c, index);
    const double e = c.model.accel.temperature->reference - 16, there = 1 + m * e;  // 1 / (1 + m tau) about the mean temperature
    const double truth = row.row != row.column ? 0 : row.term == Term::matrix_thermal1 ? -m / there : m * m / (there * there);
    EXPECT_LT(std::abs(coefficient_value(c.model, index) - truth), 4 * u) << row.name;
    if (row.term != Term::matrix_thermal1 || row.row != row.column) continue;
    EXPECT_LT(u, 120 * unit::ppm) << row.name << ": half of the prior";
    ++scales;
  }
  EXPECT_EQ(scales, 6);
  recording.accel_temperature = recording.gyro_temperature = {};
  Session without = with_thermometers(s);
  without.recordings[0].accel_temperature.reset(), without.recordings[0].gyro_temperature.reset();
  const Calibration blind = calibrate("handheld", input_of(without, recording, s.rests)).calibration;
  for (const CoefficientIndex index : blind.estimated)
    if (is_scale(coefficient(index)) && blind.quality.verdict == Verdict::good)
      EXPECT_LT(std::abs(coefficient_value(blind.model, index) - coefficient_value(s.truth.model, index)), 4 * *standard_uncertainty(blind, index));
}

/// Adding b (T - 16) to the readings is c1 = b, c2 = 0 in any units; scales and misalignments stay, and the offsets are those at the mean
/// temperature.
TEST(Sweep, OfTemperatureDeterminesThermalTerms) {
  HandHeldOptions slow = short_hand_held();
  slow.rest = 12;
  const SimulatedSession s = simulate_session(slow, 5);
  const Recording recording = warming(s, accel_per_K, gyro_per_K);
  for (const double gain : {1.0, 400.0}) {
    Recording readings = recording;
    Session session = with_thermometers(s);
    if (gain > 1) {
      session.recordings[0].gyro.unit = session.recordings[0].accel.unit = "count";
      readings.gyro_unit = readings.accel_unit = "count";
      for (Columns3* const triad : {&readings.gyro, &readings.accel})
        for (auto& column : *triad)
          for (double& v : column) v = 32768 + gain * v;
    }
    const Calibration c = calibrate("handheld", input_of(session, readings, s.rests)).calibration;
    EXPECT_EQ(c.quality.verdict, Verdict::good) << verdict_text(c.quality);
    ASSERT_TRUE(c.model.accel.temperature && c.model.gyro.temperature);
    const double reference = c.model.gyro.temperature->reference;
    EXPECT_NEAR(reference, 5 + 22 * (1 - std::cos(1.5)) / 1.5, 0.1) << "the mean";
    EXPECT_NEAR(c.model.gyro.temperature->range[1], 5 + 22 * std::sin(1.5), 0.2);
    int terms = 0;
    for (const CoefficientIndex index : c.estimated) {
      const Coefficient& row = coefficient(index);
      const double u = *standard_uncertainty(c, index), value = coefficient_value(c.model, index);
      const bool accel = row.triad == Triad::accel;
      double truth = coefficient_value(s.truth.model, index);
      if (row.term == Term::thermal) {
        truth = row.column == 1 ? gain * (accel ? accel_per_K : gyro_per_K)[row.row] : 0;
        if (row.column < 3) ++terms;
        EXPECT_LT(u, row.column == 1 ? 0.1 * std::abs(truth) : HUGE_VAL) << row.name;
      } else if (row.term == Term::matrix) {
        truth /= gain;
      } else if (row.term == Term::offset && gain == 1) {
        const TriadModel& model = triad_model(s.truth.model, row.triad);
        truth -= (reference - 16) * model.matrix.row(row.row).dot(accel ? accel_per_K : gyro_per_K);
      } else {
        continue;
      }
      EXPECT_LT(std::abs(value - truth), 4 * u) << row.name << ", gain " << gain;
    }
    EXPECT_EQ(terms, 12);
  }
}

}  // namespace
}  // namespace imulab
