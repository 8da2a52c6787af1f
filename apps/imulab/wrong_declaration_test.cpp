// A session that declares something else than the recording holds: never "good", and the likely cause is named.
// ctest: once
#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"
#include <algorithm>
#include <cmath>
#include <functional>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct WrongDeclaration {
  const char* name;
  std::function<void(SessionText&)> damage;
  std::string cause;
  std::string method = "handheld";
};

using Row = std::vector<double>;

std::function<void(SessionText&)> rows(const std::function<void(Row&)>& change) {
  return [change](SessionText& s) { s.for_rows(change); };
}

std::function<void(SessionText&)> times(std::size_t begin, std::size_t end, double factor) {
  return rows([=](Row& row) {
    for (std::size_t k = begin; k < end; ++k) row[k] *= factor;
  });
}

/// The readings of columns `begin` to `end` as they were `later` samples later; the recording is taken as a ring.
std::function<void(SessionText&)> shifted(std::size_t begin, std::size_t end, std::ptrdiff_t later) {
  return [=](SessionText& s) {
    std::vector<Row> all;
    s.for_rows([&](Row& row) { all.push_back(row); });
    std::size_t i = 0;
    s.for_rows([&](Row& row) {
      const std::size_t from = (i++ + all.size() + static_cast<std::size_t>(later)) % all.size();
      std::copy(all[from].begin() + static_cast<std::ptrdiff_t>(begin), all[from].begin() + static_cast<std::ptrdiff_t>(end),
                row.begin() + static_cast<std::ptrdiff_t>(begin));
    });
  };
}

const char* const gyro_rate = "output = \"rate\", unit = \"rad/s\"";

TEST(WrongDeclaration, IsNeverGood) {
  for (const WrongDeclaration& c : {
           WrongDeclaration{"deg/h for rad/s", [](SessionText& s) { s.declare("unit = \"rad/s\"", "unit = \"deg/h\""); },
                            "the readings are in rad/s"},
           WrongDeclaration{"deg/s for rad/s", [](SessionText& s) { s.declare("unit = \"rad/s\"", "unit = \"deg/s\""); },
                            "the readings are in rad/s"},
           WrongDeclaration{"rad/s for deg/s", times(1, 4, 180 / 3.14159265), "the readings are in deg/s"},
           WrongDeclaration{"rad/s for deg/h", times(1, 4, 3600 * 180 / 3.14159265), "expected a reading that a sensor can give"},
           WrongDeclaration{"g for m/s^2", [](SessionText& s) { s.declare("unit = \"m/s^2\"", "unit = \"g\""); }, "the readings are in m/s^2,"},
           WrongDeclaration{"m/s^2 for g", times(4, 7, 1 / 9.8), "the readings are in g,"},
           WrongDeclaration{"stamps in ms as s",
                            [](SessionText& s) {
                              s.for_rows([](Row& row) { row[0] *= 1000; });
                              s.declare("rate_hz = 100\n", "");
                            },
                            "the unit of the stamps is smaller than declared"},
           WrongDeclaration{"increments for rates", [](SessionText& s) { s.declare(gyro_rate, "output = \"increment\", unit = \"rad\""); },
                            "the readings are rates"},
           WrongDeclaration{"rates for increments", times(1, 4, 0.01), "the readings are increments"},
           WrongDeclaration{"half of the gyros' reading", times(1, 4, 0.5), "the gyros' scale is 2.0"},
           WrongDeclaration{"a thousandth", times(1, 4, 1000), "thousandths of the declared unit"},
           WrongDeclaration{"one axis twice", times(1, 2, 2), "the gyros' x scale is 0.5"},
           WrongDeclaration{"gyros' axes exchanged", rows([](Row& row) { std::swap(row[1], row[2]); }), "the gyros' axes are not as declared"},
           WrongDeclaration{"a gyro reversed", times(1, 2, -1), "(left-handed)"},
           WrongDeclaration{"an accelerometer reversed", times(4, 5, -1), "the gyros' axes are not as declared"},
           WrongDeclaration{"all gyros reversed", times(1, 4, -1), "x is along the -x reading, y is along the -y reading"},
           WrongDeclaration{"a column twice", rows([](Row& row) { row[2] = row[1]; }), "gyro x and y are equal in every sample"},
           WrongDeclaration{"a reading of 1e300", [](SessionText& s) { s.set(778, 4, "1e300"); }, "line 778: accel x is 1e+300 m/s^2"},
           WrongDeclaration{"a gravity of another place", [](SessionText& s) { s.declare("height_m = 0", "height_m = 0\ngravity_mps2 = 9.8356"); },
                            "the given gravity of 9.8356 m/s^2 is not that of the given latitude"},
           WrongDeclaration{"gyros of another time", shifted(1, 4, 5000), "the gyros do not turn with the accelerometers"},
           WrongDeclaration{"gyros of another time", shifted(1, 4, 5000), "the gyros do not turn with the accelerometers", "hybrid"},
           WrongDeclaration{"one accelerometer late", shifted(6, 7, -1), "the z accelerometer's readings are a sample later than the others'",
                            "hybrid"},
           WrongDeclaration{"one gyro early", shifted(2, 3, 1), "the y gyro's readings are a sample earlier than the others'", "hybrid"},
           WrongDeclaration{"absolute zero",
                            [](SessionText& s) {
                              for (std::size_t line = 1; line <= s.lines.size(); ++line) s.lines[line - 1] += line == 1 ? ",T" : ",-300";
                              s.session += "\ngyro_temperature = { columns = [\"T\"], unit = \"degC\" }\n";
                            },
                            "line 2: the temperature is -300 degC; expected -273.15 to 1000"},
           WrongDeclaration{"a temperature of no IMU",
                            [](SessionText& s) {
                              for (std::size_t line = 1; line <= s.lines.size(); ++line)
                                s.lines[line - 1] += line == 1 ? ",T" : line == 778 ? ",1e5" : ",293";
                              s.session += "\ngyro_temperature = { columns = [\"T\"], unit = \"K\" }\n";
                            },
                            "line 778: the temperature is 100000 K; expected 0 to 1273.15"},
       }) {
    SCOPED_TRACE(c.name);
    const TemporaryFolder folder;
    SessionText text = hand_held_session();
    c.damage(text);
    text.write(folder);
    const CommandResult result = run_imulab(folder, "calibrate session --method " + c.method);
    EXPECT_THAT(result.output + "\n", Not(HasSubstr("\ngood\n")));
    EXPECT_THAT(on_one_line(result.errors + result.output), HasSubstr(c.cause));
  }
}

