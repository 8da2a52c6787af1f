// Well-formed files whose data are poor: a warning (exit code 0), or what cannot be determined is said and the rest is written (1).
#include "imulab/files.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/recorded_session.hpp"
#include <algorithm>
#include <cmath>
#include <functional>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

CommandResult calibrate(const TemporaryFolder& folder, const SessionText& text, const std::string& method = "handheld") {
  text.write(folder);
  return run_imulab(folder, "calibrate session -o c.json --method " + method);
}

/// Samples `begin` to `end` in the file's lines: lines begin + 2 to end + 1.
void erase_samples(SessionText& s, std::size_t begin, std::size_t end) {
  s.lines.erase(s.lines.begin() + 1 + static_cast<std::ptrdiff_t>(begin), s.lines.begin() + 1 + static_cast<std::ptrdiff_t>(end));
}

TEST(BadData, IsWarnedOfAndUsedWhereItCanBe) {
  struct Case {
    std::function<void(SessionText&)> damage;
    std::string warning;
  };
  for (const Case& c : {
           Case{[](SessionText& s) { erase_samples(s, 3050, 3150); }, "session/recording.csv: 1 gap in time"},
           Case{[](SessionText& s) { s.lines.insert(s.lines.begin() + 100, s.lines[100]); },
                "session/recording.csv: 1 row equal to the row before dropped"},
           Case{[](SessionText& s) {
                  s.declare("unit = \"rad/s\"", "unit = \"rad/s\", limits = [-2, 2]");
                  s.set(3101, 1, "2.5");
                },
                "session/recording.csv: "},
       }) {
    const TemporaryFolder folder;
    SessionText text = hand_held_session();
    c.damage(text);
    const CommandResult result = calibrate(folder, text);
    EXPECT_EQ(result.exit_code, 0) << c.warning << result.errors;
    EXPECT_THAT(result.errors, HasSubstr("imulab: warning: " + c.warning));
    EXPECT_TRUE(std::filesystem::exists(folder / "c.json")) << c.warning;
  }
}

/// Fast motion lost as a whole says nothing of the gyros' scale.
TEST(BadData, WhatIsLostInGapsIsNoScale) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  std::vector<std::size_t> fast;
  std::size_t line = 1;
  text.for_rows([&](std::vector<double>& row) {
    if (std::abs(row[1]) + std::abs(row[2]) + std::abs(row[3]) > 2.4) fast.push_back(line);
    ++line;
  });
  for (std::size_t k = fast.size(); k-- > 0;) text.lines.erase(text.lines.begin() + static_cast<std::ptrdiff_t>(fast[k]));
  const CommandResult result = calibrate(folder, text);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors, HasSubstr("13 gaps in time"));
}

/// A gyro whose range is too small for a hand: what it did not measure is missing, and the rest is as certain as it is said to be.
TEST(BadData, ClippedTurnsBiasNothing) {  // ctest: long
  const TemporaryFolder folder;
  for (const char* made : {"procedure handheld --poses 20 -o hand.toml", "simulate hand.toml -o made"})
    ASSERT_EQ(run_imulab(folder, made).exit_code, 0);
  for (const double limit : {2.5, 1.5, 0.8})
    for (const std::string method : {"handheld", "hybrid"}) {
      std::filesystem::remove(folder / "c.json");
      SessionText text = hand_held_session();
      text.for_rows([&](std::vector<double>& row) {
        for (std::size_t k = 1; k < 4; ++k) row[k] = std::clamp(row[k], -limit, limit);
      });
      calibrate(folder, text, method);
      ASSERT_TRUE(std::filesystem::exists(folder / "c.json")) << limit << method;
      const auto compared = nlohmann::json::parse(run_imulab(folder, "compare c.json made/truth.json --json").output);
      for (const auto& [name, c] : compared.at("coefficients").items()) {
        const auto sigmas = c.find("sigmas");
        if (sigmas == c.end() || !sigmas->is_number()) continue;
        // Chance makes five of 150 numbers once in ten thousand.
        EXPECT_LT(std::abs(sigmas->get<double>()), 5) << name << " " << limit << " " << method;
      }
    }
}

/// A line that loses one row in fifty, as serial and radio links do.
TEST(BadData, LostRowsCostNoRotation) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  const std::size_t rows = text.lines.size();
  for (std::size_t row = rows - 20; row > 60; row -= 47) text.lines.erase(text.lines.begin() + static_cast<std::ptrdiff_t>(row));
  const CommandResult result = calibrate(folder, text);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.errors, HasSubstr("samples are missing, one or two at a time; they were interpolated from their neighbors"));
  const Quality quality = read_calibration(folder / "c.json").quality;
  EXPECT_EQ(quality.rotations.size() + 1, quality.rests.size());
  EXPECT_EQ(quality.verdict, Verdict::good) << result.output;
}

