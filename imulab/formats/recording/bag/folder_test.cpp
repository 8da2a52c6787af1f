// Bags of several files, and topics that hold one sensor alone.
#include "imulab/formats/recording/bag/folder.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/recording/bag/chunk.hpp"
#include "imulab/formats/recording/signals.hpp"

#include <gmock/gmock.h>

#include "tests/bag_fixture.hpp"
#include "tests/mcap_file.hpp"
#include "tests/temporary_folder.hpp"

namespace imulab::bag {
namespace {

using recording_io::TableRows;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// `count` messages from number `first` on, 5 ms apart; `gyro` and `accel` tell which readings are not zero.
std::vector<ImuMessage> messages(std::size_t first, std::size_t count, bool gyro = true, bool accel = true) {
  std::vector<ImuMessage> out;
  for (std::size_t i = first; i < first + count; ++i) {
    const double v = 0.25 * static_cast<double>(i);
    out.push_back({fixture_stamp(i), {gyro ? v : 0, gyro ? 1. : 0, gyro ? 2. : 0, accel ? v : 0, accel ? 3. : 0, accel ? 9.8 : 0}});
  }
  return out;
}

struct SplitBags : testing::Test {
  TemporaryFolder folder;
  std::filesystem::path part(const std::string& name, std::size_t first, std::size_t count) const {
    std::filesystem::create_directories((folder / name).parent_path());
    return folder.write(name, mcap_file({{"/imu", messages(first, count)}}));
  }
};

TEST_F(SplitBags, AreReadInTheOrderOfTheirNumbers) {
  part("run/run_10.mcap", 50, 10), part("run/run_2.mcap", 20, 30), part("run/run_0.mcap", 0, 20);
  for (const std::filesystem::path& path : {folder / "run", folder / "run/run_0.mcap+run_2.mcap+run_10.mcap"}) {
    const TableRows rows = read_columns(path, "/imu", {"header.stamp", "angular_velocity.x"});
    ASSERT_EQ(rows.size(), 60U) << path;
    for (std::size_t i = 0; i < 60; ++i) {
      ASSERT_EQ(rows.columns[0].integers[i], fixture_stamp(i));
      ASSERT_EQ(rows.columns[1].numbers[i], 0.25 * static_cast<double>(i));
    }
    EXPECT_THAT(rows.warnings, testing::IsEmpty());
    EXPECT_EQ(format_of({path, "", ""}).describe({path, "", ""}).front().rows, 60U);
  }
  EXPECT_EQ(file_sum(folder / "run").bytes, file_sum(folder / "run/run_0.mcap+run_2.mcap+run_10.mcap").bytes);
}

TEST_F(SplitBags, AreWhatTheirMetadataLists) {
  part("run/a_0.mcap", 0, 20), part("run/other.mcap", 0, 20);
  EXPECT_THAT([&] { SplitBag{folder / "run"}; }, ThrowsMessage<Error>(HasSubstr("holds several bags; expected one of its files: run/a_0.mcap")));
  folder.write("run/metadata.yaml",
               "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - a_0.mcap\n    - 'a_1.mcap'\n  duration:\n    - 1\n");
  const TableRows rows = read_columns(folder / "run", "", {"header.stamp"});
  EXPECT_EQ(rows.size(), 20U);
  EXPECT_THAT(rows.warnings, ElementsAre(HasSubstr("metadata.yaml lists a_1.mcap, which is not there: its messages are missing"),
                                         HasSubstr("other.mcap is not listed in metadata.yaml and was left out")));
  EXPECT_EQ(only_part(folder / "run"), folder / "run/a_0.mcap");
}

TEST_F(SplitBags, SayWhatIsWrong) {
  std::filesystem::create_directories(folder / "run");
  folder.write("run/metadata.yaml", "relative_file_paths:\n  - a_0.db3\n");
  EXPECT_THAT([&] { format_of({folder / "run", "", ""}); }, ThrowsMessage<Error>(HasSubstr("is a folder without a recording that is known here")));
  folder.write("run/a_0.db3.zstd", "\x28\xB5\x2F\xFD");
  folder.write("run/metadata.yaml", "relative_file_paths:\n  - a_0.db3.zstd\n");
  EXPECT_THAT([&] { SplitBag{folder / "run"}; }, ThrowsMessage<Error>(HasSubstr("is compressed as a whole; expected it unpacked: zstd -d")));
  std::string many = "relative_file_paths:\n";
  for (int i = 0; i < 30'000; ++i) many += "- x\n";
  EXPECT_EQ(listed_parts(many).size(), 10'000U) << "bounded";
}

std::vector<std::string> topics_taken(const std::vector<std::pair<std::string, std::vector<ImuMessage>>>& topics,
                                      std::vector<std::string>* notes = nullptr) {
  const TemporaryFolder folder;
  std::vector<std::string> taken;
  for (const SignalTable& table : read_tables(folder.write("x.mcap", mcap_file(topics)))) {
    taken.push_back(table.topic);
    if (notes != nullptr) notes->insert(notes->end(), table.notes.begin(), table.notes.end());
  }
  return taken;
}

TEST(Topics, OfZerosAreNotTaken) {
  std::vector<std::string> notes;
  EXPECT_THAT(topics_taken({{"/zero", messages(0, 40, false, false)}, {"/imu", messages(0, 40)}}, &notes), ElementsAre("/imu"));
  EXPECT_THAT(notes, ElementsAre("/zero: gyros and accelerometers are zero in every row: that topic was not taken for them"));
  EXPECT_THAT(topics_taken({{"/imu", messages(0, 40)}}), ElementsAre("/imu")) << "its name is always said";
  EXPECT_THAT(
      [] {
        topics_taken({{"/a", messages(0, 40)}, {"/b", messages(0, 40)}, {"/c", messages(0, 40, true, false)}});
      },
      ThrowsMessage<Error>(HasSubstr("several tables have both gyros and accelerometers by name; expected a topic of /a, /b")));
}

TEST(Topics, OfACamerasTwoSensorsAreJoined) {
  std::vector<std::string> notes;
  EXPECT_THAT(topics_taken({{"/accel", messages(0, 40, false, true)}, {"/gyro", messages(0, 40, true, false)}}, &notes),
              ElementsAre("/gyro", "/accel"));
  EXPECT_THAT(notes,
              testing::Contains("linear_acceleration.x, linear_acceleration.y, linear_acceleration.z are zero in every row and were left out"));
}

#ifdef IMULAB_WITH_ZSTD
TEST(Chunks, TakeNoMoreMemoryThanAllowed) {
  const std::string packed = pack(Compression::zstd, std::string(std::size_t{1} << 26, '\0'));
  EXPECT_LT(packed.size(), 10'000U);
  Buffer buffer;
  const MemoryLimit limit(std::uint64_t{1} << 25);
  EXPECT_THAT([&] { unpack(Compression::zstd, packed, std::uint64_t{1} << 26, buffer, "bomb.mcap"); },
              ThrowsMessage<MemoryError>(HasSubstr("bomb.mcap: unpacking a chunk of 64 MB takes about")));
}
#endif

}  // namespace
}  // namespace imulab::bag
