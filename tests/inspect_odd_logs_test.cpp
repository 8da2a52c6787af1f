// Logs that mislead: each is asked about, or right; none is understood wrongly.
#include "imulab/formats/recording/signals.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/join.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/simulated_session.hpp"
#include <array>
#include <cmath>
#include <string>

namespace imulab {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const Recording& hand_motion() {
  static const Recording cached = [] {
    HandHeldOptions options;
    options.poses = 14;
    return simulate_session(options, 11).recording;
  }();
  return cached;
}

/// Rows of a stamp, gyros and accelerometers, as counts (100 and 1000 to the SI unit) or in deg/s and g.
template <class Stamp, class Keep>
std::string odd_log(const std::string& head, bool counts, Stamp stamp, Keep keep) {
  const Recording& r = hand_motion();
  std::string text = head + "\n";
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (!keep(i)) continue;
    text += stamp(i);
    for (const auto& [triad, per_si] : {std::pair{&r.gyro, counts ? 5000.0 : 1 / unit::deg}, {&r.accel, counts ? 1700.0 : 1 / unit::g}})
      for (const auto& column : *triad) text += counts ? fmt::format(",{:.0f}", column[i] * per_si) : fmt::format(",{:.7f}", column[i] * per_si);
    text += "\n";
  }
  return text;
}
constexpr auto all = [](std::size_t) { return true; };
std::string seconds(std::size_t i) { return fmt::format("{:.2f}", 0.01 * static_cast<double>(i)); }

Inspection inspected_log(const std::string& text, const Declarations& declared = {}) { return inspect(signals_of_text("log.csv", text), declared); }

TEST(InspectOddLogs, ACounterOfSamplesIsNoClock) {
  const auto number = [](std::size_t i) { return fmt::format("{}", i); };
  const auto lost = [](std::size_t i) { return i != 500; };
  EXPECT_THAT(inspected_log(odd_log("n,gx,gy,gz,ax,ay,az", true, number, all)).ambiguous(), ElementsAre(HasSubstr("rate_hz")));
  EXPECT_THAT(inspected_log(odd_log("n,gx,gy,gz,ax,ay,az", true, number, lost)).ambiguous(), ElementsAre(HasSubstr("rate_hz"))) << "one sample lost";
  const auto many_lost = [](std::size_t i) { return i % 4 != 0; };
  EXPECT_THAT(inspected_log(odd_log("Index,gx,gy,gz,ax,ay,az", true, number, many_lost)).ambiguous(), ElementsAre(HasSubstr("rate_hz")));
  const auto wrapped = [](std::size_t i) { return fmt::format("{}", (i + 60'000) % 65'536); };
  EXPECT_THAT(inspected_log(odd_log("counter,gx,gy,gz,ax,ay,az", true, wrapped, all)).ambiguous(), Contains(HasSubstr("rate_hz")));
  const auto ticks = [](std::size_t i) { return fmt::format("{}", 400 * i); };
  const Inspection ticking = inspected_log(odd_log("ticks,gx,gy,gz,ax,ay,az", true, ticks, all));
  EXPECT_THAT(ticking.ambiguous(), ElementsAre(HasSubstr("time.ticks_per_s")));
  EXPECT_THAT(ticking.problems(), IsEmpty());
  EXPECT_EQ(ticking.source.gyro.columns.size(), 3u);
  EXPECT_THAT(inspected_log(odd_log("c,gx,gy,gz,ax,ay,az", true, ticks, all)).ambiguous(), ElementsAre(HasSubstr("time.unit")))
      << "400 could be us at 2500 Hz";
}

TEST(InspectOddLogs, ANameOfAFileIsNotThatOfTwoTriads) {
  for (const char* head : {"t,c1,c2,c3,c4,c5,c6", "t,Dreh_X,Dreh_Y,Dreh_Z,ax,ay,az"}) {
    const std::string text = odd_log(head, false, seconds, all);
    for (const char* file : {"a7.csv", "accel_run1.csv", "gyro.csv"})
      EXPECT_THAT(inspect(signals_of_text(file, text), {}).ambiguous(), IsEmpty()) << file;
  }
}

TEST(InspectOddLogs, MoreHolesThanAreLeftOutAreNamed) {
  std::string text = odd_log("t,gx,gy,gz,ax,ay,az", false, seconds, all);
  std::size_t line = 1, at = text.find('\n');
  for (; (at = text.find('\n', at + 1)) != std::string::npos; ++line)
    if (line % 50 == 7) text.replace(text.rfind(',', at) + 1, at - text.rfind(',', at) - 1, "NaN"), at = text.find('\n', at - 10);
  EXPECT_THAT(inspected_log(text).problems(),
              ElementsAre(testing::ContainsRegex("^az has no finite number in [0-9]+ of [0-9]+ rows, first in line 8: no ")));
}

TEST(InspectOddLogs, AUnitThatIsNotKnownIsAskedAbout) {
  const auto minutes = [](std::size_t i) { return fmt::format("{:.9f}", static_cast<double>(i) / 6000); };
  EXPECT_THAT(inspected_log(odd_log("t [min],gx,gy,gz,ax,ay,az", false, minutes, all)).ambiguous(),
              Contains(HasSubstr("of a unit that is not known here")));
  EXPECT_THAT(inspected_log(odd_log("t,gx [rpm],gy [rpm],gz [rpm],ax,ay,az", false, seconds, all)).ambiguous(),
              ElementsAre(HasSubstr("gyro.unit: the file says rpm, which is no unit known here")));
  std::string text = odd_log("Temps (s),gx,gy,gz,ax,ay,az,temp [°F]", false, seconds, all);
  for (std::size_t i = text.find('\n') + 1; (i = text.find('\n', i)) != std::string::npos; i += 7)
    text.insert(i, ",77.12"), text[i + 5] = "0123456789"[i % 10];
  const Inspection found = inspected_log(text);
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.columns[0].role, "time");
  EXPECT_EQ(found.columns[7].unit, "raw") << "degrees Fahrenheit are no unit of a session";
  text.replace(text.find("°F"), std::string("°F").size(), "C");
  EXPECT_EQ(inspected_log(text).columns[7].unit, "degC");
}

