// Which columns, clock and offsets a log has, where more than one reading of it is possible: the physics decide, or one question is left.
#include "imulab/error.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/join.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/tasks/inspect.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/simulated_session.hpp"
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace imulab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const Recording& moved_by_hand() {
  static const Recording cached = simulate_session({.poses = 14}, 23).recording;
  return cached;
}

/// Rows of a stamp, the accelerometers in m/s^2, the gyros in rad/s, and what `more` adds.
std::string moved_log(const std::string& head, const std::function<std::string(std::size_t)>& stamp,
                      const std::function<std::string(std::size_t)>& more = {}, const std::function<bool(std::size_t)>& keep = {},
                      std::size_t rows = 1'000'000) {
  const Recording& r = moved_by_hand();
  std::string text = head + "\n";
  for (std::size_t i = 0; i < std::min(rows, r.size()); ++i) {
    if (keep && !keep(i)) continue;
    text += stamp(i);
    for (const auto* triad : {&r.accel, &r.gyro})
      for (const auto& column : *triad) text += fmt::format(",{:.7f}", column[i]);
    text += (more ? more(i) : "") + "\n";
  }
  return text;
}

std::string hundredths(std::size_t i) { return fmt::format("{:.2f}", 0.01 * static_cast<double>(i)); }
Inspection found_in(const std::string& text, const Declarations& declared = {}) { return inspect(signals_of_text("log.csv", text), declared); }
const std::string plain_head = "t,ax,ay,az,gx,gy,gz";

TEST(InspectHypotheses, AxesAreThoseOfTheNamesInBrackets) {
  const Inspection found = found_in(moved_log(
      "t,Accelerometer (z) [m/s2],Accelerometer (x) [m/s2],Accelerometer (y) [m/s2],Gyro (z) [rad/s],Gyro (x) [rad/s],Gyro (y) [rad/s]", hundredths));
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.accel.columns, (std::vector<Column>{"Accelerometer (x) [m/s2]", "Accelerometer (y) [m/s2]", "Accelerometer (z) [m/s2]"}));
  EXPECT_EQ(found.source.gyro.columns, (std::vector<Column>{"Gyro (x) [rad/s]", "Gyro (y) [rad/s]", "Gyro (z) [rad/s]"}));
}

/// ",x,y,z" of gravity's direction at that row, as a filter of a phone gives it; `rest` times the remainder.
std::string direction_at(std::size_t i, double length, double rest) {
  const Recording& r = moved_by_hand();
  const Vector3d force(r.accel[0][i], r.accel[1][i], r.accel[2][i]), gravity = length * force.normalized();
  const Vector3d other = rest * (force - gravity * (unit::g / length));
  return rest != 0 ? fmt::format(",{:.6f},{:.6f},{:.6f}", other.x(), other.y(), other.z())
                   : fmt::format(",{:.6f},{:.6f},{:.6f}", gravity.x(), gravity.y(), gravity.z());
}

TEST(InspectHypotheses, AFiltersGravityIsNoAccelerometer) {
  const Inspection beside = found_in(moved_log(plain_head + ",down1,down2,down3", hundredths, [](std::size_t i) { return direction_at(i, 1, 0); }));
  EXPECT_THAT(beside.ambiguous(), IsEmpty());
  EXPECT_EQ(beside.source.accel.columns, (std::vector<Column>{"ax", "ay", "az"}));
  const Recording& r = moved_by_hand();
  std::string alone =
      "t,gravity.x,gravity.y,gravity.z,rotationRate.x,rotationRate.y,rotationRate.z,userAcceleration.x,userAcceleration.y,"
      "userAcceleration.z\n";
  for (std::size_t i = 0; i < r.size(); ++i)
    alone += hundredths(i) + direction_at(i, 1, 0) + fmt::format(",{:.6f},{:.6f},{:.6f}", r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]) +
             direction_at(i, 1, 1 / unit::g) + "\n";
  const Inspection sum = found_in(alone);
  EXPECT_THAT(sum.ambiguous(), IsEmpty());
  EXPECT_EQ(sum.source.accel.columns,
            (std::vector<Column>{"userAcceleration.x + gravity.x", "userAcceleration.y + gravity.y", "userAcceleration.z + gravity.z"}));
  EXPECT_EQ(sum.source.accel.unit, "g");
  EXPECT_THAT(found_in(alone, {{"accel.columns", "gravity.x,gravity.y,gravity.z"}}).ambiguous(), ElementsAre(HasSubstr("have the same norm")))
      << "nor is it where it is declared";
}

