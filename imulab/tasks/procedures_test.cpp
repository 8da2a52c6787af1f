#include "imulab/tasks/procedures.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace imulab {
namespace {

std::string page_text() {
  std::ifstream file(std::string(IMULAB_SOURCE) + "/docs/start/choose.md");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// All cells of the page: ./dev accept procedures.
TEST(Procedures, ThreeCellsOfThePageAreWhatIsPredicted) {
  const std::string page = page_text();
  for (const auto& [rig, sensors] : {std::pair{"hands", "mems"}, {"one-axis", "fog"}, {"two-axis", "rlg"}}) {
    const std::vector<ProcedureChoice> chosen = procedure_choices(rig, sensors);
    ASSERT_EQ(chosen.size(), 1u);
    EXPECT_THAT(page, testing::HasSubstr(procedure_row(chosen.front(), predict(chosen.front()))));
  }
}

TEST(Procedures, EveryRigAndEverySensorHasOne) {
  const std::vector<ProcedureChoice> all = procedure_choices();
  EXPECT_EQ(all.size(), std::size(rigs_that_one_has) * std::size(sensors_that_one_has));
  const std::string page = page_text();
  for (const ProcedureChoice& choice : all) {
    EXPECT_THAT(page, testing::HasSubstr("| " + std::string(choice.rig) + " | " + std::string(choice.sensors) + " |"));
    EXPECT_GT(duration_of(choice.procedure), 0);
  }
  for (const std::string_view sensors : sensors_that_one_has) EXPECT_EQ(procedure_choices("", sensors).size(), std::size(rigs_that_one_has));
}

TEST(Procedures, AreListedInLinesOf80Columns) {
  std::istringstream lines(standard_procedures_text());
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line); ++count) EXPECT_LE(line.size(), 80u) << line;
  EXPECT_EQ(count, 1 + standard_procedures().size());
}

TEST(Procedures, TwoAxesDetermineEverything) {
  const ProcedureChoice choice = procedure_choices("two-axis", "rlg").front();
  EXPECT_THAT(predict(choice).undetermined, testing::IsEmpty());
  for (const Step& step : choice.procedure.steps) EXPECT_EQ(step.angles[0], 0);  // the outer axis never turns
}

TEST(Procedures, RequirementsAreCompared) {
  const ProcedureChoice by_hand = procedure_choices("hands", "mems").front();
  EXPECT_THAT(predict(by_hand, parse_requirements("gyro.matrix.diagonal <= 200 ppm")).missed, testing::IsEmpty());
  EXPECT_THAT(predict(by_hand, parse_requirements("gyro.matrix.diagonal <= 2 ppm")).missed, testing::SizeIs(testing::Ge(1u)));
}

}  // namespace
}  // namespace imulab
