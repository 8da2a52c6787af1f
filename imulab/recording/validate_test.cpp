#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/session.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace imulab {
namespace {

Recording good_recording() {
  Recording r;
  r.name = "r";
  r.interval_s = 0.01;
  for (int i = 0; i < 40; ++i) r.time_ns.push_back(10'000'000 * (i < 20 ? i : i + 5));
  r.gaps = {20};
  r.saturated = {0, 39};
  for (Columns3* triad : {&r.gyro, &r.accel, &r.accel_temperature})
    for (auto& column : *triad) column.assign(40, 1);
  return r;
}

std::string refusal(const std::function<void(Recording&)>& change) {
  Recording r = good_recording();
  change(r);
  try {
    validate(r);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Validate, AcceptsARecording) {
  EXPECT_EQ(refusal([](Recording&) {}), "");
  EXPECT_EQ(refusal([](Recording& r) { r.gyro_unit = "rad/s", r.accel_unit = "m/s^2"; }), "");
  EXPECT_EQ(refusal([](Recording& r) { r.interval_s = 0.0101; }), "");
  EXPECT_EQ(refusal([](Recording& r) { r.time_ns[7] += 9'999'999; }), "") << "a late stamp";
}

TEST(Validate, NamesColumnSampleAndExpectation) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  const std::vector<std::pair<std::function<void(Recording&)>, std::string>> cases{
      {[](Recording& r) { r = {}, r.name = "r"; }, "r: no samples; expected at least one"},
      {[](Recording& r) { r.gyro[1].pop_back(); }, "r: gyro y: 39 samples; expected 40, one for each stamp"},
      {[](Recording& r) { r.accel[2].clear(); }, "r: accel z: 0 samples; expected 40, one for each stamp"},
      {[](Recording& r) { r.gyro_temperature[0].assign(40, 1); }, "r: gyro temperature y: 0 samples; expected 40, one for each stamp"},
      {[](Recording& r) { r.time_ns[3] = r.time_ns[2]; },
       "r: time: sample 3 is at 0.02 s, the previous one at 0.02 s; expected stamps that increase"},
      {[](Recording& r) { r.time_ns[3] = 0; }, "r: time: sample 3 is at 0 s, the previous one at 0.02 s; expected stamps that increase"},
      {[](Recording& r) { r.interval_s = 0; }, "r: the interval is 0 s; expected a positive number"},
      {[](Recording& r) { r.interval_s = nan; }, "r: the interval is nan s; expected a positive number"},
      {[](Recording& r) { r.interval_s = 0.1; },
       "r: the interval is 0.1 s, but the stamps' differences are 0.01 s (median); expected agreement within 2 %"},
      {[](Recording& r) { r.gyro[0][5] = nan; }, "r: gyro x: sample 5 at 0.05 s is nan; expected a finite number"},
      {[](Recording& r) { r.accel[1][39] = -infinite; }, "r: accel y: sample 39 at 0.44 s is -inf; expected a finite number"},
      {[](Recording& r) { r.accel_temperature[2][0] = nan; }, "r: accel temperature z: sample 0 at 0 s is nan; expected a finite number"},
      {[](Recording& r) { r.gyro_unit = "deg/s"; }, "r: gyro: the unit is \"deg/s\"; expected \"count\" or \"rad/s\""},
      {[](Recording& r) { r.accel_unit = ""; }, "r: accel: the unit is \"\"; expected \"count\" or \"m/s^2\""},
      {[](Recording& r) { r.gaps = {0}; }, "r: gaps: entry 0 is sample 0; expected ascending samples from 1 to 39"},
      {[](Recording& r) {
         r.gaps = {20, 40};
       },
       "r: gaps: entry 1 is sample 40; expected ascending samples from 1 to 39"},
      {[](Recording& r) {
         r.saturated = {5, 5};
       },
       "r: saturated: entry 1 is sample 5; expected ascending samples from 0 to 39"},
      {[](Recording& r) { r.starts = {99}; }, "r: starts: entry 0 is sample 99; expected ascending samples from 1 to 39"},
  };
  for (const auto& [change, expected] : cases) EXPECT_EQ(refusal(change), expected);
}

TEST(Validate, TheSearchForRestsAsksIt) {
  Recording r = good_recording();
  r.interval_s = 0;
  EXPECT_THROW(detect_rests(r), Error);
}

std::string refusal_of(const Session& session) {
  try {
    validate(session);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Validate, ASessionInMemoryHasTheRangesOfAFile) {
  Session good;
  good.site.latitude = 90 * unit::deg, good.site.longitude = -180 * unit::deg, good.site.height = 50;  // the ends of the ranges, in radians
  good.rigs.emplace_back().kind = RigKind::turntable;
  good.rigs[0].angle.value = 20 * unit::arcsec;
  Step hold, turn;
  hold.end = 60;
  turn.kind = StepKind::rotate, turn.start = 60, turn.end = 69, turn.angle = 1.5, turn.rate = 0.2;
  good.steps = {hold, turn};
  EXPECT_EQ(refusal_of(good), "");
  const std::vector<std::pair<std::function<void(Session&)>, std::string>> cases{
      {[](Session& s) { s.site.latitude = 45; },
       "the session: site.latitude_deg: 2578.3100780887044 is out of range; expected -90 to 90 (in memory it is in SI units and radians: 45)"},
      {[](Session& s) { s.site.latitude = std::numeric_limits<double>::quiet_NaN(); },
       "the session: site.latitude_deg: nan is not finite; expected a finite number (in memory it is in SI units and radians: nan)"},
      {[](Session& s) { s.site.given_gravity = -9.8; }, "the session: site.gravity_mps2: -9.8 is out of range; expected 9 to 10.5"},
      {[](Session& s) { s.imu.gyro_noise_density = -1e-4; }, "the session: imu.gyro_noise_density: -0.0001 is out of range; expected at least 0"},
      {[](Session& s) { s.rigs[0].angle.value = -1; },
       "the session: rig.angle_sigma_arcsec: -206264.80624709636 is out of range; expected at least 0 (in memory it is in SI units and radians: -1)"},
      {[](Session& s) { s.rigs[0].angle.value = 2; },
       "the session: rig.angle_sigma_arcsec: is beyond 45 deg; expected the error of a turntable or a hand (in memory it is in radians)"},
      {[](Session& s) { s.steps[1].end = 60; }, "the session: step 2 (rotate at 60 s): it ends at 60 s, not after its begin; expected later"},
      {[](Session& s) { s.steps[1].start = 59; },
       "the session: step 2 (rotate at 59 s): it begins before the end of the previous step; expected 60 s or later"},
      {[](Session& s) { s.steps[1].angle = 0; }, "the session: step 2 (rotate at 60 s): its angle is 0 rad; expected a turn"},
      {[](Session& s) { s.steps[1].axis = static_cast<RigAxis>(9); },
       "the session: step 2 (rotate at 60 s): its kind or axis is none; expected those of StepKind and RigAxis"},
      {[](Session& s) { s.rigs[0].kind = static_cast<RigKind>(77); },
       "the session: rig.kind: is not allowed; expected one of turntable, rate_table, centrifuge, chamber, none"},
      {[](Session& s) { s.measured = "yesterday"; },
       "the session: measured: is no time; expected UTC as in \"2026-03-31\" or \"2026-03-31T12:00:00Z\""},
      {[](Session& s) { s.vertical = static_cast<VerticalChannel>(9); },
       "the session: navigation.vertical: \"none\" is not allowed; expected one of free, fixed, aided, held"},
      {[](Session& s) { s.imu.effect_sigmas["accel.bogus"] = 1; },
       "the session: imu.effect_sigmas: \"accel.bogus\" is no effect; expected one of docs/theory/effects.md"},
      {[](Session& s) { s.imu.gyro_noise = NoiseModel{.N = -1}; }, "the session: imu.gyro_noise.N: -1 is out of range; expected at least 0"},
      {[](Session& s) { s.recordings.emplace_back().rig = "oven", s.recordings[0].file = "a.csv"; },
       "the session: recording a.csv: \"oven\" is not a rig of this session"},
      {[](Session& s) {
         s.references.assign(2, {"time", "clock 3", "K-17", "", ""});
       },
       "the session: reference 2: repeats the quantity of an earlier reference; expected each once"},
      {[](Session& s) { s.file = "session.toml", s.site.height = 1e9, s.site.given_gravity = 1; },
       "session.toml\n  site.height_m: 1000000000 is out of range; expected -12000 to 100000\n"
       "  site.gravity_mps2: 1 is out of range; expected 9 to 10.5"},
  };
  for (const auto& [change, expected] : cases) {
    Session session = good;
    change(session);
    EXPECT_EQ(refusal_of(session), expected);
  }
}

}  // namespace
}  // namespace imulab