TEST(InspectHypotheses, AColumnWhoseNameReadsAsASumHasItsNumber) {
  const Inspection found = found_in(moved_log("t,acc x + trim,acc y + trim,acc z + trim,gyro_x,gyro_y,gyro_z", hundredths));
  EXPECT_EQ(found.source.accel.columns, (std::vector<Column>{2, 3, 4}));
}

TEST(InspectHypotheses, AccelerometersAreNotTakenForGyrosOfLargeIncrements) {  // as which they fit the turns of a short log by chance
  HandHeldOptions options;
  options.poses = 10, options.first_rest = 4, options.rest = 2, options.move = 1, options.rate_hz = 50;
  const Recording r = simulate_session(options, 62).recording;
  std::string text = "t,a,gy,gW,,,,,,,,\n";
  for (std::size_t i = 0; i < r.size(); ++i) {
    const std::string force = fmt::format("{},{},{}", r.accel[0][i], r.accel[1][i], r.accel[2][i]);
    text += fmt::format("{0},{1},{2},{3},{3},{0},{1},{2}\n", 0.02 * static_cast<double>(i), force, r.gyro[0][i], r.gyro[1][i]);
  }
  const Inspection found = found_in(text);
  EXPECT_THAT(found.ambiguous(), testing::Not(IsEmpty()));
}

TEST(InspectHypotheses, ATriadIsOfOneSensor) {
  const Recording& r = moved_by_hand();
  const auto calibrated = [&](std::size_t i) {
    return fmt::format(",{:.7f},{:.7f},{:.7f}", r.gyro[0][i] + 0.02, r.gyro[1][i] - 0.03, r.gyro[2][i] + 0.01);
  };
  const Inspection found =
      found_in(moved_log("time,acce.x,acce.y,acce.z,gyro.x,gyro.y,gyro.z,gyro_uncalib.x,gyro_uncalib.y,gyro_uncalib.z", hundredths, calibrated));
  EXPECT_THAT(found.ambiguous(),
              ElementsAre(HasSubstr("gyro.columns: 2 pairs of triads fit each other: gyro.x, gyro.y, gyro.z or gyro_uncalib.x, gyro_uncalib.y, "
                                    "gyro_uncalib.z")));
}

TEST(InspectHypotheses, StampsThatAreEvenOnAverageGiveTheRate) {
  const auto pairs = [](std::size_t i) { return fmt::format("{:.3f}", 1.5e9 + 0.01 * static_cast<double>(i) - (i % 2 == 1 ? 0.006 : 0)); };
  const std::string text = moved_log("timestamp,ax,ay,az,gx,gy,gz", pairs, {}, {}, 3000);
  const Inspection found = found_in(text, {{"gyro.unit", "rad/s"}});
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_FALSE(found.source.time.column);
  ASSERT_TRUE(found.source.rate_hz);
  EXPECT_NEAR(*found.source.rate_hz, 100, 0.01);
  EXPECT_EQ(found.columns[0].role, "time");
  EXPECT_THAT(
      [&] {
        found_in(text, {{"rate_hz", "200"}});
      },
      testing::ThrowsMessage<Error>(HasSubstr("rate_hz = 200: the stamps of timestamp give 100 Hz on average; expected that rate")));
  EXPECT_THAT(found_in(text, {{"gyro.unit", "rad/s"}, {"rate_hz", "100.5"}}).ambiguous(), IsEmpty());
}

