#include "imulab/compensate.hpp"

#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <rapidcheck.h>

#include <limits>
#include <vector>

namespace imulab {
namespace {

using ::testing::HasSubstr;

/// A draw in [low, high].
double draw(double low, double high) { return low + (high - low) * *rc::gen::inRange(0, 1000001) / 1e6; }
double draw_sign() { return *rc::gen::element(-1.0, 1.0); }
Vector3d draw_vector(double size) { return {draw(-size, size), draw(-size, size), draw(-size, size)}; }
Matrix3d draw_matrix(double size) {
  Matrix3d m;
  for (int i = 0; i < 3; ++i) m.row(i) = draw_vector(size).transpose();
  return m;
}

/// Draws sensors over the whole range of Dai 2011 table 2: raw outputs proportional to g and deg/s, of any scale, offsets of 1 % of full scale.
SensorModel draw_model() {
  const double accel_scale = std::pow(10.0, draw(-4, 1)), gyro_scale = std::pow(10.0, draw(-6, 0));  // (m/s^2)/raw, (rad/s)/raw
  const double raw_g = unit::g / accel_scale, raw_dps = unit::deg / gyro_scale;                      // raw output of 1 g, of 1 deg/s
  SensorModel m;
  m.accel.offset = draw_vector(0.3 * unit::g);
  m.gyro.offset = draw_vector(4 * unit::deg);
  m.accel.matrix = accel_scale * (Matrix3d::Identity() + draw_matrix(0.02));
  m.gyro.matrix = gyro_scale * (Matrix3d::Identity() + draw_matrix(0.005));
  for (int i = 0; i < 3; ++i) {  // second order relative to the linear term: per g and per deg/s; third: per g^2, (deg/s)^2
    m.accel.quadratic(i) = draw_sign() * draw(2e-5, 1e-4) * accel_scale / raw_g;
    m.accel.cubic(i) = draw_sign() * draw(5e-6, 2e-5) * accel_scale / (raw_g * raw_g);
    m.gyro.quadratic(i) = draw_sign() * draw(1.5e-4, 2.5e-4) * gyro_scale / raw_dps;
    m.gyro.cubic(i) = draw_sign() * draw(4e-10, 1e-9) * gyro_scale / (raw_dps * raw_dps);
    m.accel.thermal.row(i) << 0, draw(-1e-3, 1e-3) * raw_g, draw(-1e-5, 1e-5) * raw_g, draw(-1e-7, 1e-7) * raw_g;
    m.gyro.thermal.row(i) << 0, draw(-0.05, 0.05) * raw_dps, draw(-1e-3, 1e-3) * raw_dps, draw(-1e-5, 1e-5) * raw_dps;
  }
  for (TriadModel* triad : {&m.accel, &m.gyro}) triad->matrix_thermal1 = draw_matrix(3e-4), triad->matrix_thermal2 = draw_matrix(6e-6);
  m.accel.temperature = m.gyro.temperature = ThermalReading{"degC", 25.0, {0.0, 70.0}};
  m.g_sensitivity = draw_matrix(0.04 * unit::deg / unit::g);
  return m;
}

TEST(Compensate, RoundTripHoldsOverDaisRange) {
  EXPECT_TRUE(rc::check([] {
    const SensorModel m = draw_model();
    const Motion motion{.rate = draw_vector(400 * unit::deg), .force = draw_vector(30 * unit::g)};
    const RawSample raw = decompensate(m, motion, draw_vector(45), draw_vector(45));
    const Motion back = compensate(m, raw);
    // Rounding: each sum has about ten terms of at most twice full scale.
    RC_ASSERT((back.force - motion.force).norm() <= 20 * std::numeric_limits<double>::epsilon() * 60 * unit::g);
    RC_ASSERT((back.rate - motion.rate).norm() <= 20 * std::numeric_limits<double>::epsilon() * 800 * unit::deg);
  }));
}

TEST(Compensate, InverseReturnsTheRawReadingItself) {
  EXPECT_TRUE(rc::check([] {
    const SensorModel m = draw_model();
    // Raw readings are within full scale, on the branch of the polynomial that contains zero.
    const RawSample raw{.gyro = m.gyro.matrix.inverse() * draw_vector(400 * unit::deg),
                        .accel = m.accel.matrix.inverse() * draw_vector(30 * unit::g),
                        .gyro_tau = draw_vector(45),
                        .accel_tau = draw_vector(45)};
    const RawSample back = decompensate(m, compensate(m, raw), raw.gyro_tau, raw.accel_tau);
    const double accel_scale = m.accel.matrix.norm(), gyro_scale = m.gyro.matrix.norm();
    // The bound is as above; the slope of the gyro polynomial falls to 0.8 at full scale, which increases it somewhat.
    RC_ASSERT((back.accel - raw.accel).norm() * accel_scale <= 40 * std::numeric_limits<double>::epsilon() * 60 * unit::g);
    RC_ASSERT((back.gyro - raw.gyro).norm() * gyro_scale <= 40 * std::numeric_limits<double>::epsilon() * 800 * unit::deg);
  }));
}

TEST(Compensate, TheInverseNearZeroEnds) {
  // At rest, two axes read almost zero: rounding there is finer than in the sums, and steps of the inversion do not vanish.
  EXPECT_TRUE(rc::check([] {
    const SensorModel m = draw_model();
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0}) {
        const Motion rest{.force = sign * unit::g * Vector3d::Unit(axis)};
        RC_ASSERT((compensate(m, decompensate(m, rest)).force - rest.force).norm() <= 20 * std::numeric_limits<double>::epsilon() * 2 * unit::g);
      }
  }));
}

