#include "imulab/files.hpp"
#include "imulab/procedure.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"

namespace imulab {
namespace {

Session parse(const std::string& text) {
  const TemporaryFolder folder;
  return read_session(folder.write("session.toml", text));
}

TEST(SessionFile, MountsAndSetPointsStayUntilTheyChange) {
  const std::string spin = "[[step]]\nkind = \"spin\"\nduration_s = 30\nrate_dps = 100\n", hold = "[[step]]\nkind = \"hold\"\nduration_s = 5\n";
  const Session s =
      parse("format = \"imulab.session/1\"\n" + hold + spin + "up = \"-x\"\noutward = \"+y\"\n" + hold + "temperature_degC = 40\n" + spin);
  EXPECT_FALSE(s.steps[0].mount);
  for (const std::size_t k : {1u, 2u, 3u}) EXPECT_EQ(s.steps[k].mount, (Mount{{0, -1}, {1, 1}}));
  EXPECT_FALSE(s.steps[1].temperature);
  EXPECT_EQ(s.steps[3].temperature, 40);
  const Session dai = dai_unit_procedure({.both_ways = true});
  const std::string text = procedure_text(dai);
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("start_s")));
  const Session read = parse(text);
  ASSERT_EQ(read.steps.size(), 29u + 246 + 42);
  for (std::size_t k = 0; k < dai.steps.size(); ++k) {
    EXPECT_NEAR(read.steps[k].start, dai.steps[k].start, 1e-9);  // sums of decimal durations
    EXPECT_EQ(read.steps[k].mount, dai.steps[k].mount);
    EXPECT_EQ(read.steps[k].temperature, dai.steps[k].temperature);
    EXPECT_EQ(read.steps[k].radius, dai.steps[k].radius);
    EXPECT_NEAR(read.steps[k].rate, dai.steps[k].rate, 1e-15);
  }
  EXPECT_EQ(read.recordings, dai.recordings);
  EXPECT_EQ(read.rigs, dai.rigs);
}

}  // namespace
}  // namespace imulab