/// Received 0 to 7 ms late, so that most rows are 7 ms apart.
std::string received(std::size_t i) { return fmt::format("{}", 1'600'000'000'000'000'000 + 10'000'000 * i + 1'000'000 * (i * 5 % 8)); }

TEST(InspectHypotheses, OfTwoClocksTheEvenerIsTaken) {
  const auto both = [](std::size_t i) { return fmt::format("{},{}", received(i), 1'600'000'000'000'000'000 + 10'000'000 * i); };
  const Inspection found = found_in(moved_log("%time,field.header.stamp,ax,ay,az,gx,gy,gz", both));
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.time.column, Column("field.header.stamp"));
  const Inspection alone = found_in(moved_log("%time,ax,ay,az,gx,gy,gz", received));
  EXPECT_THAT(alone.ambiguous(), IsEmpty());
  EXPECT_NEAR(alone.rate_hz.value_or(0), 100, 0.1);
}

TEST(InspectHypotheses, StampsOfFewDigitsGiveTheMeanRate) {
  const auto rounded = [](std::size_t i) { return fmt::format("{:.3f}", 100 + static_cast<double>(i) / 300); };  // 3, 3 and 4 ms
  const Inspection found = found_in(moved_log(",,,,,,", rounded));
  EXPECT_NEAR(found.rate_hz.value_or(0), 300, 0.3);
}

TEST(InspectHypotheses, OneRowOutOfOrderHidesNoClockOfTwoColumns) {
  const auto split = [](std::size_t i) { return fmt::format("{},{}", 1'600'000'000 + (i == 500 ? 2 : i / 100), i % 100 * 10'000'000); };
  const Inspection found = found_in(moved_log("secs,nsecs,ax,ay,az,gx,gy,gz", split));
  EXPECT_EQ(found.source.time.column, Column("secs"));
  EXPECT_THAT(found.problems(), ElementsAre(HasSubstr("time runs backwards 1 time")));
}

TEST(InspectHypotheses, WhereRowsAreLeftOutRegularlyTheStampsStand) {
  const Inspection found = found_in(moved_log(plain_head, hundredths, {}, [](std::size_t i) { return i % 5 != 0; }));
  EXPECT_EQ(found.source.time.column, Column("t"));
}

TEST(InspectHypotheses, TurnsWithGapsDoNotCount) {
  std::size_t left = 0;
  const auto keep = [&](std::size_t i) { return i * 7919 % 331 > 2 || left++ % 5 == 4; };  // up to three rows at once
  const Inspection found = found_in(moved_log(plain_head, hundredths, {}, keep));
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.gyro.unit, "rad/s");
  const auto cut = [](std::size_t i) { return i % 700 > 4; };
  EXPECT_THAT(found_in(moved_log(plain_head, hundredths, {}, cut)).ambiguous(), IsEmpty());
}

TEST(InspectHypotheses, AnOffsetAsLargeAsGravityIsTakenOut) {
  const Recording& r = moved_by_hand();
  for (const double offset : {0.4, 1.0, 2.5}) {  // g
    std::string text = plain_head + "\n";
    for (std::size_t i = 0; i < r.size(); ++i) {
      text += hundredths(i);
      const double zeros[] = {0.01 * offset, -0.7 * offset, 0.7 * offset};
      for (std::size_t k = 0; k < 3; ++k) text += fmt::format(",{:.0f}", 2048 * (r.accel[k][i] / unit::g + zeros[k]));
      for (std::size_t k = 0; k < 3; ++k) text += fmt::format(",{:.0f}", 938.7 * r.gyro[k][i]);
      text += "\n";
    }
    const Inspection found = found_in(text);
    ASSERT_TRUE(found.triads);
    EXPECT_TRUE(found.triads->offset_taken_out) << offset;
    EXPECT_TRUE(found.triads->explained()) << offset;
    EXPECT_EQ(found.source.accel.unit, "count");
    EXPECT_NEAR(found.triads->norm, 2048, 0.03 * 2048) << "an uncalibrated scale";
  }
}

TEST(InspectHypotheses, NumbersOfColumnsAreAHeader) {
  const std::string plain = moved_log("", hundredths, {}, {}, 500).substr(1);
  for (const char* head : {"0,1,2,3,4,5,6\n", "1,2,3,4,5,6,7\n"}) EXPECT_EQ(signals_of_text("log.csv", head + plain).rows(), 500u) << head;
  EXPECT_EQ(signals_of_text("log.csv", "0,1,2,3,4,5,7\n" + plain).rows(), 501u);
}

TEST(InspectHypotheses, UnitsInBracketsOfTheirOwnAreRead) {
  const Inspection found = found_in(
      moved_log("t,ax,ay,az,gx,gy,gz\nms,m/(s^2),m/(s^2),m/(s^2),(rad/s),(rad/s),(rad/s)", [](std::size_t i) { return fmt::format("{}", 10 * i); }));
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.accel.unit, "m/s^2");
  EXPECT_EQ(found.source.gyro.unit, "rad/s");
  const Inspection still = found_in(moved_log(plain_head, hundredths, {}, {}, 1000));
  EXPECT_EQ(still.columns[4].unit, "unknown");
  EXPECT_THAT(still.columns[4].evidence, HasSubstr("fewer than three turns"));
}

