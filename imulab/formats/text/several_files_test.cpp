#include "imulab/formats/text/several_files.hpp"

#include "imulab/formats/text/file.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"

namespace imulab {
namespace {

using testing::ElementsAre;

TEST(SeveralFiles, StandInTheOrderOfTheirNumbers) {
  EXPECT_TRUE(in_natural_order("run_2.bag", "run_10.bag"));
  EXPECT_FALSE(in_natural_order("run_10.bag", "run_2.bag"));
  EXPECT_TRUE(in_natural_order("a", "ab"));
  EXPECT_FALSE(in_natural_order("a1", "a1"));
  EXPECT_NE(in_natural_order("a01", "a1"), in_natural_order("a1", "a01")) << "one order, whatever is compared";
  EXPECT_TRUE(in_natural_order("9", "99999999999999999999999999")) << "of any length";
}

TEST(SeveralFiles, PartsOfOneBagAreOneRecording) {
  EXPECT_THAT(with_series_joined({"d/run_0.bag", "d/run_1.bag", "x.csv", "d/run_0.mcap"}),
              ElementsAre("d/run_0.bag+run_1.bag", "x.csv", "d/run_0.mcap"));
  EXPECT_THAT(with_series_joined({"a_0.bag", "b_1.bag", "a_1.csv", "a_2.csv", "7.bag", "8.bag"}),
              ElementsAre("a_0.bag", "b_1.bag", "a_1.csv", "a_2.csv", "7.bag", "8.bag"));
  EXPECT_THAT(with_series_joined({"night_1.bag", "night_2.bag", "x_0.bag", "x_2.bag"}),
              ElementsAre("night_1.bag", "night_2.bag", "x_0.bag", "x_2.bag"))
      << "two nights; a part is missing";
  EXPECT_THAT(
      with_series_joined({"r_0.db3", "r_1.db3", "r_10.db3", "r_2.db3", "r_3.db3", "r_4.db3", "r_5.db3", "r_6.db3", "r_7.db3", "r_8.db3", "r_9.db3"}),
      ElementsAre(testing::EndsWith("r_8.db3+r_9.db3+r_10.db3")))
      << "as a shell sorts them";
}

TEST(SeveralFiles, OfAFolderAreThoseThatMayHoldReadings) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "in/cam");
  folder.write("in/b.csv", "1"), folder.write("in/cam/a.csv", "22"), folder.write("in/cam/1.png", "333"), folder.write("in/b+c.csv", "4");
  EXPECT_THAT(files_of(folder / "in"), ElementsAre(folder / "in/b+c.csv", folder / "in/b.csv", folder / "in/cam/a.csv"));
  EXPECT_EQ(bytes_of(folder / "in"), 4U);
  EXPECT_EQ(file_sum(folder / "in").bytes, 4U);
  EXPECT_FALSE(is_several_files(folder / "in/b+c.csv")) << "a file that is there";
  EXPECT_FALSE(is_several_files(folder / "in/b.csv+none.csv"));
  EXPECT_EQ(without_slash("in/"), "in");
  EXPECT_EQ(without_slash("/"), "/");
  const std::string before = file_sum(folder / "in").sha256;
  folder.write("in/cam/a.csv", "23");
  EXPECT_NE(file_sum(folder / "in").sha256, before);
}

}  // namespace
}  // namespace imulab
