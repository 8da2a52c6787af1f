// Logs whose vibration, floor, drift and stamps have known sizes: the factors follow from these sizes in closed form, without a spectrum.
#include "imulab/noise/moving.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/noise/bound.hpp"
#include "imulab/noise/noise_analysis.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace imulab {
namespace {

constexpr double T = 0.01, N_gyro = 2e-5, K_gyro = 4e-6, N_accel = 2e-4, K_accel = 4e-5, g = 9.8;
constexpr double pi = std::numbers::pi;

/// The sizes of a log's causes. A rest of `rest_s` is at both ends, in which the IMU is as quiet as in the log at rest.
struct Sizes {
  double seconds = 120, rest_s = 0;
  double floor = 1, line_hz = 31.7, line_gyro = 0, line_accel = 0;  // amplitudes
  double drift_gyro = 0, drift_accel = 0;                           // over the log
  double shift_gyro = 0, shift_accel = 0;                           // of the mean
  double stamps_s = 0, turn = 0, turn_hz = 0.2;                     // turn: amplitude of a rate about z, which is vertical
  double Q_gyro = 0;                                                // quantization
  double warming = 0;                                               // over the log
  double rate_factor = 1;
};

Recording log_of(const Sizes& s, std::uint64_t seed) {
  const auto n = static_cast<std::size_t>(s.seconds / T);
  std::vector<double> t(n), temperature(n);
  std::vector<double> draws(n), steps(n), late(n), angles(n);
  RandomStream(seed, 99).normals(0, late);
  for (std::size_t i = 0; i < n; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(n);
    t[i] = 1000 + s.rate_factor * (T * static_cast<double>(i + 1) + s.stamps_s * late[i]), temperature[i] = 25 + s.warming * share;
  }
  std::array<Columns3, 2> triads;
  for (std::size_t k = 0; k < 6; ++k) {
    const bool gyro = k < 3;
    const double N = gyro ? N_gyro : N_accel, K = gyro ? K_gyro : K_accel, line = gyro ? s.line_gyro : s.line_accel;
    RandomStream(seed, 2 * k).normals(0, draws), RandomStream(seed, 2 * k + 1).normals(0, steps);
    RandomStream(seed, 20 + k).normals(0, angles);
    double walk = 0, turned = 0;
    auto& column = triads[gyro ? 0 : 1][k % 3];
    for (std::size_t i = 0; i < n; ++i) {
      const double time = T * static_cast<double>(i), share = time / s.seconds;
      const bool at_rest = time < s.rest_s || time >= s.seconds - s.rest_s;
      walk += K * std::sqrt(T) * steps[i];
      const double before = turned;
      turned = gyro ? s.Q_gyro * angles[i] : 0;
      double value =
          walk + (turned - before) / T + (at_rest ? 1 : s.floor) * N / std::sqrt(T) * draws[i] + (gyro ? s.drift_gyro : s.drift_accel) * share;
      if (!at_rest) value += line * std::sin(2 * pi * s.line_hz * time + static_cast<double>(k)) + (gyro ? s.shift_gyro : s.shift_accel);
      if (k == 2 && !at_rest) value += s.turn * std::sin(2 * pi * s.turn_hz * (time - s.rest_s));
      column.push_back(value + (k == 5 ? g : 0));
    }
  }
  RecordingOptions options{.name = "flight.csv", .interval_s = s.rate_factor * T};
  options.gyro.temperature = {temperature};
  return make_recording(t, triads[0], triads[1], options);
}

const Session& any_session() {
  static const Session session;
  return session;
}

const NoiseAnalysis& at_rest() {
  static const NoiseAnalysis noise = [] {
    Recording quiet = log_of({.seconds = 3600}, 1);
    quiet.name = "night.csv";
    return analyze_noise(std::move(quiet), any_session());
  }();
  return noise;
}

MovingNoise moving(const Sizes& sizes, std::uint64_t seed) { return moving_noise(at_rest(), {moving_log(at_rest(), log_of(sizes, seed))}); }

const MovingCause& cause_of(const MovingAxis& axis, std::string_view name) {
  for (const MovingCause& cause : axis.causes)
    if (cause.name == name) return cause;
  throw Error("no such cause");
}

double factor_of(const MovingAxis& axis, std::string_view name) { return cause_of(axis, name).factor.value; }

/// The K of a filter whose random walk over `seconds` has the variance of the drift.
double drift_truth(double drift, double seconds, double K) { return drift / (K * std::sqrt(seconds)); }

TEST(MovingNoise, AFlightOfKnownSizes) {
  const Sizes s{.seconds = 300,
                .rest_s = 40,
                .floor = 1.3,
                .line_gyro = 3e-3,
                .line_accel = 0.03,
                .drift_gyro = 2.7e-3,
                .drift_accel = 2.7e-2,
                .stamps_s = 1e-3,
                .turn = 0.1,
                .warming = 6};
  const MovingNoise found = moving(s, 2);
  ASSERT_EQ(found.axes.size(), 6u);
  EXPECT_THAT(found.files[0], testing::HasSubstr("flight.csv: moves"));
  constexpr double allowed = 0.2;  // the log at rest determines K to 6 %, and the random walk adds 3 % to the drift
  const double line = 2 * pi * s.line_hz, moved = 2 * pi * s.turn_hz * s.turn, between_s = s.seconds - s.rest_s;
  for (std::size_t k = 0; k < 6; ++k) {
    const MovingAxis& axis = found.axes[k];
    const bool gyro = k < 3, vertical = k != 3 && k != 4;  // of the accelerometers only the force along the vertical is known between rests
    const double A = gyro ? s.line_gyro : s.line_accel, N = s.floor * (gyro ? N_gyro : N_accel);
    const double vibration = std::sqrt(1 + T * A * A / 2 / (N * N));
    const double square = 0.5 * (line * line * A * A + (k == 2 ? moved * moved : 0));  // of the derivative
    const double stamps = std::sqrt(1 + T * s.stamps_s * s.stamps_s * square / (N * N));
    const auto near = [&](const char* name, double truth) {
      EXPECT_NEAR(factor_of(axis, name) / truth, 1, allowed) << axis.name << " " << name << " " << truth;
    };
    near("white", s.floor), near("vibration", vibration), near("stamps", stamps);
    EXPECT_NEAR(*cause_of(axis, "vibration").hz, s.line_hz, 0.2);
    EXPECT_FALSE(cause_of(axis, "rectification").factor.determined);
    EXPECT_FALSE(cause_of(axis, "below 1 Hz").factor.determined);
    EXPECT_EQ(cause_of(axis, "drift").factor.determined, vertical);
    if (vertical) near("drift", drift_truth((gyro ? s.drift_gyro : s.drift_accel) * between_s / s.seconds, between_s, gyro ? K_gyro : K_accel));
    EXPECT_NEAR(axis.N.value / (N * std::sqrt(vibration * vibration + stamps * stamps - 1)), 1, allowed) << axis.name;
  }
  const std::optional<double> warming = cause_of(found.axes[0], "drift").temperature_change;
  ASSERT_TRUE(warming);
  EXPECT_NEAR(*warming, s.warming * between_s / s.seconds, 0.1);
}

TEST(MovingNoise, MotorsOnAtRest) {
  const Sizes s{.seconds = 200,
                .floor = 1.5,
                .line_gyro = 2e-4,
                .line_accel = 0.01,
                .drift_gyro = 2.7e-3,
                .drift_accel = 2.7e-2,
                .shift_gyro = 2e-3,
                .shift_accel = 0.02};
  const MovingNoise found = moving(s, 3);
  EXPECT_THAT(found.files[0], testing::HasSubstr("flight.csv: at rest"));
  for (std::size_t k = 0; k < 6; ++k) {
    const MovingAxis& axis = found.axes[k];
    const bool gyro = k < 3;
    EXPECT_NEAR(factor_of(axis, "below 1 Hz") / s.floor, 1, 0.2) << axis.name;
    EXPECT_NEAR(factor_of(axis, "drift") / drift_truth(gyro ? s.drift_gyro : s.drift_accel, 1.2 * s.seconds, gyro ? K_gyro : K_accel), 1, 0.2)
        << axis.name;
    const MovingCause& shift = cause_of(axis, "rectification");
    const double expected = (gyro ? s.shift_gyro + s.drift_gyro / 2 : s.shift_accel + s.drift_accel / 2);  // the mean includes half the drift
    EXPECT_NEAR(shift.size / expected, 1, 0.2) << axis.name;
    EXPECT_EQ(shift.factor.determined, k != 3 && k != 4) << "a tilt shifts horizontal accelerometers as well";
  }
}

/// A log like that at rest: each interval contains 1. Of 100 intervals of 95 % at least 88 do with 99.8 %.
TEST(MovingNoise, NothingIsFoundWithoutACause) {
  int inside = 0, all = 0;
  for (std::uint64_t seed = 10; seed < 14; ++seed) {
    const MovingNoise found = moving({.seconds = 100}, seed);
    for (const MovingAxis& axis : found.axes)
      for (const MovingCause& cause : axis.causes) {
        if (!cause.factor.determined) continue;
        ++all, inside += cause.factor.lower <= 1 && cause.factor.upper >= 1;
        EXPECT_LT(cause.factor.lower, 1.5) << axis.name << " " << cause.name;
      }
  }
  EXPECT_GE(inside, all * 88 / 100) << all;
}

std::string refusal_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

TEST(MovingNoise, RefusesWhatCannotBeCompared) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal_of([] { moving({.seconds = 20}, 4); }), HasSubstr("flight.csv: has 20 s without a gap; expected at least 30 s after --moving"));
  EXPECT_THAT(refusal_of([] { moving({.rate_factor = 0.5}, 4); }), HasSubstr("has 200 Hz, night.csv 100 Hz"));
  const auto with = [](Recording log) { return moving_log(at_rest(), std::move(log)); };
  Recording counts = log_of({}, 4);
  counts.gyro_unit = "count";
  EXPECT_THAT(refusal_of([&] { with(counts); }), HasSubstr("gyro.x is in count, in night.csv in rad/s; expected one unit"));
  Recording half = log_of({}, 4);
  half.accel = {};
  EXPECT_EQ(with(half).axes.size(), 3u);
  NoiseAnalysis gyros = at_rest();
  gyros.axes.erase(gyros.axes.begin(), gyros.axes.begin() + 3);
  EXPECT_THAT(refusal_of([&] { moving_log(gyros, half); }), HasSubstr("has no triad in common with night.csv"));
  Recording turned = log_of({}, 4);
  std::swap(turned.accel[0], turned.accel[2]);
  EXPECT_THAT(cause_of(with(turned).axes[0], "rectification").reason, HasSubstr("the attitude differs by 90 deg"));
  Recording blind = log_of({}, 4);
  blind.gyro = {};
  NoiseAnalysis forces = at_rest();
  forces.axes.erase(forces.axes.begin() + 3, forces.axes.begin() + 5);
  EXPECT_THAT(cause_of(moving_log(forces, blind).axes[0], "rectification").reason, HasSubstr("the attitude is unknown"));
  Recording swapped = log_of({.floor = 0.5}, 4);
  EXPECT_THAT(refusal_of([&] { with(swapped); }), HasSubstr("expected the log at rest first: imulab noise flight.csv --moving night.csv"));
}