TEST(InspectHypotheses, TablesWithoutStampsAreJoinedRowByRow) {
  const Recording& r = moved_by_hand();
  std::string gyro = "gx,gy,gz\n", accel = "ax,ay,az\n";
  for (std::size_t i = 0; i < r.size(); ++i) {
    gyro += fmt::format("{:.7f},{:.7f},{:.7f}\n", r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]);
    accel += fmt::format("{:.7f},{:.7f},{:.7f}\n", r.accel[0][i], r.accel[1][i], r.accel[2][i]);
  }
  const auto joined = [&](const Declarations& declared) {
    return inspect(inspection::joined({signals_of_text("a.csv", accel), signals_of_text("g.csv", gyro)}, declared), declared);
  };
  EXPECT_THAT([&] { joined({}); }, testing::ThrowsMessage<Error>(HasSubstr("joined row by row where their rate is declared: --rate HZ")));
  const Inspection found = joined({{"rate_hz", "100"}});
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.gyro.file, "g.csv");
  EXPECT_EQ(found.source.rate_hz, 100);
  gyro.resize(gyro.rfind('\n', gyro.size() - 2) + 1);
  EXPECT_THAT([&] { joined({{"rate_hz", "100"}}); }, testing::ThrowsMessage<Error>(HasSubstr("expected as many, since they are joined row by row")));
}

TEST(InspectHypotheses, ARateBesideTheColumnsIsUsed) {
  SignalTable table = signals_of_text("log.csv", moved_log(plain_head, hundredths));
  table.signals.erase(table.signals.begin());
  EXPECT_THAT(inspect(table).ambiguous(), ElementsAre(HasSubstr("rate_hz")));
  table.rate_hz = 100, table.rate_name = "fs";
  const Inspection found = inspect(table);
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.rate_hz, 100);
  EXPECT_THAT(found.evidence().front(), HasSubstr("100 Hz, as fs of the file says"));
  EXPECT_EQ(inspect(table, {{"rate_hz", "99"}}).source.rate_hz, 99) << "what is declared stands above it";
}

