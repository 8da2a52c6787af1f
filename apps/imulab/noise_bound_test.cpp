// imulab noise --bound and --model: from a log at rest to a filter.
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/still_log.hpp"

namespace imulab {
namespace {

using ::testing::HasSubstr;

TEST(NoiseBoundCommand, LogBecomesTheNoiseOfAFilter) {
  const TemporaryFolder folder;
  write_still_log(folder, 20000, still_readings);
  const CommandResult result = run_imulab(folder, "noise session.toml --bound --horizon 60 -o noise.json --report page.html");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("\n  bound    N "));
  EXPECT_THAT(read_text(folder / "page.html"), HasSubstr("Bound for a filter"));
  const auto json = nlohmann::json::parse(read_text(folder / "noise.json"));
  for (const auto& axis : json["axes"]) {
    const auto& bound = axis["bound"];
    EXPECT_EQ(bound["confidence"], 0.95);
    EXPECT_EQ(bound["horizon_s"], 60);
    EXPECT_GE(bound["tightness"], 1);
    EXPECT_GE(bound["N"], axis["coefficients"]["N"]["value"]);
    EXPECT_EQ(bound["upper"]["hz"].size(), bound["upper"]["density"].size());
  }
  const CommandResult kalibr = run_imulab(folder, "export none --noise noise.json --bound --to kalibr-imu");
  EXPECT_EQ(kalibr.exit_code, 0) << kalibr.errors;
  EXPECT_THAT(kalibr.output, HasSubstr("N and K are BOUNDS"));
  EXPECT_EQ(run_imulab(folder, "export none --noise noise.json --to filter-c -o filter.h").exit_code, 0);
  const CommandResult both = run_imulab(folder, "noise session.toml session.toml --bound --horizon 60 -o both.json");
  EXPECT_EQ(both.exit_code, 0) << both.errors;
  EXPECT_EQ(nlohmann::json::parse(read_text(folder / "both.json"))["axes"][0]["bound"]["N"], json["axes"][0]["bound"]["N"]);
  EXPECT_EQ(run_imulab(folder, "export none --noise both.json --bound --to vins").exit_code, 0);
}

TEST(NoiseBoundCommand, WhatItCannotBoundIsRefused) {
  const TemporaryFolder folder;
  write_still_log(folder, 6000, still_readings);
  const CommandResult is_short = run_imulab(folder, "noise session.toml --bound");
  EXPECT_EQ(is_short.exit_code, 1);
  EXPECT_THAT(is_short.errors, HasSubstr("needs 1800 s at rest, and there are 60 s; expected a longer log, or a horizon of 20 s"));
  EXPECT_THAT(run_imulab(folder, "noise session.toml --horizon 20").errors, HasSubstr("expected --bound as well"));
  EXPECT_THAT(run_imulab(folder, "noise --datasheet \"gyro.N = 0.1 deg/sqrt(h)\" --bound").errors, HasSubstr("expected a recording"));
  EXPECT_EQ(run_imulab(folder, "noise session.toml --bound --confidence 2").exit_code, 2);
  ASSERT_EQ(run_imulab(folder, "noise session.toml -o noise.json").exit_code, 0);
  EXPECT_THAT(run_imulab(folder, "export none --noise noise.json --bound --to gtsam").errors, HasSubstr("noise LOG --bound"));
  EXPECT_THAT(run_imulab(folder, "export none --noise noise.json --to filter").errors, HasSubstr("noise LOG --bound"));
}

TEST(NoiseBoundCommand, TermsOfAModelAreThoseAskedFor) {
  const TemporaryFolder folder;
  write_still_log(folder, 6000, still_readings);
  const CommandResult result = run_imulab(folder, "noise session.toml --model N,K");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("model as asked: N, K; its other terms are zero"));
  EXPECT_THAT(result.output, testing::ContainsRegex("gyro.x   B +-  not in the model"));
  const CommandResult wrong = run_imulab(folder, "noise session.toml --model N,X");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("--model: \"X\" in \"N,X\"; expected each of N, Q, B, K once"));
}

}  // namespace
}  // namespace imulab