TEST(InspectOddLogs, LostRowsDoNotHideTheTurns) {
  const Inspection found = inspected_log(odd_log("t,gx,gy,gz,ax,ay,az", false, seconds, [](std::size_t i) { return i % 331 != 200; }));
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.gyro.unit, "deg/s");
  EXPECT_GT(found.gaps, 10u);
}

TEST(InspectOddLogs, SeveralSensorsAreAskedAbout) {
  const Recording& r = hand_motion();
  std::string text = "t,imu0_ax,imu0_ay,imu0_az,imu1_gx,imu1_gy,imu1_gz,imu1_ax,imu1_ay,imu1_az,imu0_gx,imu0_gy,imu0_gz\n";
  for (std::size_t i = 0; i < r.size(); ++i)  // imu1 is turned by a quarter about z
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", seconds(i), r.accel[0][i], r.accel[1][i], r.accel[2][i], r.gyro[1][i],
                        -r.gyro[0][i], r.gyro[2][i], r.accel[1][i], -r.accel[0][i], r.accel[2][i], r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]);
  EXPECT_THAT(inspected_log(text).ambiguous(), Contains(HasSubstr("pairs of triads fit each other")));
  const Inspection declared = inspected_log(text, {{"gyro.columns", "imu0_gx,imu0_gy,imu0_gz"}, {"accel.columns", "imu0_ax,imu0_ay,imu0_az"}});
  EXPECT_THAT(declared.ambiguous(), IsEmpty());
  EXPECT_EQ(declared.source.gyro.columns, (std::vector<Column>{"imu0_gx", "imu0_gy", "imu0_gz"}));
}