TEST(WrongDeclaration, AChannelThatClipsIsSaidAndItsSamplesAreNotUsed) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.for_rows([](Row& row) {
    for (std::size_t k = 4; k < 7; ++k) row[k] = std::clamp(row[k], -9.0, 9.0);
  });
  text.write(folder);
  const CommandResult result = run_imulab(folder, "calibrate session --method static -o c.json");
  EXPECT_THAT(result.errors, HasSubstr("at a limit"));
  if (result.exit_code == 0) {
    EXPECT_THAT(run_imulab(folder, "compare c.json session/truth.json").output, Not(HasSubstr(" *\n")));
  }
}

TEST(WrongDeclaration, AccelerometersThatReadSevenTenthsEndWithTheirFactor) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.for_rows([](Row& row) {
    for (std::size_t k = 4; k < 7; ++k) row[k] *= 0.7;
  });
  text.write(folder);
  const CommandResult result = run_imulab(folder, "calibrate session --method handheld -o c.json");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(on_one_line(result.errors), testing::ContainsRegex("is implausible for an IMU, 1\\.4[0-9]* times what the declared unit gives"));
  EXPECT_TRUE(std::filesystem::exists(folder / "c.json")) << "what came out is kept";
}

TEST(WrongDeclaration, ARateThatTheStampsContradictIsSaid) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.for_rows([](Row& row) {
    for (std::size_t k = 1; k < 7; ++k) row[k] *= 0.01;
  });
  text.declare("rate_hz = 100\n", "rate_hz = 101.9\n");
  text.declare(gyro_rate, "output = \"increment\", unit = \"rad\"");
  text.declare("output = \"rate\", unit = \"m/s^2\"", "output = \"increment\", unit = \"m/s\"");
  text.write(folder);
  EXPECT_THAT(run_imulab(folder, "calibrate session --method handheld").errors, HasSubstr("rate_hz = 101.9 is declared, the stamps give 100 Hz"));
}

}  // namespace
}  // namespace imulab