TEST(Compensate, FollowsTheEquationsTermByTerm) {
  SensorModel m;
  m.accel.offset = {0.1, 0.2, 0.3};
  m.accel.matrix << 2, 0.5, 0, 0, 3, 0, 0.25, 0, 4;
  m.accel.quadratic = {0.01, 0, 0};
  m.accel.cubic = {0, 0.001, 0};
  m.accel.thermal.row(0) << 0, 0.5, 0.125, 0.0625;
  m.gyro.offset = {1, 0, 0};
  m.g_sensitivity << 0, 1, 0, 0, 0, 0, 0, 0, 2;
  const Motion motion = compensate(m, RawSample{.gyro = {7, 8, 9}, .accel = {5, 2, 1}, .accel_tau = {2, 0, 0}});
  // Va = (5 - 0.5 2 - 0.125 4 - 0.0625 8, 2, 1) = (3, 2, 1)
  EXPECT_DOUBLE_EQ(motion.force.x(), 0.1 + 2 * 3 + 0.5 * 2 + 0.01 * 9);
  EXPECT_DOUBLE_EQ(motion.force.y(), 0.2 + 3 * 2 + 0.001 * 8);
  EXPECT_DOUBLE_EQ(motion.force.z(), 0.3 + 0.25 * 3 + 4 * 1);
  EXPECT_DOUBLE_EQ(motion.rate.x(), 1 + 7 + 1 * motion.force.y());
  EXPECT_DOUBLE_EQ(motion.rate.y(), 8);
  EXPECT_DOUBLE_EQ(motion.rate.z(), 9 + 2 * motion.force.z());
}

TEST(Compensate, TheMatrixFollowsTheTemperatureOfEachRowsAxis) {
  SensorModel m;
  m.gyro.offset = {1, 0, 0};
  m.gyro.matrix_thermal1 << 0.5, 0, 0, 0, 0, 0.25, 0, 0, 0;
  m.gyro.matrix_thermal2 << 0, 0.125, 0, 0, 0, 0, 0, 0, 0.0625;
  m.g_sensitivity(0, 2) = 1;
  // The output without it is (8, 8, 9).
  const Motion motion = compensate(m, RawSample{.gyro = {7, 8, 9}, .accel = {0, 0, 3}, .gyro_tau = {2, 4, 8}});
  EXPECT_DOUBLE_EQ(motion.rate.x(), 8 + 2 * 0.5 * 8 + 4 * 0.125 * 8 + 3);
  EXPECT_DOUBLE_EQ(motion.rate.y(), 8 + 4 * 0.25 * 9);
  EXPECT_DOUBLE_EQ(motion.rate.z(), 9 + 64 * 0.0625 * 9);
}

TEST(Compensate, OutsideTheRangeTheThermalTermsKeepTheirValuesAtItsLimit) {
  SensorModel m;
  m.accel.thermal.col(1).setConstant(0.5);
  m.accel.temperature = ThermalReading{"degC", 20, {10, 40}};
  const SampleCompensator each(m);
  for (const auto& [temperature, tau] : {std::pair(-30.0, -10.0), {10.0, -10.0}, {25.0, 5.0}, {90.0, 20.0}}) {
    EXPECT_EQ(each({0, 0, 0}, {0, 0, 0}, temperature).force.x(), -0.5 * tau);
    std::array<double, 6> values{};
    const std::array<double, 1> read{temperature}, zero{0};
    const auto column = [&](std::size_t k) { return std::span(&values[k], 1); };
    compensate(m, {{zero, zero, zero}, {zero, zero, zero}, {}, {read, read, read}},
               {{column(0), column(1), column(2)}, {column(3), column(4), column(5)}});
    EXPECT_EQ(values[3], -0.5 * tau);
  }
  EXPECT_TRUE(std::isnan(each({0, 0, 0}, {0, 0, 0}, NAN).force.x()));
}

