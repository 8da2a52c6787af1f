// What inspect asks and takes where names, axes and units contradict the data, or the data do not show them.
#include "imulab/error.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/join.hpp"
#include "imulab/results/inspection.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/simulated_session.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace imulab {
namespace {

constexpr double g = unit::g, deg = unit::deg;

/// The readings of a hand-held unit in SI.
const Recording& motion() {
  static const Recording cached = simulate_session({.poses = 14}, 7).recording;
  return cached;
}

/// A log of that motion in seconds, deg/s and g, with a header of one's own; `change` may change a sample's readings (gyro, accel).
template <class Change>
Inspection inspected(const std::string& head, Change change, const Declarations& declared = {}, std::size_t rows = 1'000'000, double tick = 1) {
  const Recording& r = motion();
  std::string text = head;
  for (std::size_t i = 0; i < std::min(rows, r.size()); ++i) {
    std::array<double, 6> v{};
    for (std::size_t k = 0; k < 3; ++k) v[k] = r.gyro[k][i] / deg, v[3 + k] = r.accel[k][i] / g;
    change(v);
    text += fmt::format("{:.9g},{:.7f}\n", tick * 1e-9 * static_cast<double>(r.time_ns[i]), fmt::join(v, ","));
  }
  return inspect(signals_of_text("log.csv", text), declared);
}
constexpr auto same = [](std::array<double, 6>&) {};
const std::string head = "t,gx,gy,gz,ax,ay,az\n";

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(Inspect, ExchangedAxesArePutInOrder) {
  const Inspection found = inspected(head, [](std::array<double, 6>& v) { std::swap(v[0], v[1]); });
  EXPECT_TRUE(found.complete());
  EXPECT_EQ(found.source.gyro.columns, (std::vector<Column>{"gy", "gx", "gz"}));
  EXPECT_EQ(found.source.accel.columns, (std::vector<Column>{"ax", "ay", "az"}));
}

TEST(Inspect, AReversedAxisIsAskedAboutAndDeclared) {
  const auto reverse = [](std::array<double, 6>& v) { v[2] = -v[2]; };
  EXPECT_THAT(inspected(head, reverse).ambiguous(), ElementsAre(HasSubstr("gyro.axes: gyro z has the wrong sign")));
  const Inspection declared = inspected(head, reverse, {{"gyro.axes", "+x,+y,-z"}});
  EXPECT_TRUE(declared.complete());
  ASSERT_TRUE(declared.source.gyro.axes);
  EXPECT_EQ((*declared.source.gyro.axes)[2], (BodyAxis{2, -1}));
  const Inspection turned_over = inspected(head, [](std::array<double, 6>& v) { v[3] = -v[3], v[4] = -v[4], v[5] = -v[5]; });
  EXPECT_TRUE(turned_over.complete()) << "all accelerometers reversed look like a unit that lies the other way up";
  EXPECT_THAT(turned_over.evidence(), Contains(HasSubstr("if it was the other side: --set accel.axes=-x,-y,-z")));
}

TEST(Inspect, ANameThatContradictsTheDataIsAskedAbout) {
  EXPECT_THAT(inspected("t,gx [rad/s],gy [rad/s],gz [rad/s],ax,ay,az\n", same).ambiguous(), ElementsAre(HasSubstr("gyro.unit: the file says rad/s")));
  EXPECT_THAT(inspected("t,gx,gy,gz,ax [m/s^2],ay [m/s^2],az [m/s^2]\n", same).ambiguous(),
              ElementsAre(HasSubstr("accel.unit: the file says m/s^2")));
  EXPECT_THAT(inspected("t,ax,ay,az,gx,gy,gz\n", same).ambiguous(),
              Contains(HasSubstr("the names say otherwise; if the turns are right: --set gyro.columns=ax,ay,az --set accel.columns=gx,gy,gz")));
  EXPECT_THAT(inspected("time [us],gx,gy,gz,ax,ay,az\n", same).ambiguous(), Contains(HasSubstr("time.unit: time [us] is named us")));
}

TEST(Inspect, WhatTheDataDoNotShowIsAskedAbout) {
  const std::size_t first_rest = 1000;  // of 20 s
  const Inspection still = inspected(head, same, {}, first_rest);
  EXPECT_THAT(still.ambiguous(), ElementsAre(HasSubstr("gyro.unit: fewer than three turns")));
  EXPECT_FALSE(still.methods.at(0).supported);
  EXPECT_TRUE(inspected(head, same, {{"gyro.unit", "deg/s"}}, first_rest).complete());
  EXPECT_TRUE(inspected("t,gx [dps],gy [dps],gz [dps],ax,ay,az\n", same, {}, first_rest).complete())
      << "a name counts where nothing speaks against it";
  EXPECT_THAT(inspected("", same, {}, first_rest).ambiguous(), Contains(HasSubstr("accel.columns, gyro.columns")));
  EXPECT_THAT(inspected(head, same, {}, 1'000'000, 32768).ambiguous(), Contains(HasSubstr("time.unit"))) << "ticks of a watch crystal";
  EXPECT_TRUE(inspected(head, same, {{"time.ticks_per_s", "32768"}}, 1'000'000, 32768).complete());
  EXPECT_THAT(inspected(head,
                        [](std::array<double, 6>& v) {
                          for (double& x : v) x *= 1.37;
                        })
                  .ambiguous(),
              ElementsAre(HasSubstr("accel.unit"), HasSubstr("gyro.unit")));
}

TEST(Inspect, DeclarationsAreChecked) {
  EXPECT_THAT(
      [] {
        inspected(head, same, {{"gyro.sign", "1"}});
      },
      testing::ThrowsMessage<Error>(HasSubstr("gyro.sign is not a key; expected one of rate_hz")));
  EXPECT_THAT([] { inspected(head, same, {{"gyro.unit", "furlong"}}); }, testing::ThrowsMessage<Error>(HasSubstr("is no unit of these readings")));
  EXPECT_THAT([] { inspected(head, same, {{"gyro.columns", "gx gy"}}); }, testing::ThrowsMessage<Error>(HasSubstr("2 columns; expected three")));
  EXPECT_THAT([] { inspected(head, same, {{"gyro.axes", "+x,+x,+z"}}); }, testing::ThrowsMessage<Error>(HasSubstr("three different body axes")));
  EXPECT_THAT([] { inspected(head, same, {{"accel.columns", "8,2,3"}}); }, testing::ThrowsMessage<Error>(HasSubstr("has no such column")));
}

TEST(Inspect, ARateAloneDoesNotDecideAClockOfWholeNumbers) {
  const auto text = [](const std::string& name, double ticks_per_s, bool still) {
    const Recording& r = motion();
    std::string log = name + ",gx [rad/s],gy [rad/s],gz [rad/s],ax,ay,az\n";
    for (std::size_t i = 0; i < (still ? 1000 : r.size()); ++i)
      log += fmt::format("{:.0f},{:.7f},{:.7f},{:.7f},{:.6f},{:.6f},{:.6f}\n", ticks_per_s * 1e-9 * static_cast<double>(r.time_ns[i]), r.gyro[0][i],
                         r.gyro[1][i], r.gyro[2][i], r.accel[0][i], r.accel[1][i], r.accel[2][i]);
    return inspect(signals_of_text("log.csv", log));
  };
  EXPECT_THAT(text("t", 1e6, true).ambiguous(), ElementsAre(HasSubstr("time.unit"))) << "us, or ticks of 0.1 us";
  EXPECT_TRUE(text("t", 1e6, false).complete()) << "the turns against gravity confirm it";
  EXPECT_THAT(text("t", 1e5, false).ambiguous(), Contains(HasSubstr("time.unit"))) << "10 us: the turns contradict us and ms";
  EXPECT_TRUE(text("t [us]", 1e6, true).complete());
  const Inspection xsens = text("SampleTimeFine", 1e4, true), bosch = text("sensortime", 25600, true);
  EXPECT_TRUE(xsens.complete());
  EXPECT_NEAR(xsens.rate_hz.value(), 100, 0.1);
  EXPECT_TRUE(bosch.complete());
  EXPECT_NEAR(bosch.rate_hz.value(), 100, 0.1);
}

/// Files of one triad each at rest, with the same names of columns.
std::vector<SignalTable> two_files(const std::string& gyro, const std::string& accel, const std::string& head) {
  const Recording& r = motion();
  std::array<std::string, 2> texts{head + "\n", head + "\n"};
  for (std::size_t i = 0; i < 1000; ++i)
    for (std::size_t triad = 0; triad < 2; ++triad) {
      const Columns3& v = triad == 0 ? r.gyro : r.accel;
      texts[triad] += fmt::format("{:.2f},{:.7f},{:.7f},{:.7f}\n", 0.01 * static_cast<double>(i), v[0][i], v[1][i], v[2][i]);
    }
  return {signals_of_text(gyro, texts[0]), signals_of_text(accel, texts[1])};
}

TEST(Inspect, TwoFilesWithTheSameNamesAreToldApart) {
  const Inspection named = inspect(inspection::joined(two_files("Gyroscope.csv", "Accelerometer.csv", "t,x,y,z")));
  EXPECT_THAT(named.ambiguous(), ElementsAre(HasSubstr("gyro.unit")));
  EXPECT_EQ(named.source.accel.file.value_or(named.source.file), "Accelerometer.csv");
  EXPECT_EQ(named.source.gyro.file.value_or(named.source.file), "Gyroscope.csv");
  EXPECT_TRUE(inspect(inspection::joined(two_files("a.csv", "b.csv", "t [s],x (rad/s),y (rad/s),z (rad/s)"))).ambiguous().size() > 0)
      << "both say rad/s, and one of them is not";
  const SignalTable unnamed = inspection::joined(two_files("a.csv", "b.csv", "t,x,y,z"));
  EXPECT_THAT(inspect(unnamed).ambiguous(), Contains(HasSubstr("accel.columns, gyro.columns")));
  const Inspection declared =
      inspect(unnamed, {{"gyro.columns", "a.csv:x,a.csv:y,a.csv:z"}, {"accel.columns", "b.csv:x,b.csv:y,b.csv:z"}, {"gyro.unit", "rad/s"}});
  EXPECT_TRUE(declared.complete());
  EXPECT_EQ(declared.source.accel.file.value_or(declared.source.file), "b.csv");
  EXPECT_EQ(declared.source.accel.unit, "m/s^2");
  EXPECT_THAT([&] { inspect(unnamed, {{"gyro.columns", "x,y,z"}}); }, testing::ThrowsMessage<Error>(HasSubstr("expected a.csv:x or b.csv:x")));
  EXPECT_THAT(
      [&] {
        inspect(unnamed, {{"gyro.columns", "a.csv:x,a.csv:y,a.csv:z"}, {"accel.columns", "a.csv:x,a.csv:y,a.csv:z"}});
      },
      testing::ThrowsMessage<Error>(HasSubstr("is declared as both")));
}

TEST(Inspect, RestsThatHardlyDifferAreNoUnsignedCounts) {
  std::string text = "t,ax,ay,az,gx [rad/s],gy [rad/s],gz [rad/s]\n";  // a robot whose floor tilts it by a degree, and that turns about the vertical
  for (std::size_t i = 0; i < 9000; ++i) {
    const double rest = static_cast<double>(i / 600), part = static_cast<double>(i % 600) / 600, moving = part > 0.8 ? 1 : 0;
    const double noise = 1e-3 * std::sin(static_cast<double>(i * i % 9973));
    text += fmt::format("{:.2f},{:.5f},{:.5f},{:.5f},{:.6f},{:.6f},{:.6f}\n", 0.02 * static_cast<double>(i),
                        0.2 * std::sin(rest) + 10 * noise + moving * 3 * std::sin(50 * part), 0.2 * std::cos(2.3 * rest) + 9 * noise,
                        9.88 + 11 * noise + moving * std::sin(70 * part), noise, 0.9 * noise, 1.1 * noise + moving * 0.5);
  }
  const Inspection found = inspect(signals_of_text("robot.csv", text));
  EXPECT_TRUE(found.complete()) << fmt::format("{}", fmt::join(found.ambiguous(), "; "));
  EXPECT_EQ(found.source.accel.unit, "m/s^2");
  EXPECT_THAT(found.evidence(), Contains(HasSubstr("about +z")));
}

TEST(Inspect, IntegersOfTheWrongSignAreTakenAsTheyAre) {
  const auto printed = [](bool signed_ones) {  // 16 bits about 0 without a sign, or about 2^15 with one
    const Recording& r = motion();
    std::string text = "t,ax,ay,az,gx,gy,gz\n";
    for (std::size_t i = 0; i < r.size(); ++i) {
      text += fmt::format("{:.2f}", 0.01 * static_cast<double>(i));
      for (const auto& [triad, per_si] : {std::pair{&r.accel, 700.0}, {&r.gyro, 1300.0}})
        for (const std::vector<double>& column : *triad) {
          const long count = std::lround(per_si * column[i]);
          text += fmt::format(",{}", signed_ones ? (count < 0 ? count + 32768 : count - 32768) : (count & 0xffff));
        }
      text += "\n";
    }
    return inspect(signals_of_text("counts.csv", text));
  };
  const Inspection unsigned_ones = printed(false);
  EXPECT_TRUE(unsigned_ones.complete()) << fmt::format("{}", fmt::join(unsigned_ones.ambiguous(), "; "));
  EXPECT_EQ(unsigned_ones.source.accel.integers, Integers::int16);
  EXPECT_EQ(unsigned_ones.source.gyro.integers, Integers::int16);
  EXPECT_EQ(printed(true).source.accel.integers, Integers::uint16);
  std::string still = "t,ax,ay,az\n";  // 16384 to g, -1 g along x, and never across zero
  for (int i = 0; i < 1000; ++i) still += fmt::format("{:.2f},{},{},{}\n", 0.01 * i, 49134 + i % 7, 65211 + i % 5, 250 + i % 11);
  EXPECT_EQ(inspect(signals_of_text("still.csv", still)).source.accel.integers, Integers::int16);
  EXPECT_EQ(inspected(head, same).source.accel.integers, Integers::as_written);
}

TEST(Inspect, AClockThatWrapsOnceIsNoInteger) {
  const auto found = [](double range, double begin) {
    const Recording& r = motion();
    std::string text = "t_us,gx [rad/s],gy [rad/s],gz [rad/s],ax,ay,az\n";
    for (std::size_t i = 0; i < r.size(); ++i)
      text += fmt::format("{:.0f},{:.7f},{:.7f},{:.7f},{:.6f},{:.6f},{:.6f}\n", std::fmod(begin + 1e-3 * static_cast<double>(r.time_ns[i]), range),
                          r.gyro[0][i], r.gyro[1][i], r.gyro[2][i], r.accel[0][i], r.accel[1][i], r.accel[2][i]);
    return inspect(signals_of_text("log.csv", text));
  };
  const Inspection micros = found(std::exp2(32), std::exp2(32) - 2e7), near_the_end = found(std::exp2(32), std::exp2(32) - 1e8);
  EXPECT_TRUE(micros.complete()) << fmt::format("{}", fmt::join(micros.problems(), "; "));
  EXPECT_EQ(micros.source.time.wrap_bits, 32);
  EXPECT_EQ(near_the_end.source.time.wrap_bits, 32);
}

TEST(Inspect, StampsOfBurstsAreAskedAbout) {
  std::string text = "t [s],gx [rad/s],gy [rad/s],gz [rad/s],ax,ay,az\n";  // a FIFO of 16 samples at 100 Hz, stamped as it is read
  const Recording& r = motion();
  for (std::size_t i = 0; i < 2000; ++i)
    text += fmt::format("{:.4f},{:.7f},{:.7f},{:.7f},{:.6f},{:.6f},{:.6f}\n", 0.16 * static_cast<double>(i / 16) + 1e-4 * static_cast<double>(i % 16),
                        r.gyro[0][i], r.gyro[1][i], r.gyro[2][i], r.accel[0][i], r.accel[1][i], r.accel[2][i]);
  EXPECT_THAT(inspect(signals_of_text("log.csv", text)).ambiguous(),
              Contains(testing::AllOf(HasSubstr("bursts"), HasSubstr("--time none --rate 100"))));
}

TEST(Inspect, ColumnsZYXAreTakenByTheirNames) {
  std::string text = "time,z_a,y_a,x_a,z_w,y_w,x_w\n";
  const Recording& r = motion();
  for (std::size_t i = 0; i < r.size(); ++i)
    text += fmt::format("{:.2f},{:.6f},{:.6f},{:.6f},{:.7f},{:.7f},{:.7f}\n", 0.01 * static_cast<double>(i), r.accel[2][i], r.accel[1][i],
                        r.accel[0][i], r.gyro[2][i], r.gyro[1][i], r.gyro[0][i]);
  const Inspection found = inspect(signals_of_text("log.csv", text));
  EXPECT_TRUE(found.complete()) << fmt::format("{}", fmt::join(found.ambiguous(), "; "));
  EXPECT_EQ(found.source.gyro.columns, (std::vector<Column>{"x_w", "y_w", "z_w"}));
  EXPECT_EQ(found.source.accel.columns, (std::vector<Column>{"x_a", "y_a", "z_a"}));
}

TEST(Inspect, NamesOfColumnsOpenNoRow) {
  Inspection found = inspected(head, same);
  const std::string name = "gx\nFORGED";
  for (const Severity severity : {Severity::note, Severity::warning, Severity::doubt}) found.findings.append(severity, {name});
  found.columns.push_back({name, "unused", "", ""});
  EXPECT_THAT(inspection_text(found), testing::AllOf(HasSubstr("not used: gx\\x0aFORGED"), testing::Not(HasSubstr("\nFORGED"))));
}

}  // namespace
}  // namespace imulab
