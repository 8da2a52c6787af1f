// calibrate --method whole-unit as people use it.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"

namespace imulab {
namespace {

using ::testing::HasSubstr;

class CalibrateWholeUnit : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(imulab("procedure dai-unit --record 1 -o dai.toml").exit_code, 0);
    ASSERT_EQ(imulab("simulate dai.toml -o session").exit_code, 0);
  }
  CommandResult imulab(const std::string& arguments) { return run_imulab(folder, arguments); }

  const TemporaryFolder folder;
};

TEST_F(CalibrateWholeUnit, FromThreeMachines) {
  const CommandResult joint = imulab("calibrate session --method whole-unit -o c.json -v");
  EXPECT_EQ(joint.exit_code, 0) << joint.errors;
  EXPECT_EQ(joint.errors, "");
  for (const char* text : {"frame: rig", "303 points were used: 15 in the chamber, 246 on the rate table, 42 on the centrifuge",
                           "% RMS of the full scale of 30", "ug/g^3", "held-out points are missed by"})
    EXPECT_THAT(on_one_line(joint.output), HasSubstr(text));
  EXPECT_THAT(joint.output, testing::StartsWith("good: "));
  EXPECT_EQ(imulab("compare c.json session/truth.json").exit_code, 0);
  EXPECT_EQ(imulab("calibrate session --method whole-unit --stepwise -o s.json").exit_code, 0);
  EXPECT_EQ(imulab("export c.json --to c-header -o c.h").exit_code, 0);
  EXPECT_EQ(imulab("compensate c.json session -o out").exit_code, 0);
}

TEST_F(CalibrateWholeUnit, WhatCannotBeDoneSaysSo) {
  const CommandResult part = imulab("calibrate session --method whole-unit --recording centrifuge.csv -o part.json");
  EXPECT_EQ(part.exit_code, 1);
  EXPECT_THAT(part.errors, HasSubstr("the data do not determine:"));
  EXPECT_TRUE(std::filesystem::exists(folder / "part.json"));
  const std::string before = read_text(folder / "session/chamber.csv");
  const CommandResult over = imulab("calibrate session --method whole-unit -o session/chamber.csv --force");
  EXPECT_EQ(over.exit_code, 2);
  EXPECT_THAT(over.errors, HasSubstr("would overwrite session/chamber.csv"));
  EXPECT_EQ(read_text(folder / "session/chamber.csv"), before);
  for (const auto& [arguments, message] : {std::pair("--method static --stepwise", "--stepwise: only the method whole-unit has steps"),
                                           std::pair("--method static --terms full", "--terms full: only the method whole-unit takes it"),
                                           std::pair("--method whole-unit --stepwise --terms accel.offset", "terms cannot be chosen")}) {
    const CommandResult wrong = imulab(std::string("calibrate session ") + arguments);
    EXPECT_EQ(wrong.exit_code, 2) << arguments;
    EXPECT_THAT(wrong.errors, HasSubstr(message)) << arguments;
  }
}

TEST_F(CalibrateWholeUnit, ReadingsThatNoSensorGivesAreNotCompensated) {
  ASSERT_EQ(imulab("calibrate session --method whole-unit -o c.json -v").exit_code, 0);
  std::string text = read_text(folder / "session/chamber.csv");
  const std::size_t row = text.find('\n') + 1, first = text.find(',', row) + 1;
  text.replace(first, text.find(',', first) - first, "1e160");  // its cube is beyond a double
  folder.write("session/chamber.csv", text);
  const CommandResult result = imulab("compensate c.json session -o out");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("expected a reading that a sensor can give"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

}  // namespace
}  // namespace imulab