TEST(BadData, NothingIsWrittenWhereNothingFollows) {
  struct Case {
    std::function<void(SessionText&)> damage;
    std::string message;
  };
  // The unit turns about two axes of its own all the time, smoothly, with g going round.
  const auto never_still = [](SessionText& s) {
    s.for_rows([](std::vector<double>& row) {
      const double a = 0.5 * row[0], b = 0.3 * row[0];
      row = {row[0], 0.3 * std::cos(a), 0.5, 0.3 * std::sin(a), 9.8 * std::sin(a) * std::cos(b), 9.8 * std::sin(b), 9.8 * std::cos(a) * std::cos(b)};
    });
  };
  for (const Case& c : {
           Case{never_still, "recording.csv: no rests in 144 s at 100 Hz: the IMU was never still for long enough"},
           Case{[](SessionText& s) { s.declare("unit = \"m/s^2\"", "unit = \"m/s^2\", limits = [-1, 1]"); }, "recording.csv: no rests"},
           Case{[](SessionText& s) { s.lines.resize(3); }, "recording.csv: no rests"},
           Case{[](SessionText& s) { s.for_rows([](std::vector<double>& row) { row[6] = 9.81; }); },
                "recording.csv: accel z reads 9.81 in every sample"},
           Case{[](SessionText& s) { s.for_rows([](std::vector<double>& row) { row[1] = 0; }); },
                "recording.csv: gyro x reads 0 in every sample: the method static calibrates the accelerometers alone"},
       }) {
    const TemporaryFolder folder;
    SessionText text = hand_held_session();
    c.damage(text);
    const CommandResult result = calibrate(folder, text);
    EXPECT_EQ(result.exit_code, 1) << c.message;
    EXPECT_THAT(result.errors, HasSubstr("imulab: " + c.message));
    EXPECT_FALSE(std::filesystem::exists(folder / "c.json")) << c.message;
  }
}

TEST(BadData, ADeadGyroLeavesTheAccelerometersToTheStaticMethod) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.for_rows([](std::vector<double>& row) { row[1] = 0; });
  EXPECT_EQ(calibrate(folder, text, "static").exit_code, 0);
}

/// Exit code 1; what is written reads back, says what is not determined, and gives that neither a value of its own nor an uncertainty.
void expect_partly_determined(const TemporaryFolder& folder, const CommandResult& result, const std::string& warning) {
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("imulab: warning: " + warning));
  EXPECT_THAT(result.errors, HasSubstr("imulab: the data do not determine: "));
  EXPECT_THAT(result.errors + result.output, Not(HasSubstr("nan")));
  const Calibration calibration = read_calibration(folder / "c.json");
  EXPECT_THAT(calibration.quality.unobservable, Not(testing::IsEmpty()));
  EXPECT_THAT(verdict_text(calibration.quality), testing::StartsWith("doubtful, because "));
}

TEST(BadData, TooFewRests) {
  for (const std::size_t samples : {1000, 3500, 4100, 5300}) {  // 1, 2, 3 and 5 rests
    const TemporaryFolder folder;
    SessionText text = hand_held_session();
    text.lines.resize(1 + samples);
    expect_partly_determined(folder, calibrate(folder, text), "only ");
  }
}

TEST(BadData, RestsWhoseRotationsShowNoScaleStillGiveTheGyrosOffset) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.lines.resize(1 + 5300);  // 5 rests
  const CommandResult result = calibrate(folder, text);
  EXPECT_THAT(result.errors, HasSubstr("gyro.matrix.zz"));  // among those that are not determined
  for (const char* offset : {"gyro.offset.x", "gyro.offset.y", "gyro.offset.z"}) {
    EXPECT_THAT(result.errors, testing::Not(HasSubstr(offset)));
    EXPECT_THAT(result.output, HasSubstr(offset));
  }
  EXPECT_THAT(result.output, testing::Not(HasSubstr("what the noise explains")));
}

TEST(BadData, AllRestsOnOneAxis) {
  const TemporaryFolder folder;
  std::string procedure =
      "format = \"imulab.session/1\"\n[imu]\nname = \"flat\"\ngrade = \"mems\"\n[site]\nlatitude_deg = 45\nheight_m = 0\n[rig]\nkind = \"none\"\n";
  for (int k = 0; k < 12; ++k) procedure += "[[step]]\nkind = \"hold\"\nduration_s = 4\nmove_s = 2\nouter_deg = " + std::to_string(90 * k) + "\n";
  folder.write("flat.toml", procedure);
  ASSERT_EQ(run_imulab(folder, "simulate flat.toml -o session").exit_code, 0);
  expect_partly_determined(folder, run_imulab(folder, "calibrate session -o c.json --method static"),
                           "all rests have gravity near one axis or plane of the IMU");
  // Turns about the vertical alone leave the gyros open too: nothing remains that could be written.
  const CommandResult result = run_imulab(folder, "calibrate session -o h.json --method handheld");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, testing::AnyOf(HasSubstr("imulab: the rests do not determine the requested parameters; "),
                                            HasSubstr("imulab: the data do not determine: accel.offset.x ")));
}

}  // namespace
}  // namespace imulab
