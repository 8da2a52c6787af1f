// Odd but legal recordings give the calibration that the plain one gives.
#include "imulab/coefficient.hpp"
#include "imulab/files.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"
#include <algorithm>
#include <cmath>
#include <functional>

namespace imulab {
namespace {

Calibration calibrated(const TemporaryFolder& folder) {
  const CommandResult result = run_imulab(folder, "calibrate session -o c.json --method handheld");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  return read_calibration(folder / "c.json");
}

const Calibration& plain() {
  static const Calibration calibration = [] {
    const TemporaryFolder folder;
    hand_held_session().write(folder);
    return calibrated(folder);
  }();
  return calibration;
}

/// `share`: of the standard uncertainties by which coefficients may differ.
void expect_as_plain(const Calibration& odd, double share) {
  EXPECT_EQ(odd.estimated, plain().estimated);
  EXPECT_EQ(odd.quality.verdict, Verdict::good);
  for (const CoefficientIndex index : plain().estimated)
    EXPECT_NEAR(coefficient_value(odd.model, index), coefficient_value(plain().model, index), share * standard_uncertainty(plain(), index).value())
        << coefficient(index).name;
}

TEST(OddInput, LineEndsAndDelimiters) {
  const auto delimited = [](char c) {
    std::string text = hand_held_session().recording();
    std::replace(text.begin(), text.end(), ',', c);
    return text;
  };
  for (const std::string& recording :
       {hand_held_session().recording("\r\n"), delimited(';'), delimited('\t'), delimited(' '), "\xEF\xBB\xBF" + hand_held_session().recording()}) {
    const TemporaryFolder folder;
    hand_held_session().write(folder);
    folder.write("session/recording.csv", recording);
    expect_as_plain(calibrated(folder), 0);  // the same numbers
  }
}

TEST(OddInput, UnitsAndClocks) {
  struct Case {
    std::function<void(SessionText&)> change;
    const char* name;
  };
  for (const Case& c : {
           Case{[](SessionText& s) {
                  s.declare("\"rad/s\"", "\"deg/h\"");
                  s.for_rows([](std::vector<double>& row) {
                    for (const std::size_t k : {1, 2, 3}) row[k] /= unit::deg_per_h;
                  });
                },
                "deg/h"},
           Case{[](SessionText& s) {
                  s.declare("unit = \"s\"", "unit = \"us\"");
                  for (std::size_t line = 2; line <= s.lines.size(); ++line) s.set(line, 0, std::to_string(1700000000000000 + 10000 * (line - 1)));
                },
                "microseconds since 1970"},
           Case{[](SessionText& s) {
                  s.declare("output = \"rate\", unit = \"rad/s\"", "output = \"increment\", unit = \"rad\"");
                  s.declare("output = \"rate\", unit = \"m/s^2\"", "output = \"increment\", unit = \"m/s\"");
                  s.for_rows([](std::vector<double>& row) {
                    for (std::size_t k = 1; k < 7; ++k) row[k] *= 0.01;
                  });
                },
                "increments"},
       }) {
    SCOPED_TRACE(c.name);
    const TemporaryFolder folder;
    SessionText text = hand_held_session();
    c.change(text);
    text.write(folder);
    // Numbers are written with 12 digits and the fit stops a hundredth of a standard uncertainty from its end.
    expect_as_plain(calibrated(folder), 0.02);
  }
}

/// Stamps of a computer that reads the unit when it finds time: up to 4 ms off, in no order.
TEST(OddInput, JitteringStamps) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  std::uint32_t state = 1;
  for (std::size_t line = 2; line <= text.lines.size(); ++line) {
    state = state * 1664525u + 1013904223u;  // Numerical Recipes' quick generator
    text.set(line, 0, std::to_string(0.01 * static_cast<double>(line - 1) + 0.008 * (state / 4294967296.0 - 0.5)));
  }
  text.write(folder);
  const Calibration jittering = calibrated(folder);
  EXPECT_EQ(jittering.estimated, plain().estimated);
  // The gyros' scales are those of the true clock within what such intervals add: 2.3 ms on 2 s, in 19 turns, 3e-4.
  for (const char* name : {"gyro.matrix.xx", "gyro.matrix.yy", "gyro.matrix.zz"}) {
    const CoefficientIndex index = coefficient_index(name);
    EXPECT_NEAR(coefficient_value(jittering.model, index), coefficient_value(plain().model, index), 3 * 3e-4) << name;
  }
}

TEST(OddInput, LostRowsInRests) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  for (std::size_t line = 2800; line > 100; line -= 7) text.lines.erase(text.lines.begin() + static_cast<std::ptrdiff_t>(line));  // of the first 30 s
  text.write(folder);
  // A seventh less of the longest rest moves nothing by more than its standard uncertainty.
  expect_as_plain(calibrated(folder), 1);
}

TEST(OddInput, WholeCounts) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.declare("\"rad/s\"", "\"count\"");
  text.declare("\"m/s^2\"", "\"count\"");
  text.for_rows([](std::vector<double>& row) {
    for (const std::size_t k : {1, 2, 3}) row[k] = std::round(32768 + row[k] * 5000);
    for (const std::size_t k : {4, 5, 6}) row[k] = std::round(32768 + row[k] * 400);
  });
  text.write(folder);
  const Calibration counts = calibrated(folder);
  EXPECT_EQ(counts.quality.verdict, Verdict::good);
  // The scale in counts is the plain one over counts per unit: within ten standard uncertainties, for the noise of rounding (0.2 and 0.05 of
  // the samples' own) and another start.
  for (const char* name : {"accel.matrix.xx", "accel.matrix.zz"}) {
    const CoefficientIndex index = coefficient_index(name);
    EXPECT_NEAR(400 * coefficient_value(counts.model, index), coefficient_value(plain().model, index),
                10 * standard_uncertainty(plain(), index).value())
        << name;
  }
  const CoefficientIndex gyro = coefficient_index("gyro.matrix.yy");
  EXPECT_NEAR(5000 * coefficient_value(counts.model, gyro), coefficient_value(plain().model, gyro), 10 * standard_uncertainty(plain(), gyro).value());
}

}  // namespace
}  // namespace imulab
