#include "imulab/finding.hpp"

#include "imulab/model/finding_table.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>
#include <string>

namespace imulab {
namespace {

using ::testing::ElementsAre;

TEST(Finding, NamesAreStableWords) {
  std::set<std::string_view> names;
  for (const FindingRow& row : finding_table) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name << " is the name of two codes";
    EXPECT_TRUE(std::ranges::all_of(row.name, [](char c) { return c == '-' || (c >= 'a' && c <= 'z'); })) << row.name;
    EXPECT_EQ(code_of(name_of(row.code)), row.code);
  }
  EXPECT_EQ(code_of("of-another-version"), Code::other);
}

TEST(Finding, HasTheWordsOfItsCodeAndTheNumbersInThem) {
  Findings findings;
  const Finding& scale = findings.add<Code::uncertain_scale>(Subject{"gyro.matrix.xx"}, 2.5);
  EXPECT_EQ(scale.text, "gyro.matrix.xx is uncertain by 2.5 %");
  EXPECT_EQ(scale.subject, "gyro.matrix.xx");
  EXPECT_THAT(scale.numbers, ElementsAre(2.5));
  EXPECT_EQ(scale.severity, Severity::doubt);
}

TEST(Finding, OneListGivesReasonsWarningsAndNotes) {
  Findings findings;
  findings.add<Code::iterations>(3, 40);
  findings.add<Code::scatter>(Subject{"residuals"}, 1.2);
  EXPECT_FALSE(findings.doubtful());
  findings.add<Code::scatter>(Subject{"velocities"}, 2.0).severity = Severity::doubt;
  findings.add<Code::not_converged>();
  findings.add<Code::few_rests>(1, "").place = "a.csv";
  EXPECT_TRUE(findings.doubtful() && findings.has(Code::not_converged) && !findings.has(Code::wrong_latitude));
  EXPECT_THAT(findings.notes(), ElementsAre("3 iterations over 40 blocks"));
  EXPECT_THAT(findings.reasons(), ElementsAre("the velocities scatter 2 times as much as the noise explains", "the fit did not converge"));
  EXPECT_THAT(findings.warnings(),
              ElementsAre("the residuals scatter 1.2 times as much as the noise explains; the uncertainties are enlarged by this factor",
                          "the velocities scatter 2 times as much as the noise explains; the uncertainties are enlarged by this factor",
                          "a.csv: only 1 rest: about 20 in different directions are good"));
  EXPECT_EQ(findings.all().size(), 4u);
}

}  // namespace
}  // namespace imulab