TEST(InspectHypotheses, TablesOfConsolesAndBetweenBarsAreRead) {
  const auto time_of_day = [](std::size_t i) { return fmt::format("10:{:02}:{:02}.{:02}", i / 6000, i / 100 % 60, i % 100); };
  std::string bars = moved_log(plain_head, hundredths), console = moved_log("10:00:00.00,ax,ay,az,gx,gy,gz", time_of_day);
  std::replace(bars.begin(), bars.end(), ',', '|');
  for (std::size_t begin = 0; begin < console.size(); begin = console.find('\n', begin) + 1) console.replace(console.find(',', begin), 1, " -> ");
  for (const std::string& text : {bars, console}) {
    const Inspection found = found_in(text);
    EXPECT_THAT(found.ambiguous(), IsEmpty()) << text.substr(0, 60);
    EXPECT_EQ(found.source.accel.columns, (std::vector<Column>{"ax", "ay", "az"}));
    EXPECT_NEAR(found.rate_hz.value_or(0), 100, 1e-6);
  }
}

TEST(InspectHypotheses, SensorsWhoseColumnsAreInCommentsAreRead) {
  const Recording& r = moved_by_hand();
  std::string text =
      "# Version: 2\n# UncalAccel,ms,AccelXMps2,AccelYMps2,AccelZMps2,BiasX\n# UncalGyro,ms,GyroXRadPerSec,GyroYRadPerSec,"
      "GyroZRadPerSec,DriftX\n#\n";
  for (std::size_t i = 0; i < r.size(); ++i)
    text += fmt::format("UncalAccel,{},{:.6f},{:.6f},{:.6f},0.0\nUncalGyro,{},{:.6f},{:.6f},{:.6f},0.0\n", 10 * i, r.accel[0][i], r.accel[1][i],
                        r.accel[2][i], 10 * i + 1, r.gyro[0][i], r.gyro[1][i], r.gyro[2][i]);
  EXPECT_EQ(signals_of_text("log.txt", text, "UncalGyro").signals[2].name, "GyroXRadPerSec");
  const TemporaryFolder folder;
  const Inspection found = inspect_files({.files = {folder.write("log.txt", text).string()}});
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_EQ(found.source.gyro.unit, "rad/s");
}

TEST(InspectHypotheses, AFormThatIsNotKnownIsShown) {
  std::string text;
  for (std::size_t i = 0; i < 40; ++i) text += fmt::format("imu<{}>{{0.1{};0.2;9.8{};0.4;0.5;0.6}}\n", hundredths(i), i, i);
  const std::vector<std::string> notes = signals_of_text("log.txt", text).notes;
  EXPECT_THAT(notes, testing::Contains("log.txt:2: imu<0.01>{0.11;0.2;9.81;0.4;0.5;0.6}"));
  EXPECT_THAT(notes.back(), HasSubstr("log.txt:3: imu<0.02>{0.12;0.2;9.82;0.4;0.5;0.6}: has numbers in a form that is not known here"));
}

TEST(InspectHypotheses, TextsOfSeveralTablesAreNamed) {
  const std::string one = moved_log(plain_head, hundredths, {}, {}, 200);
  const auto refused = [](const std::string& text) { return [text] { signals_of_text("log.csv", text); }; };
  EXPECT_THAT(refused(one + "t,mx,my,mz,qx,qy,qz\n" + one.substr(one.find('\n') + 1)),
              testing::ThrowsMessage<Error>(HasSubstr("log.csv:202: t,mx,my,mz,qx,qy,qz: begins another table")));
  EXPECT_THAT(refused("FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nIMU, 1, 2, 3\n"),
              testing::ThrowsMessage<Error>(HasSubstr("is ArduPilot's log written as text; expected the log itself (.bin)")));
  std::string merged = plain_head + "\n";
  for (int i = 0; i < 100; ++i) merged += fmt::format("{:.3f},{},1,9.8,,,\n{:.3f},,,,{},2,3\n", 0.01 * i, i % 3, 0.01 * i + 0.005, i % 5);
  EXPECT_THAT(found_in(merged).ambiguous(), ElementsAre(HasSubstr("ax and gx have no row in common")));
}

}  // namespace
}  // namespace imulab
