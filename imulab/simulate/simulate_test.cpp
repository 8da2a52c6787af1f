#include "imulab/simulate.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/parallel.hpp"
#include "imulab/procedure.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace imulab {
namespace {

using unit::deg;
constexpr double rare = 1e-6;  // false-alarm probability of a statistical bound; the draws are fixed by the seed

Session resting(double seconds) {
  Session s;
  s.imu.grade = "mems";
  s.site.latitude = 40 * deg;
  Step hold;
  hold.end = seconds;
  hold.angles = {0.3, 0.4, 0.5};
  s.steps = {hold};
  return s;
}

std::vector<const std::vector<double>*> axes(const Recording& r) {
  return {&r.gyro[0], &r.gyro[1], &r.gyro[2], &r.accel[0], &r.accel[1], &r.accel[2]};
}

TEST(Simulate, StampsAreTheEndsOfTheIntervals) {
  RecordingSource source;
  source.rate_hz = 400;
  source.gyro.output = Output::increment;
  const Recording r = simulate_recording(resting(2.5), source, {}, 1);
  ASSERT_EQ(r.size(), 1000u);
  EXPECT_EQ(r.time_ns.front(), 2'500'000);
  EXPECT_EQ(r.time_ns.back(), 2'500'000'000);
  EXPECT_EQ(r.interval_s, 1.0 / 400);
  EXPECT_TRUE(r.gyro_increment);
  EXPECT_FALSE(r.accel_increment);
  for (const auto* column : axes(r)) EXPECT_EQ(column->size(), 1000u);
}

TEST(Simulate, IncrementsOfATurnSumToItsAngle) {
  Session s = resting(10);
  s.steps[0].angles = {0, 0, 0};
  Step turn;
  turn.kind = StepKind::rotate, turn.start = 10, turn.end = 190.4, turn.axis = RigAxis::outer, turn.angle = 1800 * deg, turn.rate = 10 * deg;
  s.steps.push_back(turn);
  const Recording r = simulate_recording(s, {}, {}, 1);  // the ideal IMU without noise
  double sum = 0;
  for (const double w : r.gyro[2]) sum += w * r.interval_s;
  // The body's up axis is the outer axis: the turn, and Earth's rate about it. Roundings of a sum of 19 040 terms.
  EXPECT_NEAR(sum, 1800 * deg + earth_rate * std::sin(40 * deg) * 190.4, 1e-10);
}

TEST(Simulate, NoiseIsWhiteAndAsLargeAsDeclared) {
  const Session s = resting(200);
  const Truth truth{.model = {}, .gravity = 9.8, .accel_noise = {.N = 2e-3}, .gyro_noise = {.N = 3e-4}};
  const Recording noisy = simulate_recording(s, {}, truth, 1), clean = simulate_recording(s, {}, {.model = {}, .gravity = 9.8}, 1);
  const std::size_t n = noisy.size();
  std::vector<std::vector<double>> e;
  for (std::size_t a = 0; a < 6; ++a) {
    const double sigma = (a < 3 ? truth.gyro_noise.N : truth.accel_noise.N) * std::sqrt(100.0);
    e.emplace_back(n);
    for (std::size_t k = 0; k < n; ++k) e[a][k] = ((*axes(noisy)[a])[k] - (*axes(clean)[a])[k]) / sigma;
  }
  const double bound = -normal_quantile(rare / 2) / std::sqrt(static_cast<double>(n));  // of a mean product of independent standard normals
  const auto mean_product = [&](std::size_t a, std::size_t b, std::size_t lag) {
    double sum = 0;
    for (std::size_t k = 0; k + lag < n; ++k) sum += e[a][k + lag] * e[b][k];
    return sum / static_cast<double>(n);
  };
  for (std::size_t a = 0; a < 6; ++a) {
    const double square = mean_product(a, a, 0) * static_cast<double>(n);
    EXPECT_GT(square, chi_square_quantile(rare / 2, static_cast<double>(n)));
    EXPECT_LT(square, chi_square_quantile(1 - rare / 2, static_cast<double>(n)));
    double mean = 0;
    for (const double x : e[a]) mean += x / static_cast<double>(n);
    EXPECT_LT(std::abs(mean), bound);
    for (const std::size_t lag : {1u, 2u, 3u, 100u, 4096u}) EXPECT_LT(std::abs(mean_product(a, a, lag)), bound) << lag;
    for (std::size_t b = 0; b < a; ++b) EXPECT_LT(std::abs(mean_product(a, b, 0)), bound) << a << b;
  }
}

TEST(Simulate, CompensationWithTheTruthGivesMotionAndNoiseBack) {
  Session s = hand_held_procedure({.poses = 4, .first_rest = 2, .rest = 1}, 1);
  Truth truth = draw_truth(s, 1);
  truth.model.accel.quadratic = {1e-4, -1e-4, 2e-4};
  truth.model.gyro.cubic = {1e-3, 2e-3, -1e-3};
  Truth ideal = truth;
  ideal.model = {};
  const Recording raw = simulate_recording(s, s.recordings[0], truth, 7), expected = simulate_recording(s, s.recordings[0], ideal, 7);
  for (std::size_t k = 0; k < raw.size(); ++k) {
    const Motion m = compensate(
        truth.model, {.gyro = {raw.gyro[0][k], raw.gyro[1][k], raw.gyro[2][k]}, .accel = {raw.accel[0][k], raw.accel[1][k], raw.accel[2][k]}});
    for (std::size_t a = 0; a < 3; ++a) {
      const auto i = static_cast<Eigen::Index>(a);
      EXPECT_NEAR(m.force(i), expected.accel[a][k], 1e-12);  // inversion to rounding, of 10 m/s^2
      EXPECT_NEAR(m.rate(i), expected.gyro[a][k], 1e-13);
    }
  }
}

TEST(Simulate, IsBitEqualOnAnyNumberOfThreads) {
  Session s = hand_held_procedure({.poses = 30}, 3);
  s.imu.noise = NoiseTerms::full;
  const Truth truth = draw_truth(s, 3);
  const auto on = [&](std::size_t threads) {
    const ThreadLimit limit(threads);
    return simulate_recording(s, s.recordings[0], truth, 3);
  };
  const Recording one = on(1);
  ASSERT_GT(one.size(), 3u * 4096u);  // several blocks
  for (const std::size_t threads : {2u, 5u}) {
    const Recording other = on(threads);
    EXPECT_EQ(one.time_ns, other.time_ns);
    EXPECT_EQ(one.gyro, other.gyro);
    EXPECT_EQ(one.accel, other.accel);
  }
}

TEST(Simulate, AnotherSeedOrRecordingChangesEverySample) {
  const Session s = resting(20);
  const Truth truth = draw_truth(s, 1);
  RecordingSource renamed;
  renamed.file = "other.csv";
  const Recording a = simulate_recording(s, {}, truth, 1);
  for (const Recording& b : {simulate_recording(s, {}, truth, 2), simulate_recording(s, renamed, truth, 1)})
    for (std::size_t axis = 0; axis < 6; ++axis)
      for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NE((*axes(a)[axis])[k], (*axes(b)[axis])[k]);
}

TEST(Simulate, ThermalReadingsAreTheSetPoints) {
  Session s = resting(1);
  s.steps[0].temperature = 40;
  RecordingSource source;
  source.gyro_temperature = ThermalSource{};
  Truth truth{.model = {}, .gravity = 9.8};
  truth.model.gyro.temperature = ThermalReading{.unit = "degC", .reference = 25, .range = {0, 70}};
  truth.model.gyro.thermal(2, 1) = 1e-3;
  const Recording warm = simulate_recording(s, source, truth, 1);
  EXPECT_THAT(warm.gyro_temperature[1], testing::Each(40.0));
  EXPECT_TRUE(warm.accel_temperature[0].empty());
  truth.model.gyro.thermal.setZero();
  EXPECT_NEAR(warm.gyro[2][50] - simulate_recording(s, source, truth, 1).gyro[2][50], 1e-3 * 15, 1e-15);
}

TEST(Truth, DrawsHaveTheGradesMoments) {
  const Session s = resting(1);
  const Grade& g = grade("mems");
  const std::uint64_t draws = 500;
  std::vector<double> accel_offset, gyro_offset, accel_diagonal, accel_lower, gyro_diagonal, gyro_off, g_sensitivity, gravity;
  for (std::uint64_t seed = 1; seed <= draws; ++seed) {
    const Truth t = draw_truth(s, seed);
    for (int i = 0; i < 3; ++i) {
      accel_offset.push_back(t.model.accel.offset(i) / g.accel_bias);
      gyro_offset.push_back(t.model.gyro.offset(i) / g.gyro_bias);
      for (int j = 0; j < 3; ++j) {
        const double one = i == j ? 1 : 0;
        EXPECT_TRUE(j <= i || t.model.accel.matrix(i, j) == 0);  // the accelerometers' frame
        if (j <= i)
          (i == j ? accel_diagonal : accel_lower).push_back((t.model.accel.matrix(i, j) - one) / (i == j ? g.accel_scale : g.accel_misalignment));
        (i == j ? gyro_diagonal : gyro_off).push_back((t.model.gyro.matrix(i, j) - one) / (i == j ? g.gyro_scale : g.gyro_misalignment));
        g_sensitivity.push_back(t.model.g_sensitivity(i, j) / g.g_sensitivity);
      }
    }
    gravity.push_back((t.gravity - s.site.gravity()) / s.site.gravity_sigma());
  }
  for (const auto& z : {accel_offset, gyro_offset, accel_diagonal, accel_lower, gyro_diagonal, gyro_off, g_sensitivity, gravity}) {
    const auto n = static_cast<double>(z.size());
    double sum = 0, square = 0;
    for (const double x : z) sum += x, square += x * x;
    EXPECT_LT(std::abs(sum) / std::sqrt(n), -normal_quantile(rare / 2));
    EXPECT_GT(square, chi_square_quantile(rare / 2, n));
    EXPECT_LT(square, chi_square_quantile(1 - rare / 2, n));
  }
}

TEST(Truth, DeclarationsGoBeforeTheGrade) {
  Session s = resting(1);
  s.imu.gyro_noise_density = 1e-5;
  EXPECT_EQ(draw_truth(s, 1).gyro_noise.N, 1e-5);
  EXPECT_EQ(draw_truth(s, 1).accel_noise.N, grade("mems").accel_noise.N);
  SensorModel given;
  given.gyro.offset = {1, 2, 3};
  EXPECT_EQ(draw_truth(s, 1, given).model.gyro.offset, given.gyro.offset);
}

TEST(Truth, AGradeGivesWhiteNoiseAndAllTermsWhereAsked) {
  Session s = resting(1);
  EXPECT_EQ(draw_truth(s, 1).gyro_noise, NoiseModel{.N = grade("mems").gyro_noise.N});
  s.imu.noise = NoiseTerms::full;
  EXPECT_EQ(draw_truth(s, 1).gyro_noise, grade("mems").gyro_noise);
  EXPECT_EQ(draw_truth(s, 1, SensorModel{}).gyro_noise.range, 0);  // raw readings of a given IMU need not be in SI
  EXPECT_EQ(draw_truth(s, 1, SensorModel{}).gyro_noise.B, grade("mems").gyro_noise.B);
  s.imu.gyro_noise = NoiseModel{.B = 1};
  s.imu.gyro_noise_density = 2;
  EXPECT_EQ(draw_truth(s, 1).gyro_noise, (NoiseModel{.N = 2, .B = 1}));
  EXPECT_EQ(draw_truth(s, 1).accel_noise, grade("mems").accel_noise);
}

TEST(Simulate, ReadingsAreWholeStepsInsideTheLimits) {
  const Session s = resting(20);
  Truth truth{.model = {}, .gravity = 9.8, .accel_noise = {.N = 0.05, .resolution = 0.25}, .gyro_noise = {.N = 0.05, .range = 0.8}};
  RecordingSource source;
  source.accel.unit = "m/s^2";
  source.accel.limits = {-100, 8};  // the z axis reads 7.9 in the mean
  const Recording r = simulate_recording(s, source, truth, 1);
  truth.accel_noise.resolution = truth.gyro_noise.range = 0;
  const Recording smooth = simulate_recording(s, {}, truth, 1);
  std::vector<std::size_t> at_a_limit;
  for (std::size_t k = 0; k < r.size(); ++k) {
    bool stopped = false;
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(r.accel[a][k], std::min(8.0, std::nearbyint(smooth.accel[a][k] / 0.25) * 0.25));
      EXPECT_EQ(r.gyro[a][k], std::clamp(smooth.gyro[a][k], -0.8, 0.8));
      stopped = stopped || r.accel[a][k] >= 8 || std::abs(r.gyro[a][k]) >= 0.8;
    }
    if (stopped) at_a_limit.push_back(k);
  }
  EXPECT_EQ(r.saturated, at_a_limit);
  EXPECT_GT(at_a_limit.size(), 0u);
  EXPECT_LT(at_a_limit.size(), r.size());
  source.gyro.output = source.accel.output = Output::increment;  // a limit of an increment is one of the mean over 10 ms
  source.accel.limits = {-1, 0.05};
  EXPECT_EQ(simulate_recording(s, source, {.model = {}, .gravity = 9.8}, 1).accel[2][5], 5.0);
  source.accel.unit = "g";
  EXPECT_THROW(simulate_recording(s, source, truth, 1), Error);
}

TEST(Simulate, WhatIsMissingIsNamed) {
  const auto message = [](const std::function<void()>& f) -> std::string {
    try {
      f();
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  Session s = resting(1);
  s.imu.grade.reset();
  EXPECT_THAT(message([&] { draw_truth(s, 1); }), testing::HasSubstr("expected its grade or its model"));
  EXPECT_THAT(message([&] { draw_truth(s, 1, SensorModel{}); }), testing::HasSubstr("expected the noise densities"));
  EXPECT_THAT(message([&] { simulate_recording(resting(1e-3), {}, {}, 1); }), testing::HasSubstr("less than one sample; expected at least one"));
  Session effects = resting(1);
  effects.imu.grade = "mems", effects.imu.simulated_effects = EffectSigmas{{"accel.bogus", 1e-3}};
  EXPECT_THAT(message([&] { draw_truth(effects, 1); }), testing::HasSubstr("\"accel.bogus\" is no effect"));
  effects.imu.simulated_effects = EffectSigmas{{"accel.heading", 1e-3}};
  EXPECT_THAT(message([&] { draw_truth(effects, 1); }), testing::HasSubstr("imu.effects.accel_heading_ug: is not simulated in this session"));
  const Truth wrong{.latitude = 45, .effects = {{"accel.bogus", 0, 1e-3}, {"accel.asymmetry", 9, 1e-3}}};
  EXPECT_THAT(message([&] { simulate_recording(resting(1), {}, wrong, 1); }),
              testing::AllOf(testing::HasSubstr("latitude is 45 rad"), testing::HasSubstr("is no effect"),
                             testing::HasSubstr("accel.asymmetry: column 9; expected one of the 3 that the session has")));
  const RigErrors outside{{{.kind = RigErrorKind::zero, .axis = 9}}, {0}};
  EXPECT_THAT(message([&] { simulate_recording(resting(1), {}, {}, 1, outside); }), testing::HasSubstr("of axis 9; expected less than 3"));
  s.site.latitude.reset();
  s.site.given_gravity = 9.8;
  EXPECT_THAT(message([&] { simulate_recording(s, {}, {}, 1); }), testing::HasSubstr("the site has no latitude"));
}

}  // namespace
}  // namespace imulab