TEST(Compensate, PolynomialWithoutThisOutputIsAnError) {
  SensorModel m;
  m.accel.quadratic.x() = -0.1;  // V - 0.1 V^2 never exceeds 2.5
  EXPECT_NO_THROW(decompensate(m, {.force = {2.4, 0, 0}}));
  EXPECT_THROW(decompensate(m, {.force = {2.6, 0, 0}}), Error);
  m.accel.quadratic.x() = 0;
  m.gyro.matrix.row(2).setZero();
  EXPECT_THROW(decompensate(m, {.rate = {0, 0, 1}}), Error);
}

/// Six readings and six temperatures of n samples, all different.
struct Samples {
  std::array<std::vector<double>, 3> gyro, accel, gyro_temperature, accel_temperature;
  explicit Samples(std::size_t n) {
    double k = 0;
    for (auto* triad : {&gyro, &accel, &gyro_temperature, &accel_temperature})
      for (auto& column : *triad)
        for (std::size_t i = 0; i < n; ++i) column.push_back(20 * std::sin(k += 0.7));
  }
  RawColumns columns(bool temperatures) const {
    RawColumns c;
    for (std::size_t i = 0; i < 3; ++i) {
      c.gyro[i] = gyro[i];
      c.accel[i] = accel[i];
      if (temperatures) {
        c.gyro_temperature[i] = gyro_temperature[i];
        c.accel_temperature[i] = accel_temperature[i];
      }
    }
    return c;
  }
  MotionColumns in_place() {
    MotionColumns c;
    for (std::size_t i = 0; i < 3; ++i) {
      c.rate[i] = gyro[i];
      c.force[i] = accel[i];
    }
    return c;
  }
};

SensorModel linear_model() {
  SensorModel m;
  m.accel.offset = {0.1, -0.2, 0.3};
  m.accel.matrix << 1.1, 0.01, -0.02, 0.03, 0.9, 0.01, 0.02, -0.01, 1.2;
  m.gyro.offset = {0.01, 0.02, -0.03};
  m.gyro.matrix << 0.9, 0.02, 0.01, -0.03, 1.1, 0.02, 0.01, 0.02, 1.05;
  return m;
}

SensorModel full_model() {
  SensorModel m = linear_model();
  m.accel.quadratic = {1e-3, 2e-3, -1e-3};
  m.accel.cubic = {1e-5, -2e-5, 3e-5};
  m.gyro.quadratic = {-1e-3, 2e-3, 1e-3};
  m.gyro.cubic = {2e-5, 1e-5, -3e-5};
  m.accel.thermal << 0, 1e-2, 1e-4, 1e-6, 0, -2e-2, 1e-4, 0, 0, 3e-2, -1e-4, 2e-6;
  m.gyro.thermal << 0, 2e-2, -1e-4, 0, 0, 1e-2, 1e-4, -1e-6, 0, -3e-2, 2e-4, 1e-6;
  m.accel.matrix_thermal1 << 2e-4, 0, 0, 1e-5, -1e-4, 0, 2e-5, 0, 3e-4;
  m.gyro.matrix_thermal1 << 2e-4, 1e-5, -1e-5, 0, -1e-4, 3e-5, 1e-5, 0, 3e-4;
  m.gyro.matrix_thermal2 << 2e-6, 0, 1e-7, 0, -1e-6, 0, 0, 2e-7, 3e-6;
  m.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  m.gyro.temperature = ThermalReading{"raw", 5, {0, 70}};
  m.g_sensitivity << 1e-3, 2e-3, -1e-3, 3e-3, 1e-3, 2e-3, -2e-3, 1e-3, 4e-3;
  return m;
}

