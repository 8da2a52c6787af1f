// Faults on a table or bench, and the response of the hybrid method.
#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/hybrid/hybrid.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/stop.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hybrid_session.hpp"
#include <algorithm>
#include <functional>
#include <numbers>

namespace imulab::hybrid {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

void negate(std::vector<double>& axis) {
  for (double& v : axis) v = -v;
}

void erase_samples(HybridSession& s, std::size_t begin, std::size_t count) {
  const auto cut = [&](auto& column) {
    column.erase(column.begin() + static_cast<std::ptrdiff_t>(begin), column.begin() + static_cast<std::ptrdiff_t>(begin + count));
  };
  for (std::size_t j = 0; j < 3; ++j) cut(s.recording.gyro[j]), cut(s.recording.accel[j]);
  cut(s.recording.time_ns);
  s.recording.gaps = {begin};
  s.rests = rests_of(s.recording, s.session).ranges;
}

/// Simulates a knock on the table in the middle of a rest: it vibrates, and is tilted by 20 arcsec until the next turn.
void bump(HybridSession& s) {
  Recording& r = s.recording;
  const Range rest = s.rests[8];
  const Vector3d axis = Vector3d(0.6, -0.64, 0.48), tilt = 20 * unit::arcsec * axis;
  const Matrix3d turned = rotation_exp(-tilt);
  const auto knock = static_cast<std::size_t>(std::lround(0.2 / r.interval_s)), at = rest.begin + rest.size() / 2;
  for (std::size_t i = 0; i < knock; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const auto row = static_cast<Eigen::Index>(j);
      r.accel[j][at + i] += 0.05 * axis[row] * std::cos(4 * std::numbers::pi * (static_cast<double>(i) + 0.3) / static_cast<double>(knock));
      r.gyro[j][at + i] += tilt[row] / (0.2);
      r.gyro[j][rest.end + i] -= tilt[row] / (0.2);
    }
  for (std::size_t i = at + knock; i < rest.end; ++i) {
    const Vector3d force = turned * Vector3d(r.accel[0][i], r.accel[1][i], r.accel[2][i]);
    for (std::size_t j = 0; j < 3; ++j) r.accel[j][i] = force[static_cast<Eigen::Index>(j)];
  }
}

/// Simulates a person who walks past during four rests: `amplitude` m/s^2 at 2 to 8 Hz for six seconds each.
void walk_by(HybridSession& s, double amplitude) {
  Recording& r = s.recording;
  const RandomStream draws(1, "walking by");
  for (const std::size_t k : {3u, 8u, 12u, 15u}) {
    const double frequency = 2 + 6 * draws.uniform(k), phase = 6.28 * draws.uniform(100 + k), x = std::numbers::pi * frequency * r.interval_s;
    const auto count = static_cast<std::size_t>(std::lround(6 / r.interval_s));
    for (std::size_t i = 0; i < count; ++i) {
      const double t = static_cast<double>(i) * r.interval_s, swell = std::sin(std::numbers::pi * t / 6);
      for (std::size_t j = 0; j < 3; ++j)  // mean over the interval of a sample
        r.accel[j][s.rests[k].begin + 50 + i] +=
            amplitude * swell * std::sin(x) / x * std::sin(2 * std::numbers::pi * frequency * t + phase + static_cast<double>(j));
    }
  }
}

/// Saturates the gyros at 8 deg/s in one turn.
void saturate(HybridSession& s) {
  const double limit = 8 * unit::deg;
  for (std::size_t i = s.rests[4].end; i < s.rests[5].begin; ++i)
    for (std::vector<double>& axis : s.recording.gyro)
      if (std::abs(axis[i]) > limit) {
        axis[i] = std::copysign(limit, axis[i]);
        if (s.recording.saturated.empty() || s.recording.saturated.back() != i) s.recording.saturated.push_back(i);
      }
}

HybridSession session_with(std::uint64_t seed, double rest = 12) {
  return hybrid_session(seed, [&](Session& session) { session = hybrid_procedure(rest, 50); });
}

TEST(HybridBadInput, IsSaidAndTheUncertaintiesStayTrue) {
  struct Case {
    const char* what;
    std::function<void(HybridSession&)> damage;
    const char* warning;  ///< empty: no warning expected
  };
  const std::vector<Case> cases{
      {"bump", bump, "the accelerometers' noise is"},  // the sensors measure it, so nothing must be left out
      {"a person walking by", [](HybridSession& s) { walk_by(s, 1e-3 * unit::g); }, "velocities do not fit"},
      {"a person far away", [](HybridSession& s) { walk_by(s, 5 * unit::ug); }, ""},
      {"gap in a turn", [](HybridSession& s) { erase_samples(s, s.rests[8].end + 20, 30); },
       "has a gap; it is not used, and the attitude is aligned anew"},
      {"gap in a rest", [](HybridSession& s) { erase_samples(s, s.rests[8].begin + 200, 100); }, "has a gap"},
      {"a few samples lost in a rest", [](HybridSession& s) { erase_samples(s, s.rests[8].begin + 200, 8); }, ""},
      {"saturated gyro", saturate, "has saturated samples; it is not used, and the attitude is aligned anew"},
  };
  for (const Case& c : cases) {
    HybridSession s = session_with(1);
    c.damage(s);
    const Calibration calibration = calibrated(s, base_terms()).calibration;
    EXPECT_THAT(calibration.quality.unobservable, IsEmpty()) << c.what;
    EXPECT_LT(largest_sigmas(calibration, s.truth.model), 4.5) << c.what << ": 21 coefficients, once in 7000 sessions";
    if (*c.warning) {
      EXPECT_THAT(calibration.quality.findings.warnings(), Contains(HasSubstr(c.warning))) << c.what;
    } else {
      EXPECT_THAT(calibration.quality.findings.warnings(), IsEmpty()) << c.what;
    }
  }
}

TEST(HybridBadInput, ShortRestsAreSaid) {
  const HybridSession s = session_with(3, 2);
  const Calibration c = calibrated(s, base_terms()).calibration;
  EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr("21 of 21 rests are no longer than 5 s")));
  EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5);
}

