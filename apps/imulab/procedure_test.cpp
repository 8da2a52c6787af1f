#include <gmock/gmock.h>

#include "tests/run_command.hpp"

namespace imulab {
namespace {

using testing::HasSubstr;

TEST(ProcedureVerb, AloneListsWhatThereIs) {
  const TemporaryFolder folder;
  const CommandResult result = run_imulab(folder, "procedure");
  EXPECT_EQ(result.exit_code, 0);
  for (const char* name : {"handheld ", "ferraris ", "six-position ", "two-axis ", "zhang-24 ", "cheng-path ", "dai-unit "})
    EXPECT_THAT(result.output, HasSubstr(std::string("\n") + name));
  EXPECT_EQ(run_imulab(folder, "procedure zhang").exit_code, 2);
  EXPECT_EQ(run_imulab(folder, "fleet").exit_code, 2);  // a verb that does nothing alone
}

TEST(ProcedureVerb, WhichJudgesByWhatOneHas) {
  const TemporaryFolder folder;
  const CommandResult good = run_imulab(folder, "procedure which --have hands --require \"gyro.offset <= 0.3 deg/h\"");
  EXPECT_EQ(good.exit_code, 0);
  EXPECT_THAT(good.output, HasSubstr("hands, mems: 4 min, method handheld: not met"));
  EXPECT_THAT(good.output, HasSubstr("hands, rlg: 41 min, method handheld: met"));
  EXPECT_EQ(run_imulab(folder, "procedure which --have hands --sensors mems --require \"gyro.offset <= 0.1 deg/h\"").exit_code, 1);
  EXPECT_THAT(run_imulab(folder, "procedure which --have crane").errors, HasSubstr("crane"));
  EXPECT_THAT(run_imulab(folder, "procedure which --require apples").errors, HasSubstr("--require: "));
}

TEST(ProcedureVerb, GradesRestsAndMachinesAreOptions) {
  const TemporaryFolder folder;
  EXPECT_THAT(run_imulab(folder, "procedure handheld --grade tactical --rest 20").output, HasSubstr("grade = \"tactical\""));
  const std::string table = run_imulab(folder, "procedure dai-unit --machines rate_table").output;
  EXPECT_THAT(table, testing::AllOf(HasSubstr("rate_table"), testing::Not(HasSubstr("centrifuge")), testing::Not(HasSubstr("chamber"))));
  EXPECT_THAT(run_imulab(folder, "procedure dai-unit --machines crane").errors,
              HasSubstr("--machines: crane; expected chamber, rate_table or centrifuge"));
  EXPECT_EQ(run_imulab(folder, "procedure dai-unit --machines \"\"").exit_code, 2);
}

}  // namespace
}  // namespace imulab