void expect_columns_equal_samples(const SensorModel& m, bool temperatures) {
  for (const std::size_t n : {0u, 1u, 255u, 256u, 257u, 1000u}) {  // around the block size of the implementation
    const Samples raw(n);
    Samples out(n);
    compensate(m, raw.columns(temperatures), out.in_place());
    const Samples separate = out;
    out = raw;
    compensate(m, out.columns(temperatures), out.in_place());
    EXPECT_EQ(out.gyro, separate.gyro) << "in place";
    EXPECT_EQ(out.accel, separate.accel) << "in place";
    for (std::size_t k = 0; k < n; ++k) {
      RawSample sample;
      for (int i = 0; i < 3; ++i) {
        const auto axis = static_cast<std::size_t>(i);
        sample.gyro(i) = raw.gyro[axis][k];
        sample.accel(i) = raw.accel[axis][k];
        if (temperatures) {
          sample.gyro_tau(i) = m.gyro.temperature ? m.gyro.temperature->tau(raw.gyro_temperature[axis][k]) : 0;
          sample.accel_tau(i) = m.accel.temperature ? m.accel.temperature->tau(raw.accel_temperature[axis][k]) : 0;
        }
      }
      const Motion motion = compensate(m, sample);
      for (int i = 0; i < 3; ++i) {  // the order of sums differs: rounding of terms up to 40
        EXPECT_NEAR(separate.gyro[static_cast<std::size_t>(i)][k], motion.rate(i), 1e-13);
        EXPECT_NEAR(separate.accel[static_cast<std::size_t>(i)][k], motion.force(i), 1e-13);
      }
    }
  }
}

TEST(CompensateColumns, EqualsSampleBySampleWithAllTerms) { expect_columns_equal_samples(full_model(), true); }
TEST(CompensateColumns, EqualsSampleBySampleWithLinearTerms) { expect_columns_equal_samples(linear_model(), false); }
TEST(CompensateColumns, IgnoresTemperaturesTheModelDoesNotUse) { expect_columns_equal_samples(linear_model(), true); }

TEST(CompensateColumns, MissingTemperatureIsAnError) {
  Samples samples(10);
  try {
    compensate(full_model(), samples.columns(false), samples.in_place());
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("no accelerometer temperature"));
  }
}

TEST(CompensateColumns, ColumnsOfDifferentLengthsAreAnError) {
  Samples samples(10), longer(11);
  RawColumns raw = samples.columns(false);
  raw.gyro[1] = longer.gyro[1];
  EXPECT_THROW(compensate(linear_model(), raw, samples.in_place()), Error);
}

TEST(Decompensate, ColumnsAreTheSamplesOneByOne) {
  EXPECT_TRUE(rc::check([] {
    SensorModel m = draw_model();
    if (*rc::gen::inRange(0, 2) == 0) m.accel.quadratic.setZero(), m.accel.cubic.setZero(), m.gyro.quadratic.setZero(), m.gyro.cubic.setZero();
    constexpr std::size_t n = 5;
    std::array<std::vector<double>, 6> columns;
    for (auto& c : columns)
      for (std::size_t k = 0; k < n; ++k) c.push_back(draw(-1, 1) * (&c < &columns[3] ? 30 * unit::g : 400 * unit::deg));
    std::vector<double> temperature;
    for (std::size_t k = 0; k < n; ++k) temperature.push_back(draw(0, 70));
    const auto before = columns;
    MotionColumns in_place;
    std::array<std::span<const double>, 3> readings;
    for (std::size_t a = 0; a < 3; ++a) in_place.force[a] = columns[a], in_place.rate[a] = columns[a + 3], readings[a] = temperature;
    decompensate(m, readings, readings, in_place);
    for (std::size_t k = 0; k < n; ++k) {
      const Vector3d tau = Vector3d::Constant(temperature[k] - 25);
      const RawSample raw =
          decompensate(m, {.rate = {before[3][k], before[4][k], before[5][k]}, .force = {before[0][k], before[1][k], before[2][k]}}, tau, tau);
      for (std::size_t a = 0; a < 3; ++a) {
        const auto i = static_cast<Eigen::Index>(a);
        // The order of sums differs: several rounding errors of full scale.
        RC_ASSERT(std::abs(columns[a][k] - raw.accel(i)) < 1e-14 * raw.accel.norm() + 1e-14 * 30 * unit::g / std::abs(m.accel.matrix(i, i)));
        RC_ASSERT(std::abs(columns[a + 3][k] - raw.gyro(i)) < 1e-14 * raw.gyro.norm() + 1e-14 * 400 * unit::deg / std::abs(m.gyro.matrix(i, i)));
      }
    }
  }));
}

TEST(Decompensate, MissingThermalReadingsAreNamed) {
  SensorModel m;
  m.gyro.thermal(1, 1) = 1;
  m.gyro.temperature = ThermalReading{};
  std::array<double, 2> x{};
  MotionColumns columns;
  for (std::size_t a = 0; a < 3; ++a) columns.rate[a] = columns.force[a] = x;
  EXPECT_THAT([&] { decompensate(m, {}, {}, columns); }, testing::ThrowsMessage<Error>(HasSubstr("thermal reading for each sample")));
}

}  // namespace
}  // namespace imulab