/// The gyros are a second late: each pass ends as far from the solution as the one before.
TEST(HybridBadInput, WhatFitsNothingEndsSoon) {
  const auto passes = [](const HybridSession& s, Verdict verdict) {
    int count = 0;
    const WorkScope scope({}, [&](double) { ++count; });
    EXPECT_EQ(calibrated(s).calibration.quality.verdict, verdict);
    return count;
  };
  HybridSession s = session_with(2);
  const int usual = passes(s, Verdict::good);
  for (std::vector<double>& axis : s.recording.gyro) std::rotate(axis.begin(), axis.end() - 50, axis.end());
  EXPECT_LT(passes(s, Verdict::doubtful), 3 * usual);
}

/// A velocity of 0.15 m/s occurs at the end of a second and is gone a sample later, at each of the samples of the first rest.
TEST(HybridBadInput, AKnockAcrossTheEndOfABlockIsLeftOut) {
  const HybridSession whole = session_with(2);
  for (std::size_t at = 100; at < 120; ++at) {
    HybridSession s = whole;
    s.recording.accel[0][at] += 0.15 / s.recording.interval_s;
    s.recording.accel[0][at + 1] -= 0.15 / s.recording.interval_s;
    const Quality quality = calibrated(s).calibration.quality;
    EXPECT_EQ(quality.verdict, Verdict::good) << at << ": " << testing::PrintToString(quality.findings.reasons())
                                              << testing::PrintToString(quality.findings.warnings());
  }
}

TEST(HybridBadInput, AnyLatitudeIsFoundFromAnyDeclaredOne) {
  for (const double truth : {-45.0, 0.0, 60.0, 89.5})
    for (const double declared : {-80.0, -1.0, 10.0, 45.0, 90.0}) {
      HybridSession s = hybrid_session(4, [&](Session& session) { session.site.latitude = truth * unit::deg; });
      s.session.site.latitude = declared * unit::deg;
      const Calibration c = calibrated(s).calibration;
      EXPECT_THAT(verdict_text(c.quality), HasSubstr("the latitude seems to be wrong")) << truth << ", declared " << declared;
      EXPECT_TRUE(c.quality.converged) << truth << ", declared " << declared;
      EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5) << truth << ", declared " << declared;
    }
}

TEST(HybridBadInput, AWrongLatitudeIsCorrectedFromTheEarthsRate) {
  HybridSession s = session_with(4);
  s.session.site.latitude = *s.session.site.latitude + 10 * unit::deg;
  const Calibration c = calibrated(s, base_terms()).calibration;
  EXPECT_THAT(c.quality.findings.warnings(), Contains(testing::ContainsRegex("the gyros show a latitude of 4[45]")));
  EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr("deg), not 55.000")));
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("the latitude seems to be wrong"));
  EXPECT_LT(largest_sigmas(c, s.truth.model), 4.5);
}

TEST(HybridBadInput, ALatitudeOfTheWrongSignIsNamed) {
  HybridSession s = session_with(6);
  s.session.site.latitude = -*s.session.site.latitude;  // the horizontal Earth rate is the same
  const Calibration c = calibrated(s).calibration;
  EXPECT_THAT(c.quality.findings.warnings(), Contains(testing::ContainsRegex("the gyros show a latitude of 4[45]\\.")));
  EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr("deg), not -45.000")));
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("the latitude seems to be wrong"));
}

TEST(HybridBadInput, WrongAxesAreNamed) {
  const HybridSession good = session_with(5);
  const auto message = [&](const std::function<void(Recording&)>& damage) {
    Recording recording = good.recording;
    damage(recording);
    try {
      hybrid::calibrate(input_of(good.session, recording, good.rests), base_terms());
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(message([](Recording& r) { negate(r.gyro[1]); }), HasSubstr("recording.csv: gyro y has the wrong sign"));
  EXPECT_THAT(message([](Recording& r) { negate(r.accel[2]); }), HasSubstr("accelerometer z (or the gyros x and y) has the wrong sign"));
  EXPECT_THAT(message([](Recording& r) { negate(r.accel[2]), negate(r.gyro[2]); }), HasSubstr("the triads are left-handed"));
  EXPECT_THAT(message([](Recording& r) { std::swap(r.gyro[0], r.gyro[1]); }), HasSubstr("gyro y reads about x, x reads about y"));
  EXPECT_THAT(message([](Recording& r) { std::swap(r.accel[0], r.accel[1]); }), HasSubstr("the gyros' axes are not those of the accelerometers"));
  EXPECT_EQ(message([](Recording&) {}), "no error");
}

}  // namespace
}  // namespace imulab::hybrid
