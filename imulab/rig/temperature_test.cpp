#include "imulab/rig/temperature.hpp"

#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/simulate.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace imulab {
namespace {

/// A chamber's set points, each from `move` before its hold on.
std::vector<Step> set_points(const std::vector<double>& temperatures, double move, double rest) {
  std::vector<Step> steps;
  for (const double temperature : temperatures) {
    Step& step = steps.emplace_back();
    step.start = steps.size() == 1 ? 0 : steps[steps.size() - 2].end + move;
    step.end = step.start + rest;
    step.temperature = temperature;
  }
  return steps;
}

RigDeclaration chamber(double ramp, double time_constant, double hysteresis) {
  RigDeclaration rig;
  rig.kind = RigKind::chamber;
  rig.ramp = ramp, rig.time_constant = time_constant, rig.hysteresis = hysteresis;
  return rig;
}

TemperatureProfile profile(const RigDeclaration& rig, const std::vector<Step>& steps) { return {machine_motion(rig, steps), &rig}; }

/// The temperatures by Euler's method in small steps: its error is of the order of the step.
std::vector<TemperatureProfile::State> stepwise(const RigDeclaration& rig, const std::vector<Step>& steps, double step) {
  const RigMotion motion = machine_motion(rig, steps);
  double air = *steps[0].temperature, unit = air, zeros = air;
  std::vector<TemperatureProfile::State> out;
  std::size_t piece = 0;
  for (double t = 0; t < motion.end(); t = step * static_cast<double>(out.size())) {
    out.push_back({unit, zeros});
    while (piece + 1 < motion.pieces.size() && t >= motion.pieces[piece].end) ++piece;
    const double way = *motion.pieces[piece].temperature - air;
    air += rig.ramp > 0 ? std::clamp(way, -rig.ramp * step, rig.ramp * step) : way;
    unit = rig.time_constant > 0 ? unit + step * (air - unit) / rig.time_constant : air;
    zeros = std::min(std::max(zeros, unit - rig.hysteresis), unit + rig.hysteresis);
  }
  return out;
}

TEST(Temperature, FollowsItsEquations) {
  const std::vector<Step> steps = set_points({20, 60, 10, 10, 35}, 300, 200);
  for (const RigDeclaration& rig : {chamber(0.1, 150, 1), chamber(0, 100, 0.5), chamber(0.05, 0, 2), chamber(0.2, 400, 0)}) {
    const TemperatureProfile exact = profile(rig, steps);
    const double step = 0.05;
    const auto numerical = stepwise(rig, steps, step);
    // The error of a step: a ramp of 0.2 K/s, or 50 K that relax in 100 s, 0.5 K/s; Euler lags by about one step of that, less than two.
    for (std::size_t k = 0; k < numerical.size(); k += 40) {
      const TemperatureProfile::State at = exact.at(step * static_cast<double>(k));
      const double jump = rig.ramp == 0 || rig.time_constant == 0 ? 2 * step * 0.5 : 2 * step * rig.ramp;
      EXPECT_NEAR(at.unit, numerical[k].unit, jump) << step * static_cast<double>(k);
      EXPECT_NEAR(at.zeros, numerical[k].zeros, jump) << step * static_cast<double>(k);
    }
  }
}

TEST(Temperature, IsTheSetPointWithoutAChamber) {
  std::vector<Step> steps = set_points({}, 0, 0);
  steps.resize(3);
  for (std::size_t k = 0; k < 3; ++k) steps[k].start = 10.0 * static_cast<double>(k) + 5, steps[k].end = steps[k].start + 5;
  steps[1].temperature = 40;
  RigDeclaration table;
  table.kind = RigKind::rate_table;
  const TemperatureProfile at(rig_motion(steps), &table);
  EXPECT_EQ(at.at(7).unit, room_temperature);
  EXPECT_EQ(at.at(12).unit, 40);  // from the gap before its step on
  EXPECT_EQ(at.at(29).zeros, 40);
  const TemperatureProfile by_hand(rig_motion(steps), nullptr);
  EXPECT_EQ(by_hand.at(7).unit, room_temperature);
  EXPECT_DOUBLE_EQ(by_hand.at(12).unit, room_temperature + 0.2 * (40 - room_temperature)) << "linear from the gap to the step's end";
  EXPECT_EQ(by_hand.at(29).zeros, 40);
}

TEST(Temperature, AfterASoakTheZerosAreBehindByTheHysteresis) {
  const TemperatureProfile up = profile(chamber(2.0 / 60, 300, 0.4), set_points({0, 35, 70, 35}, 1e5, 10));
  EXPECT_EQ(up.at(5).unit, 0);
  EXPECT_EQ(up.at(5).zeros, 0);  // nothing has changed yet
  const double tiny = 1e-11;     // rounding; a soak of 300 time constants
  EXPECT_NEAR(up.at(1e5 + 15).unit, 35, tiny);
  EXPECT_NEAR(up.at(1e5 + 15).zeros, 34.6, tiny);
  EXPECT_NEAR(up.at(3e5 + 35).zeros, 35.4, tiny);
}

ThermalSource sensors(std::vector<Column> columns, const std::string& unit, double noise = 0) {
  ThermalSource source;
  source.columns = std::move(columns), source.unit = unit, source.noise = noise;
  return source;
}

Session thermal_session(ThermalSource source) {
  Session s;
  s.imu.grade = "mems-30g";
  s.site.latitude = 0.7;
  s.rigs.push_back(chamber(0, 0, 0));
  s.steps = set_points({10, 25, 60}, 1, 1);
  s.recordings.resize(1);
  s.recordings[0].gyro_temperature = std::move(source);
  for (Step& step : s.steps) step.recording = s.recordings[0].file;
  return s;
}

TEST(Temperature, TheSameUnitReadsTheSameWhateverItsThermalReading) {
  const Session celsius = thermal_session({}), kelvin = thermal_session(sensors({"a"}, "K"));
  ThermalSource frequency = sensors({"a", "b", "c"}, "raw");
  frequency.at_25_degC = 5000, frequency.per_K = -0.15;
  const Session resonance = thermal_session(frequency);
  const auto run = [](const Session& s) { return simulate_recording(s, s.recordings[0], draw_truth(s, 4), 4); };
  const Recording r = run(celsius);
  for (const Session& other : {kelvin, resonance}) {
    const Recording o = run(other);
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t k = 0; k < r.size(); ++k) EXPECT_NEAR(r.gyro[a][k], o.gyro[a][k], 1e-12);  // rounding of 5000 Hz against 0.15 Hz/K
  }
  const Truth truth = draw_truth(resonance, 4);
  EXPECT_EQ(truth.model.gyro.temperature, (ThermalReading{"raw", 5000, {5000 - 0.15 * 45, 5000 + 0.15 * 25}}));
  EXPECT_EQ(truth.model.accel.temperature->unit, "degC");  // which has no reading
  EXPECT_NEAR(run(resonance).gyro_temperature[1].back(), 5000 - 0.15 * 35, 1e-12);
  EXPECT_EQ(run(kelvin).gyro_temperature[1].back(), 333.15);
}

