// imulab noise --datasheet: a data sheet without a log, and beside one.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/still_log.hpp"
#include <filesystem>

namespace imulab {
namespace {

using ::testing::HasSubstr;

const char* const sheet = "noise --datasheet 'gyro.N = 0.0038 deg/s/sqrt(Hz), accel.N = 70 ug/sqrt(Hz), gyro.stability = 10 deg/h'";

TEST(NoiseSheetCommand, WritesAndExportsItWithoutALog) {
  const TemporaryFolder folder;
  const CommandResult result = run_imulab(folder, std::string(sheet) + " -o noise.json --report sheet.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(on_one_line(result.output),
              HasSubstr("values of a data sheet, not fitted to a log: gyro N 0.228 deg/sqrt(h), accelerometer N 70 ug/sqrt(Hz)"));
  // 10 deg/h over 0.664, and sqrt(3) m^2 / (2 N).
  EXPECT_THAT(result.output, testing::ContainsRegex("gyro +B +<= 15.1 deg/h +<= 7.298e-05 rad/s +bounded"));
  EXPECT_THAT(result.output, testing::ContainsRegex("gyro +K +<= .*bounded"));
  const nlohmann::json json = nlohmann::json::parse(read_text(folder / "noise.json"));
  EXPECT_EQ(json.at("source"), "data sheet");
  EXPECT_EQ(json.at("verdict"), nullptr);
  EXPECT_THAT(read_text(folder / "sheet.html"), HasSubstr("not fitted to a log"));
  EXPECT_EQ(run_imulab(folder, "report noise.json -o saved.html").exit_code, 0);
  EXPECT_EQ(read_text(folder / "saved.html"), read_text(folder / "sheet.html"));
  const CommandResult exported = run_imulab(folder, "export none --noise noise.json --to lio-sam");
  EXPECT_EQ(exported.exit_code, 0) << exported.errors;
  EXPECT_THAT(exported.output, HasSubstr("# Noise: values of a DATA SHEET, not fitted to a log."));
  const CommandResult kalibr = run_imulab(folder, "export none --noise noise.json --to kalibr-imu");
  EXPECT_THAT(kalibr.errors, HasSubstr("expected a rate: --stream-rate HZ"));
  EXPECT_EQ(run_imulab(folder, "export none --noise noise.json --to kalibr-imu --stream-rate 200").exit_code, 0);
}

TEST(NoiseSheetCommand, DeclaresTheNoiseOfASession) {
  const TemporaryFolder folder;
  folder.write("sheet.toml", "[noise]\nrate = \"100 Hz\"\ngyro.N = \"0.0038 deg/s/sqrt(Hz)\"\naccel.N = \"70 ug/sqrt(Hz)\"\n");
  ASSERT_EQ(run_imulab(folder, "noise --datasheet sheet.toml -o noise.json").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "procedure handheld -o hand.toml").exit_code, 0);
  std::string text = read_text(folder / "hand.toml");
  text.insert(text.find("[imu]") + 6, "noise = \"noise.json\"\n");
  folder.write("hand.toml", text);
  const CommandResult predicted = run_imulab(folder, "predict hand.toml --method handheld");
  EXPECT_EQ(predicted.exit_code, 0) << predicted.errors;
}

TEST(NoiseSheetCommand, ComparesTwoSheets) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_imulab(folder, "noise --datasheet 'gyro.N = 2 mdps/√Hz' -o a.json").exit_code, 0);
  ASSERT_EQ(run_imulab(folder, "noise --datasheet 'gyro.N <= 3 mdps/√Hz' -o b.json").exit_code, 0);
  EXPECT_THAT(run_imulab(folder, "compare a.json b.json").output, testing::ContainsRegex("gyro.x.N +deg/sqrt\\(h\\) +0.12 +0.18 +x 1.5"));
}

TEST(NoiseSheetCommand, ComparesALog) {
  const TemporaryFolder folder;
  write_still_log(folder, 20000, still_readings);
  // The log's N: 5.774e-5 rad/s/sqrt(Hz) = 0.1985 deg/sqrt(h), to 0.5 %.
  const CommandResult result = run_imulab(folder, "noise session.toml --datasheet 'gyro.N = 0.198 deg/sqrt(h), accel.N = 100 ug/sqrt(Hz)' -o n.json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, testing::ContainsRegex("gyro.x.N +0.198 +0.(19|20)[0-9]* .* deg/sqrt\\(h\\) +0.98[0-9]* +inside"));
  EXPECT_THAT(result.output, testing::ContainsRegex("accel.x.N +100 +5[0-9.]+ .* ug/sqrt\\(Hz\\) +0.[0-9]+ +above"));
  const nlohmann::json rows = nlohmann::json::parse(read_text(folder / "n.json")).at("data_sheet");
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows[0].at("contained"), true);
  EXPECT_EQ(rows[5].at("contained"), false);
  EXPECT_EQ(run_imulab(folder, "noise session.toml --datasheet 'gyro.N = 0.198 deg/sqrt(h)' --report page.html").exit_code, 0);
  EXPECT_THAT(read_text(folder / "page.html"), HasSubstr("Against the data sheet"));
}

TEST(NoiseSheetCommand, RefusesWhatItCannotUse) {
  const TemporaryFolder folder;
  write_still_log(folder, 2000, still_readings);
  struct Refusal {
    const char *words, *message;
  };
  for (const auto& [words, message] : {
           Refusal{"noise", "RECORDING is required; usage: imulab noise RECORDING..., or imulab noise --datasheet SHEET"},
           {"noise --datasheet 'gyro.N = 3 deg'", "--datasheet: gyro.N: \"deg\" is not a unit of N; expected one such as deg/s/sqrt(Hz)"},
           {"noise --datasheet missing.toml", "missing.toml"},
           {"noise --datasheet 'gyro.N = 3 deg/sqrt(h)' --require 'gyro.N <= 1 deg/sqrt(h)'", "--require: judges a log"},
           {"noise session.toml session.toml --datasheet 'gyro.N = 3 deg/sqrt(h)'", "--datasheet: compares one log"},
           {"noise session.toml --datasheet 'gyro.N = 3'", "--datasheet: gyro.N: has no unit"},
       }) {
    const CommandResult result = run_imulab(folder, words);
    EXPECT_EQ(result.exit_code, 2) << words;
    EXPECT_THAT(result.errors, HasSubstr(message)) << words;
  }
}

}  // namespace
}  // namespace imulab
