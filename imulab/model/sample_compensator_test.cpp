#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/model/compensation_derivatives.hpp"

#include <gmock/gmock.h>

#include <array>
#include <limits>
#include <thread>
#include <vector>

namespace imulab {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

/// Returns a unit with every term except lever arms, which do not act on a single sample.
SensorModel drawn_unit() {
  SensorModel model;
  const RandomStream draws(5, "sample compensator");
  for (const CoefficientIndex k : coefficient_indices())
    if (coefficient(k).term != Term::lever_arm)
      set_coefficient(model, k, coefficient_value(model, k) + 0.1 * draws.normal(static_cast<std::uint64_t>(k)));
  model.gyro.raw_unit = "rad/s", model.accel.raw_unit = "m/s^2";
  model.gyro.temperature = ThermalReading{"raw", 5000, {4990, 5010}};
  model.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  return model;
}

constexpr SampleOptions of_drawn{.gyro_temperature_unit = "raw"};

/// Returns twelve columns of n samples: gyro, accel, and their temperatures.
std::array<std::vector<double>, 12> drawn_columns(std::size_t n) {
  std::array<std::vector<double>, 12> out;
  for (std::size_t c = 0; c < 12; ++c)
    for (std::size_t i = 0; i < n; ++i) out[c].push_back((c < 6 ? 0 : c < 9 ? 5000 : 30) + (c < 3 ? 1 : 10) * RandomStream(6, c).normal(i));
  return out;
}

Vector3d at(const std::array<std::vector<double>, 12>& columns, std::size_t first, std::size_t i) {
  return {columns[first][i], columns[first + 1][i], columns[first + 2][i]};
}

Motion sample_of(const SampleCompensator& compensator, const std::array<std::vector<double>, 12>& columns, std::size_t i) {
  return compensator(at(columns, 0, i), at(columns, 3, i), at(columns, 6, i), at(columns, 9, i));
}

TEST(SampleCompensator, GivesTheBitsOfTheColumns) {
  constexpr std::size_t n = 1000;
  const std::array<std::vector<double>, 12> columns = drawn_columns(n);
  for (const bool thermal : {true, false}) {
    SensorModel model = drawn_unit();
    if (!thermal) model.gyro.remove_temperature(), model.accel.remove_temperature();
    std::array<std::vector<double>, 6> out;
    for (auto& column : out) column.resize(n);
    RawColumns raw;
    MotionColumns motion;
    for (std::size_t a = 0; a < 3; ++a) {
      raw.gyro[a] = columns[a], raw.accel[a] = columns[3 + a], raw.gyro_temperature[a] = columns[6 + a], raw.accel_temperature[a] = columns[9 + a];
      motion.rate[a] = out[a], motion.force[a] = out[3 + a];
    }
    compensate(model, raw, motion);
    const SampleCompensator compensator(model, of_drawn);
    EXPECT_EQ(compensator.needs_temperature(), thermal);
    for (std::size_t i = 0; i < n; ++i) {
      const Motion m = sample_of(compensator, columns, i);
      for (std::size_t a = 0; a < 3; ++a) {
        ASSERT_EQ(m.rate[static_cast<Eigen::Index>(a)], out[a][i]) << i;
        ASSERT_EQ(m.force[static_cast<Eigen::Index>(a)], out[3 + a][i]) << i;
      }
      if (thermal) continue;
      const auto [rate, force] = compensator(at(columns, 0, i), at(columns, 3, i));
      ASSERT_EQ(rate, m.rate);
      ASSERT_EQ(force, m.force);
    }
  }
}

TEST(SampleCompensator, IsCalledByThreadsAtTheSameTime) {
  constexpr std::size_t n = 2000;
  const std::array<std::vector<double>, 12> columns = drawn_columns(n);
  const SampleCompensator compensator(drawn_unit(), of_drawn);
  std::array<std::vector<Motion>, 4> found;
  std::vector<std::thread> threads;
  for (std::vector<Motion>& mine : found)
    threads.emplace_back([&] {
      for (std::size_t i = 0; i < n; ++i) mine.push_back(sample_of(compensator, columns, i));
    });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < n; ++i)
    for (const std::vector<Motion>& mine : found) ASSERT_EQ(mine[i].rate, found[0][i].rate);
}

TEST(SampleCompensator, ChecksTheModelOnce) {
  SensorModel model = drawn_unit();
  EXPECT_THAT([&] { SampleCompensator{model}; },
              ThrowsMessage<Error>("the model: gyro: the temperatures are in degC; expected raw, which the calibration was made from"));
  model.lever_arm(1, 2) = 0.03;
  model.gyro.matrix(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT([&] { SampleCompensator(model, {.accel_unit = "count"}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("gyro.matrix.xy is not finite"), HasSubstr("accel: the readings are in count; expected m/s^2"),
                                         HasSubstr("lever arms"), HasSubstr("degC; expected raw"), Not(HasSubstr("gyro: the readings")))));
  model = drawn_unit();
  model.lever_arm(1, 2) = 0.03;
  SampleOptions left = of_drawn;
  left.leave_lever_arms = true;
  EXPECT_NO_THROW((SampleCompensator{model, left}));
  model.accel.temperature.reset();
  EXPECT_THAT([&] { SampleCompensator(model, left); }, ThrowsMessage<Error>(HasSubstr("accel: the model has thermal terms, but no reference")));
  model = drawn_unit();
  model.accel.thermal(0, 0) = 1;
  EXPECT_THAT([&] { SampleCompensator(model, of_drawn); }, ThrowsMessage<Error>(HasSubstr("the constant of a thermal polynomial is not 0")));
  EXPECT_THAT([&] { SampleCompensator(SensorModel{}, {.gyro_unit = "dps", .accel_temperature_unit = "celsius"}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("gyro: the readings are in \"dps\"; expected count or rad/s"),
                                         HasSubstr("accel: the temperatures are in \"celsius\"; expected degC, K or raw"))));
}

TEST(SampleCompensator, AsksForTheTemperatureOfThermalTerms) {
  SensorModel model = drawn_unit();
  const Vector3d reading(1, 2, 3);
  EXPECT_THAT([&] { SampleCompensator(model, of_drawn)(reading, reading); },
              ThrowsMessage<Error>(HasSubstr("expected the temperatures with each sample")));
  model.gyro.temperature->unit = "degC";
  const SampleCompensator compensator(model);
  EXPECT_EQ(compensator(reading, reading, 31).force, compensator(reading, reading, Vector3d::Constant(31), Vector3d::Constant(31)).force);
}

}  // namespace
}  // namespace imulab
