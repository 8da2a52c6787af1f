#include "imulab/error.hpp"
#include "imulab/recording.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <limits>

namespace imulab {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// 100 samples at 100 Hz, five of them lost after the 60th.
const std::vector<double> times = [] {
  std::vector<double> t;
  for (int i = 0; i < 100; ++i) t.push_back(5 + 0.01 * (i < 60 ? i : i + 5));
  return t;
}();

Columns3 columns(double x, double y, double z) { return {std::vector<double>(100, x), std::vector<double>(100, y), std::vector<double>(100, z)}; }

TEST(MakeRecording, TakesTheIntervalFromTheStampsAndFindsGaps) {
  const Recording r = make_recording(times, columns(1, 2, 3), columns(4, 5, 6));
  EXPECT_EQ(r.size(), 100u);
  EXPECT_EQ(r.time_ns[1], 5'010'000'000);
  EXPECT_DOUBLE_EQ(r.interval_s, 0.01);
  EXPECT_THAT(r.gaps, ElementsAre(60));
  EXPECT_THAT(r.saturated, IsEmpty());
  EXPECT_EQ(r.gyro_unit, "rad/s");
  EXPECT_EQ(r.accel_unit, "m/s^2");
  EXPECT_EQ(r.gyro, columns(1, 2, 3));
  EXPECT_EQ(r.accel, columns(4, 5, 6));
  EXPECT_THAT(r.gyro_temperature, Each(IsEmpty()));
}

TEST(MakeRecording, BringsUnitsAndIncrementsToMeansInSi) {
  RecordingOptions options{.interval_s = 0.01};
  options.gyro = {.unit = "deg", .increment = true, .temperature = {std::vector<double>(100, 20)}};
  options.accel = {.unit = "g"};
  const Recording r = make_recording(times, columns(1, 2, 3), columns(1, 0, 0), options);
  EXPECT_TRUE(r.gyro_increment);
  EXPECT_FALSE(r.accel_increment);
  EXPECT_DOUBLE_EQ(r.gyro[2][99], 300 * unit::deg);
  EXPECT_DOUBLE_EQ(r.accel[0][0], unit::g);
  EXPECT_EQ(r.gyro_temperature, columns(20, 20, 20));
  options.accel = {.unit = "count"};
  options.gyro = {.increment = true};
  const Recording counts = make_recording(times, columns(1, 2, 3), columns(1, 0, 0), options);
  EXPECT_EQ(counts.accel_unit, "count");
  EXPECT_EQ(counts.accel[0][0], 1);
  EXPECT_DOUBLE_EQ(counts.gyro[0][0], 100) << "increments without a unit are in rad";
}

TEST(MakeRecording, MarksReadingsAtTheLimits) {
  Columns3 gyro = columns(0, 0, 0), accel = columns(0, 0, 9.8);
  gyro[1][7] = -250, gyro[2][80] = 251, accel[0][7] = 20;
  const Recording r = make_recording(times, gyro, accel, {.gyro = {.unit = "deg/s", .limits = {{-250, 250}}}, .accel = {.limits = {{-30, 30}}}});
  EXPECT_THAT(r.saturated, ElementsAre(7, 80));
}

template <class Times>
concept Taken = requires(Times t, Columns3 readings) {
  make_recording(t, readings, readings);
};

TEST(MakeRecording, TimesCannotBeTakenForOthers) {
  static_assert(Taken<std::vector<double>> && Taken<Nanoseconds> && Taken<std::vector<std::chrono::milliseconds>>);
  static_assert(!Taken<std::vector<std::int64_t>> && !Taken<std::vector<int>>, "of what unit?");
  std::vector<std::chrono::milliseconds> ms;
  std::vector<std::chrono::duration<double, std::micro>> us;
  std::vector<std::int64_t> ns;
  for (int i = 0; i < 100; ++i) {
    ms.emplace_back(1'700'000'000'000 + 10 * i);  // since 1970: a double of seconds has no nanoseconds there
    us.emplace_back(1e4 * i + 0.5);
    ns.push_back(1'700'000'000'000'000'001 + 10'000'000LL * i);
  }
  const Columns3 readings = columns(1, 2, 3);
  EXPECT_EQ(make_recording(ms, readings, readings).time_ns[1], 1'700'000'000'010'000'000);
  EXPECT_DOUBLE_EQ(make_recording(ms, readings, readings).interval_s, 0.01);
  EXPECT_EQ(make_recording(us, readings, readings).time_ns[1], 10'000'500);
  EXPECT_EQ(make_recording(Nanoseconds{ns}, readings, readings).time_ns, ns);
  us[3] *= std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT([&] { make_recording(us, readings, readings); }, testing::ThrowsMessage<Error>("recording: time: sample 3 is nan; expected seconds"));
  ms[3] = std::chrono::milliseconds::max();
  EXPECT_THAT([&] { make_recording(ms, readings, readings); }, testing::ThrowsMessage<Error>(HasSubstr("time: sample 3 is 9223372036854776")));
}

std::string refusal_of_arrays(std::vector<double> t, const Columns3& gyro, const RecordingOptions& options) {
  try {
    make_recording(t, gyro, columns(0, 0, 9.8), options);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(MakeRecording, RefusesWhatIsNoRecording) {
  const Columns3 gyro = columns(0, 0, 0);
  EXPECT_EQ(refusal_of_arrays({}, gyro, {}), "recording: 0 samples; expected at least two, or the interval");
  EXPECT_EQ(refusal_of_arrays({0, 0.01}, gyro, {.name = "imu0"}), "imu0: gyro x: 100 samples; expected 2, one for each stamp");
  EXPECT_EQ(refusal_of_arrays(times, gyro, {.gyro = {.unit = "rpm"}}),
            "recording: gyro: the unit is \"rpm\"; expected one of count, rad/s, deg/s, mdeg/s, deg/min, deg/h");
  EXPECT_EQ(refusal_of_arrays(times, gyro, {.gyro = {.unit = "deg/s", .increment = true}}),
            "recording: gyro: the unit is \"deg/s\"; expected one of count, rad, deg, arcsec");
  EXPECT_EQ(refusal_of_arrays(times, gyro, {.accel = {.limits = {{4, -4}}}}),
            "recording: accel: the limits are 4 and -4; expected the lower one first");
  EXPECT_EQ(refusal_of_arrays(times, gyro, {.accel = {.temperature = {{}, {}}}}),
            "recording: accel: 2 temperature columns; expected none, one or three");
  EXPECT_THAT(refusal_of_arrays(times, gyro, {.interval_s = 0.02}), HasSubstr("the interval is 0.02 s, but the stamps' differences are 0.01 s"));
  EXPECT_THAT(refusal_of_arrays(times, gyro, {.interval_s = 0, .gyro = {.increment = true}}),
              HasSubstr("the interval is 0 s; expected a positive number"));
  const std::array<BodyAxis, 3> twice{{{0, 1}, {0, -1}, {2, 1}}}, beyond{{{0, 1}, {1, 1}, {7, 1}}};
  for (const auto& axes : {twice, beyond})
    EXPECT_THAT(refusal_of_arrays(times, gyro, {.accel = {.axes = axes}}), HasSubstr("accel: the axes are no"));
  for (const double counts : {0.0, -1.0, HUGE_VAL})
    EXPECT_THAT(refusal_of_arrays(times, gyro, {.gyro = {.counts_per_unit = counts}}), HasSubstr("counts per unit; expected more than 0"));
  std::vector<double> t = times;
  t[9] = t[8];
  EXPECT_THAT(refusal_of_arrays(t, gyro, {}), HasSubstr("time: sample 9 is at 5.08 s"));
  t[9] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal_of_arrays(t, gyro, {}), "recording: time: sample 9 is nan; expected seconds");
}

TEST(MakeRecording, IncrementsNeedAnIntervalThatIsKnown) {
  std::vector<double> t;
  for (int i = 0; i < 100; ++i) t.push_back(0.01 * i + 0.004 * (i / 3));  // 10, 10 and 14 ms
  const Columns3 gyro = columns(0, 0, 0);
  EXPECT_THAT(refusal_of_arrays(t, gyro, {.gyro = {.increment = true}}), HasSubstr("expected the interval, which scales increments"));
  EXPECT_EQ(refusal_of_arrays(t, gyro, {.interval_s = 0.01, .gyro = {.increment = true}}), "");
  EXPECT_EQ(refusal_of_arrays(t, gyro, {}), "") << "rates are not scaled by it";
}

}  // namespace
}  // namespace imulab