TEST(InspectOddLogs, DeclaredAccelerometersOfSeveralAreTakenWithoutGyros) {
  const Recording& r = hand_motion();
  std::string text = "t,imu0_ax,imu0_ay,imu0_az,imu1_ax,imu1_ay,imu1_az\n";
  for (std::size_t i = 0; i < r.size(); ++i)
    text +=
        fmt::format("{},{},{},{},{},{},{}\n", seconds(i), r.accel[0][i], r.accel[1][i], r.accel[2][i], r.accel[1][i], -r.accel[0][i], r.accel[2][i]);
  EXPECT_THAT(inspected_log(text).ambiguous(), Not(IsEmpty()));
  const Inspection declared = inspected_log(text, {{"accel.columns", "imu1_ax,imu1_ay,imu1_az"}});
  EXPECT_THAT(declared.ambiguous(), IsEmpty());
  EXPECT_EQ(declared.source.accel.columns, (std::vector<Column>{"imu1_ax", "imu1_ay", "imu1_az"}));
  EXPECT_TRUE(declared.source.gyro.columns.empty());
}

TEST(InspectOddLogs, RowsOutOfOrderAreAProblemAndNoWrap) {
  const auto swapped = [](std::size_t i) { return fmt::format("{}", 10'000 * (i == 700 ? 701 : i == 701 ? 700 : i)); };
  const Inspection found = inspected_log(odd_log("us,gx,gy,gz,ax,ay,az", false, swapped, all));
  EXPECT_THAT(found.problems(), ElementsAre(HasSubstr("time runs backwards 1 times, first at row 702")));
  EXPECT_FALSE(found.source.time.wrap_bits);
}

TEST(InspectOddLogs, FilesOfDifferentUnitsOfTimeAreJoined) {
  const Recording& r = hand_motion();
  std::string gyro = "t_ms,gx,gy,gz\n", accel = "t [s],ax,ay,az\n";
  for (std::size_t i = 0; i < r.size(); ++i) {
    gyro += fmt::format("{},{},{},{}\n", 5'000 + 10 * i, r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]);
    accel += fmt::format("{},{},{},{}\n", 5 + 0.01 * static_cast<double>(i), r.accel[0][i], r.accel[1][i], r.accel[2][i]);
  }
  const Inspection found = inspect(inspection::joined({signals_of_text("g.csv", gyro), signals_of_text("a.csv", accel)}));
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.time.unit, "ms");
  ASSERT_TRUE(found.source.accel.time);
  EXPECT_EQ(found.source.accel.time->unit, "s");
  EXPECT_EQ(found.source.accel.file, "a.csv");
}

TEST(InspectOddLogs, AnAxisThatNeverChangesIsStillASensorsByItsName) {
  std::string text = "t,gx [deg/s],gy [deg/s],gz [deg/s],ax [g],ay [g],az [g]\n";
  for (int i = 0; i < 3000; ++i)
    text += fmt::format("{:.2f},{:.2f},{:.2f},0.01,{:.2f},0.02,1\n", 0.01 * i, 0.01 * (i % 3), -0.01 * (i % 2), 0.01 * (i % 5 == 0));
  const Inspection found = inspected_log(text);
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.accel.columns, (std::vector<Column>{"ax [g]", "ay [g]", "az [g]"}));
  EXPECT_EQ(found.source.gyro.unit, "deg/s");
}

TEST(InspectOddLogs, AMovingLogIsNoRest) {
  std::string text = "t,gx [deg/s],gy [deg/s],gz [deg/s],ax,ay,az\n";
  for (int i = 0; i < 20'000; ++i) {  // always turning and shaken, as on a boat
    const double t = 0.01 * i, a = std::sin(0.9 * t), b = 0.7 * std::sin(1.3 * t + 1);
    text += fmt::format("{:.2f},{:.5f},{:.5f},{:.5f},{:.6f},{:.6f},{:.6f}\n", t, 50 * std::cos(0.9 * t), 52 * std::cos(1.3 * t + 1),
                        3 * std::sin(7 * t), 9.8 * std::sin(a), 9.8 * std::sin(b), 9.8 * std::cos(a) * std::cos(b));
  }
  const Inspection found = inspected_log(text);
  EXPECT_THAT(found.ambiguous(), Contains(HasSubstr("accel.unit: no rest was found")));
}

}  // namespace
}  // namespace imulab
