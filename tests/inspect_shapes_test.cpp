// Logs as people have them: units, clocks, delimiters, orders of columns. Each is understood, or asked about; never understood wrongly.
#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/inspection/inspection.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/simulated_session.hpp"
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace imulab {
namespace {

struct UnitShape {
  const char* unit;
  Output output;
  double per_si;  // what one SI unit reads, of an increment a second of it
  bool whole = false;
};

constexpr double g = unit::g, deg = unit::deg;
const std::array<UnitShape, 7> accel_units{{{"m/s^2", Output::rate, 1},
                                            {"g", Output::rate, 1 / g},
                                            {"mg", Output::rate, 1e3 / g},
                                            {"count", Output::rate, 16384 / g, true},
                                            {"m/s", Output::increment, 1},
                                            {"ug", Output::rate, 1e6 / g},
                                            {"g*s", Output::increment, 1 / g}}};
const std::array<UnitShape, 8> gyro_units{{{"rad/s", Output::rate, 1},
                                           {"deg/s", Output::rate, 1 / deg},
                                           {"mdeg/s", Output::rate, 1e3 / deg},
                                           {"deg/h", Output::rate, 3600 / deg},
                                           {"count", Output::rate, 131 / deg, true},
                                           {"rad", Output::increment, 1},
                                           {"deg", Output::increment, 1 / deg},
                                           {"arcsec", Output::increment, 3600 / deg}}};
const std::array<const char*, 9> clocks{"s", "ms", "us", "ns", "unix s", "us wrapped at 16 bits", "us wrapped at 32 bits", "s and ns", "none"};
const std::array<char, 4> delimiters{',', ';', '\t', ' '};

/// One shape: everything by a number, so that the combinations are spread over all.
struct Shape {
  UnitShape accel, gyro;
  std::string clock;
  char delimiter;
  int order, header;  // columns: 0 time gyro accel, 1 time accel gyro, 2 accel gyro time, 3 interleaved; header: 0 none, 1 names, 2 names with units
  bool extras;        // a thermometer and a magnetometer
  int preamble;
};

Shape shape_of(int i) {
  return {accel_units[static_cast<std::size_t>(i) % 7],
          gyro_units[static_cast<std::size_t>(i) % 8],
          clocks[static_cast<std::size_t>(i) % 9],
          delimiters[static_cast<std::size_t>(i / 3) % 4],
          i % 4,
          (i / 2) % 3,
          i % 5 == 0,
          i % 7 == 3 ? 3 : 0};
}

std::string name_of(const Shape& s) {
  return fmt::format("accel {} gyro {} clock {} delimiter '{}' order {} header {} extras {} preamble {}", s.accel.unit, s.gyro.unit, s.clock,
                     s.delimiter, s.order, s.header, s.extras, s.preamble);
}

/// The readings of a hand-held unit in SI, and the magnetic field beside them.
struct Motion {
  Recording recording;
  std::vector<Vector3d> field;
};

const Motion& motion() {
  static const Motion cached = [] {
    HandHeldOptions options;
    options.poses = 14;
    Motion m{simulate_session(options, 7).recording, {}};
    Matrix3d C_nb = Matrix3d::Identity();
    const Vector3d field(0.2, 0.1, -0.4);  // gauss
    for (std::size_t i = 0; i < m.recording.size(); ++i) {
      C_nb *= rotation_exp(Vector3d(m.recording.interval_s * Vector3d(m.recording.gyro[0][i], m.recording.gyro[1][i], m.recording.gyro[2][i])));
      m.field.emplace_back(C_nb.transpose() * field);
    }
    return m;
  }();
  return cached;
}

double as_file(double value, const UnitShape& unit, double interval_s) {
  const double reading = value * unit.per_si * (unit.output == Output::increment ? interval_s : 1);
  return unit.whole ? std::round(reading) : reading;
}

struct Log {
  std::string text;
  std::array<int, 3> gyro{}, accel{};  // columns from 1
};

Log log_of(const Shape& shape) {
  const Recording& r = motion().recording;
  const char* axes = "xyz";
  std::vector<std::string> names;
  Log log;
  const auto add = [&](const std::string& name) {
    names.push_back(name);
    return static_cast<int>(names.size());
  };
  const bool units = shape.header == 2;
  const auto add_time = [&] {
    if (shape.clock == "s and ns") {
      add("sec"), add("nanosec");
    } else if (shape.clock != "none") {
      add(units ? "time [" + (shape.clock == "unix s" ? "s" : shape.clock.substr(0, shape.clock.find(' '))) + "]" : "time");
    }
  };
  if (shape.order != 2) add_time();
  for (std::size_t k = 0; k < 3; ++k) {
    if (shape.order == 3) log.gyro[k] = add(fmt::format("g{}{}", axes[k], units ? fmt::format(" [{}]", shape.gyro.unit) : ""));
    if (shape.order != 0) log.accel[k] = add(fmt::format("a{}{}", axes[k], units ? fmt::format(" [{}]", shape.accel.unit) : ""));
    if (shape.order == 0) log.gyro[k] = add(fmt::format("gyro_{}{}", axes[k], units ? fmt::format(" ({})", shape.gyro.unit) : ""));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    if (shape.order == 0) log.accel[k] = add(fmt::format("acc_{}{}", axes[k], units ? fmt::format(" ({})", shape.accel.unit) : ""));
    if (shape.order == 1 || shape.order == 2) log.gyro[k] = add(fmt::format("w{}{}", axes[k], units ? fmt::format(" [{}]", shape.gyro.unit) : ""));
  }
  if (shape.extras) add("temp"), add("mx"), add("my"), add("mz");
  if (shape.order == 2) add_time();
  for (int i = 0; i < shape.preamble; ++i) log.text += i == 0 ? "Logger 5, firmware 1.2\n" : "range 16 g\n";
  const std::string delimiter(1, shape.delimiter);
  if (shape.header > 0) {
    std::vector<std::string> head = names;
    if (shape.delimiter == ' ')
      for (std::string& name : head) std::erase(name, ' ');
    log.text += fmt::format("{}\n", fmt::join(head, delimiter));
  }
  for (std::size_t i = 0; i < r.size(); ++i) {
    std::vector<std::string> fields(names.size());
    for (std::size_t k = 0; k < 3; ++k) {
      fields[static_cast<std::size_t>(log.gyro[k] - 1)] = fmt::format("{:.9g}", as_file(r.gyro[k][i], shape.gyro, r.interval_s));
      fields[static_cast<std::size_t>(log.accel[k] - 1)] = fmt::format("{:.9g}", as_file(r.accel[k][i], shape.accel, r.interval_s));
    }
    const std::int64_t ns = r.time_ns[i];
    std::vector<std::string> time;
    if (shape.clock == "s") time = {fmt::format("{:.4f}", 1e-9 * static_cast<double>(ns))};
    if (shape.clock == "ms") time = {fmt::format("{}", ns / 1'000'000)};
    if (shape.clock == "us") time = {fmt::format("{}", ns / 1000)};
    if (shape.clock == "ns") time = {fmt::format("{}", ns)};
    if (shape.clock == "unix s") time = {fmt::format("{:.6f}", 1.7e9 + 1e-9 * static_cast<double>(ns))};
    if (shape.clock == "us wrapped at 16 bits") time = {fmt::format("{}", ns / 1000 % 65536)};
    if (shape.clock == "us wrapped at 32 bits") time = {fmt::format("{}", (ns / 1000 + 4'294'000'000) % 4'294'967'296)};
    if (shape.clock == "s and ns") time = {fmt::format("{}", 1'700'000'000 + ns / 1'000'000'000), fmt::format("{}", ns % 1'000'000'000)};
    std::size_t place = shape.order == 2 ? names.size() - time.size() : 0;
    for (const std::string& field : time) fields[place++] = field;
    if (shape.extras) {
      const std::size_t begin = names.size() - 4 - (shape.order == 2 ? time.size() : 0);
      fields[begin] = fmt::format("{:.2f}", 25 + 1e-4 * static_cast<double>(i));
      for (Eigen::Index k = 0; k < 3; ++k) fields[begin + 1 + static_cast<std::size_t>(k)] = fmt::format("{:.4f}", motion().field[i][k]);
    }
    log.text += fmt::format("{}\n", fmt::join(fields, delimiter));
  }
  return log;
}

/// The columns by number, also of those named.
std::array<int, 3> numbers_of(const SignalTable& table, const std::vector<Column>& columns) {
  std::array<int, 3> numbers{};
  for (std::size_t k = 0; k < columns.size() && k < 3; ++k)
    for (std::size_t i = 0; i < table.signals.size(); ++i)
      if (table.signals[i].column == columns[k]) numbers[k] = static_cast<int>(i) + 1;
  return numbers;
}

/// The faults of a recognition; empty where all is right.
std::string mistake(const Shape& shape, const Log& log, const SignalTable& table, const Inspection& found) {
  std::string wrong;
  const RecordingSource& s = found.source;
  if (numbers_of(table, s.gyro.columns) != log.gyro) wrong += " gyro columns";
  if (numbers_of(table, s.accel.columns) != log.accel) wrong += " accel columns";
  if (s.gyro.unit != shape.gyro.unit || s.gyro.output != shape.gyro.output) wrong += " gyro unit " + s.gyro.unit;
  if (s.accel.unit != shape.accel.unit || s.accel.output != shape.accel.output) wrong += " accel unit " + s.accel.unit;
  const std::string unit = shape.clock == "none" ? "sample" : shape.clock == "unix s" ? "s" : shape.clock.substr(0, shape.clock.find(' '));
  if (s.time.unit != unit) wrong += " time unit " + s.time.unit;
  if (std::abs(found.rate_hz.value_or(0) / 100 - 1) > 1e-3) wrong += " rate";
  if (shape.clock == "us wrapped at 16 bits" && s.time.wrap_bits != 16) wrong += " wrap";
  if (shape.clock == "us wrapped at 32 bits" && s.time.wrap_bits != 32) wrong += " wrap";
  if (shape.clock == "s and ns" && !s.time.fraction_column) wrong += " fraction";
  return wrong;
}

TEST(InspectShapes, LogsOfManyShapesAreUnderstoodOrAskedAbout) {
  int right = 0, asked = 0;
  const int shapes = 84;
  for (int i = 0; i < shapes; ++i) {
    const Shape shape = shape_of(i);
    const Log log = log_of(shape);
    const SignalTable table = signals_of_text("log.txt", log.text);
    const Inspection found = inspect(table, shape.clock == "none" ? Declarations{{"rate_hz", "100"}} : Declarations{});
    if (!found.complete()) {
      ++asked;
      fmt::print("asked: {}: {}\n", name_of(shape), fmt::join(found.ambiguous, "; "));
      continue;
    }
    const std::string wrong = mistake(shape, log, table, found);
    EXPECT_EQ(wrong, "") << name_of(shape) << "\n" << fmt::format("{}", fmt::join(found.evidence, "\n"));
    right += wrong.empty();
  }
  EXPECT_EQ(right + asked, shapes);
  EXPECT_GE(right, shapes * 9 / 10) << "asking is right, but not about everything";
}

/// A log of the same motion in seconds, deg/s and g, with a header of one's own; `change` may change a sample's readings (gyro, accel).
template <class Change>
Inspection inspected(const std::string& head, Change change, const Declarations& declared = {}, std::size_t rows = 1'000'000, double tick = 1) {
  const Recording& r = motion().recording;
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
  EXPECT_THAT(inspected(head, reverse).ambiguous, ElementsAre(HasSubstr("gyro.axes: gyro z has the wrong sign")));
  const Inspection declared = inspected(head, reverse, {{"gyro.axes", "+x,+y,-z"}});
  EXPECT_TRUE(declared.complete());
  ASSERT_TRUE(declared.source.gyro.axes);
  EXPECT_EQ((*declared.source.gyro.axes)[2], (BodyAxis{2, -1}));
  const Inspection turned_over = inspected(head, [](std::array<double, 6>& v) { v[3] = -v[3], v[4] = -v[4], v[5] = -v[5]; });
  EXPECT_TRUE(turned_over.complete()) << "all accelerometers reversed look like a unit that lies the other way up";
  EXPECT_THAT(turned_over.evidence, Contains(HasSubstr("if it was the other side, the accelerometers' signs are reversed")));
}

TEST(Inspect, ANameThatContradictsTheDataIsAskedAbout) {
  EXPECT_THAT(inspected("t,gx [rad/s],gy [rad/s],gz [rad/s],ax,ay,az\n", same).ambiguous, ElementsAre(HasSubstr("gyro.unit: the file says rad/s")));
  EXPECT_THAT(inspected("t,gx,gy,gz,ax [m/s^2],ay [m/s^2],az [m/s^2]\n", same).ambiguous, ElementsAre(HasSubstr("accel.unit: the file says m/s^2")));
  EXPECT_THAT(inspected("t,ax,ay,az,gx,gy,gz\n", same).ambiguous, Contains(HasSubstr("the names say otherwise")));
  EXPECT_THAT(inspected("time [us],gx,gy,gz,ax,ay,az\n", same).ambiguous, Contains(HasSubstr("time.unit: time [us] is named us")));
}

TEST(Inspect, WhatTheDataDoNotShowIsAskedAbout) {
  const std::size_t first_rest = 1000;  // of 20 s
  const Inspection still = inspected(head, same, {}, first_rest);
  EXPECT_THAT(still.ambiguous, ElementsAre(HasSubstr("gyro.unit: fewer than three turns")));
  EXPECT_FALSE(still.methods.at(0).supported);
  EXPECT_TRUE(inspected(head, same, {{"gyro.unit", "deg/s"}}, first_rest).complete());
  EXPECT_TRUE(inspected("t,gx [dps],gy [dps],gz [dps],ax,ay,az\n", same, {}, first_rest).complete())
      << "a name counts where nothing speaks against it";
  EXPECT_THAT(inspected("", same, {}, first_rest).ambiguous, Contains(HasSubstr("accel.columns, gyro.columns")));
  EXPECT_THAT(inspected(head, same, {}, 1'000'000, 32768).ambiguous, Contains(HasSubstr("time.unit"))) << "ticks of a watch crystal";
  EXPECT_TRUE(inspected(head, same, {{"time.ticks_per_s", "32768"}}, 1'000'000, 32768).complete());
  EXPECT_THAT(inspected(head,
                        [](std::array<double, 6>& v) {
                          for (double& x : v) x *= 1.37;
                        })
                  .ambiguous,
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

}  // namespace
}  // namespace imulab