TEST(Temperature, ReadingsHaveTheirOwnNoise) {
  Session s = thermal_session(sensors({"a", "b", "c"}, "degC", 0.01));
  const Truth truth = draw_truth(s, 1);
  const Recording three = simulate_recording(s, s.recordings[0], truth, 1);
  double square = 0, product = 0;
  const auto n = static_cast<double>(three.size());
  for (std::size_t k = 0; k < three.size(); ++k) {
    const double set_point = k < 100   ? 10
                             : k < 300 ? 25
                                       : 60,
                 x = three.gyro_temperature[0][k] - set_point, y = three.gyro_temperature[1][k] - set_point;
    square += x * x / n, product += x * y / n;
  }
  EXPECT_NEAR(square, 1e-4, 5 * 1e-4 * std::sqrt(2 / n));  // five sigma of a mean square, and of a mean product
  EXPECT_NEAR(product, 0, 5 * 1e-4 / std::sqrt(n));
  s.recordings[0].gyro_temperature->columns = {"a"};
  const Recording one = simulate_recording(s, s.recordings[0], truth, 1);
  EXPECT_EQ(one.gyro_temperature[0], one.gyro_temperature[2]);
  EXPECT_EQ(one.gyro_temperature[0], three.gyro_temperature[0]);
  EXPECT_EQ(one.gyro, three.gyro);  // the IMU's temperature has none of its sensor's noise
}

TEST(Temperature, WhatIsMissingIsNamed) {
  const auto message = [](const Session& s, const std::optional<SensorModel>& given = {}) -> std::string {
    try {
      simulate_recording(s, s.recordings[0], draw_truth(s, 1, given), 1);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(message(thermal_session(sensors({"a"}, "raw"))), testing::HasSubstr("expected its value at 25 degC and its change per K"));
  SensorModel raw;
  raw.gyro.temperature = ThermalReading{"raw", 5000, {}};
  EXPECT_THAT(message(thermal_session({}), raw), testing::HasSubstr("expected a thermal reading in \"raw\""));
  Session two = thermal_session({});
  two.recordings.push_back(two.recordings[0]);
  two.recordings[1].gyro_temperature->unit = "K";
  EXPECT_THAT(message(two), testing::HasSubstr("thermal readings that differ between recordings"));
}

}  // namespace
}  // namespace imulab