/// The spectrum of the log with motors is known: 1.3^2 of the white noise, and the line's A^2 / 4 over the frequencies that a node stands for.
TEST(MovingNoise, RaisesTheBoundToItsSpectrum) {
  Recording quiet = log_of({.seconds = 3600}, 1);
  NoiseAnalysis rest = analyze_noise(std::move(quiet), any_session(), {.bound = BoundOptions{.horizon_s = 60}});
  const NoiseAnalysis alone = rest;
  const Sizes s{.seconds = 300, .floor = 1.3, .line_gyro = 3e-4};
  const MovingEvidence motors = moving_log(rest, log_of(s, 2));
  raise_bounds(rest, {motors});
  double nodes = 0, above = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    const NoiseBound &before = *alone.axes[k].fit->bound, &after = *rest.axes[k].fit->bound;
    const bool gyro = k < 3;
    const double white = std::pow(1.3 * (gyro ? N_gyro : N_accel), 2);
    EXPECT_TRUE(after.in_motion);
    ASSERT_EQ(after.upper.size(), before.upper.size());
    for (std::size_t i = 1; i + 1 < after.upper.size(); ++i) {
      const double hz = after.upper[i].hz, low = std::sqrt(hz * after.upper[i - 1].hz), high = std::sqrt(hz * after.upper[i + 1].hz);
      if (hz < 0.05) EXPECT_EQ(after.upper[i].density, before.upper[i].density) << "the walk is the same, and the log short";
      if (hz < 3) continue;  // a few samples' scatter
      const double line = gyro && low < s.line_hz && s.line_hz < high ? std::pow(s.line_gyro, 2) / 4 / (high - low) : 0;
      const double ratio = after.upper[i].density / (white + line);
      EXPECT_GT(ratio, 0.9) << rest.axes[k].name << " " << hz;  // at 3 Hz a density has a scatter of 7 %
      ++nodes, above += ratio > 1;
      EXPECT_LT(ratio, line > 0 ? 1.35 : 1.3) << rest.axes[k].name << " " << hz;  // 95 % of 24 degrees of freedom or more
      EXPECT_GE(noise::density(after, hz, T), 0.9999 * after.upper[i].density);
    }
    EXPECT_GT(after.coast[0].ratio, before.coast[0].ratio);
  }
  EXPECT_GT(above / nodes, 0.9) << "a confidence of 95 %, of " << nodes;
}

/// Neither a quiet log nor its quantization, which a bound leaves out, raises anything but by chance.
TEST(MovingNoise, AQuietLogRaisesNoBound) {
  NoiseAnalysis rest = analyze_noise(log_of({.seconds = 3600, .Q_gyro = 1e-5}, 1), any_session(), {.bound = BoundOptions{.horizon_s = 60}});
  const NoiseAnalysis alone = rest;
  raise_bounds(rest, {moving_log(alone, log_of({.seconds = 300, .Q_gyro = 1e-5}, 3))});
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_NEAR(rest.axes[k].fit->bound->coast[0].ratio / alone.axes[k].fit->bound->coast[0].ratio, 1, 0.1) << rest.axes[k].name;
}

}  // namespace
}  // namespace imulab
