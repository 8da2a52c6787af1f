// Bags that are cut off, damaged or made to harm: an Error, or a warning with what could be read.
#include "imulab/error.hpp"
#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/recording/bag/chunk.hpp"
#include "imulab/formats/recording/bag/mcap.hpp"

#include <gmock/gmock.h>

#include "tests/bag_fixture.hpp"
#include "tests/run_command.hpp"
#include <algorithm>

namespace imulab::bag {
namespace {

using recording_io::TableRows;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

/// Reads, describes and copies a file: whatever it is, the end is a result or an Error. Gives the number of messages, or -1.
int outcome(const std::filesystem::path& file, bool always_said = true) {
  int messages = -1;
  const TableRequest request{file, "/imu0", ""};
  try {
    const RecordingFormat& format = format_of(request);
    format.describe(request);
    const TableRows table = recording_io::read_columns(request, imu_columns(), format);
    messages = static_cast<int>(table.columns[0].size());
    if (always_said && messages < static_cast<int>(fixture_samples)) {
      EXPECT_THAT(table.warnings, Not(IsEmpty())) << file << ": lost without a word";
    }
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr(file.filename().string()));
  }
  try {
    WholeFile out(file.string() + ".out");
    const Topic topic{"/imu0", "sensor_msgs/msg/Imu", file.extension() == ".bag" ? "ros1" : "cdr", {0, 1, 2}};
    rewrite_bag(
        file, topic, [](std::span<char>) {}, out);
  } catch (const Error&) {
  }
  return messages;
}

/// A new file each time: one that replaces another is flushed to the disk.
std::filesystem::path write_new(const TemporaryFolder& folder, const std::string& name, std::string_view text) {
  std::filesystem::remove(folder / name);
  return folder.write(name, text);
}

class BadBags : public testing::TestWithParam<std::string> {
 protected:
  std::filesystem::path write(std::string_view text) const { return write_new(folder_, "bad" + fixture(GetParam()).extension().string(), text); }

  TemporaryFolder folder_;
  const std::string bytes_ = read_text(fixture(GetParam()));
};
INSTANTIATE_TEST_SUITE_P(Fixtures, BadBags, testing::ValuesIn(fixture_names()), [](const auto& file) {
  std::string name = file.param;
  for (char& c : name) c = c == '.' ? '_' : c;
  return name;
});

TEST_P(BadBags, CutOffAnywhere) {
  const std::size_t step = bytes_.size() < 10000 ? 7 : 97;
  int most = 0;
  for (std::size_t size = 1; size < bytes_.size(); size += step) most = std::max(most, outcome(write(std::string_view(bytes_).substr(0, size))));
  if (bytes_.starts_with("SQLite")) return;  // which gives nothing of a file that is cut off
  EXPECT_GT(most, static_cast<int>(fixture_samples) / 2) << "what stands before the cut is read";
}

/// Lengths, counts, places, kinds: each byte is one of these somewhere.
TEST_P(BadBags, WithAnyByteChanged) {
  const std::size_t step = bytes_.size() < 10000 ? 23 : 131;
  const bool counted = bytes_.starts_with("\x89MCAP") && GetParam() != "imu_no_chunks.mcap" && GetParam() != "imu_bare.mcap";  // and has checksums
  for (const char wrong : {'\xFF', '\0'})
    for (std::size_t at = 0; at < bytes_.size(); at += step) {
      std::string bytes = bytes_;
      bytes[at] = bytes[at] == wrong ? '\x7F' : wrong;
      outcome(write(bytes), counted);
    }
}

TEST_P(BadBags, OfNothingElse) {
  EXPECT_EQ(outcome(write("#ROSBAG V1.2\n\x01\x02\x03")), -1);
  EXPECT_EQ(outcome(write(std::string_view("\x89MCAP1\r\n\0\0\0", 11))), -1);
  EXPECT_EQ(outcome(write(std::string_view("SQLite format 3\0 and nothing more", 33))), -1);
  EXPECT_EQ(outcome(write(bytes_.substr(0, 12) + std::string(5000, '\xFF'))), -1);
}

/// Indexes that lead to single messages, with wrong places in them.
TEST(BadBag, WithAnyByteOfItsIndexesChanged) {  // ctest: once
  const TemporaryFolder folder;
  for (const std::string& name : sparse_names()) {
    const std::string whole = read_text(fixture(name));
    const std::size_t messages = std::min(whole.size(), std::size_t{6000}), indexes = whole.size() - 3500;  // the picture is between them
    for (const char wrong : {'\xFF', '\0', '\x01'})
      for (std::size_t at = 0; at < whole.size(); at += at < messages || at > indexes ? 5 : 1000) {
        std::string bytes = whole;
        bytes[at] = wrong;
        outcome(write_new(folder, "bad" + fixture(name).extension().string(), bytes), false);
      }
  }
}

/// `from` replaced by `to` of the same length, everywhere.
std::string replaced(std::string bytes, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = bytes.find(from, at)) != std::string::npos; at += to.size()) bytes.replace(at, from.size(), to);
  return bytes;
}

TEST(BadBag, OfAnUnknownCompressionSaysSo) {
  const TemporaryFolder folder;
  const auto mcap = folder.write("a.mcap", replaced(read_text(fixture("imu_lz4.mcap")), "lz4", "lzx"));
  const auto ros1 = folder.write("a.bag", replaced(read_text(fixture("imu_lz4.bag")), "compression=lz4", "compression=lzx"));
  for (const auto& file : {mcap, ros1})
    EXPECT_THAT([&] { read_columns(file, "/imu0", {1}); }, ThrowsMessage<Error>(HasSubstr("unknown compression \"lzx\"")));
}

/// A chunk with a wrong checksum is left out, and said.
TEST(BadBag, AChunkWithAWrongChecksumIsLeftOut) {
  const TemporaryFolder folder;
  std::string bytes = read_text(fixture("imu_none.mcap"));
  bytes[bytes.find("imu", 9000)] = 'I';  // a frame's name in the second chunk or a later one
  const TableRows table = read_columns(folder.write("a.mcap", bytes), "/imu0", imu_columns());
  ASSERT_EQ(table.warnings.size(), 1u);
  EXPECT_THAT(table.warnings[0], HasSubstr("its checksum is wrong: left out: the messages in it are missing"));
  EXPECT_LT(table.columns[0].size(), fixture_samples);
  EXPECT_GT(table.columns[0].size(), fixture_samples / 2);
}

/// A recording that was not closed has no summary.
TEST(BadBag, AnUnfinishedMcapIsReadToItsEnd) {
  const TemporaryFolder folder;
  const std::string bytes = read_text(fixture("imu_zstd.mcap"));
  const Mcap whole(fixture("imu_zstd.mcap"));
  const auto file = folder.write("a.mcap", bytes.substr(0, whole.data_end()));
  const TableRows table = read_columns(file, "/imu0", imu_columns());
  EXPECT_EQ(table.columns[0].size(), fixture_samples);
  WholeFile out(folder / "b.mcap");
  EXPECT_THAT(
      [&] {
        rewrite_bag(
            file, whole.topics().front(), [](std::span<char>) {}, out);
      },
      ThrowsMessage<Error>(HasSubstr("mcap recover")));
}

/// A recorder that was stopped leaves no index, and a header that says so.
TEST(BadBag, ARos1BagThatWasNotClosedIsReadToItsEnd) {
  const TemporaryFolder folder;
  std::string bytes = read_text(fixture("imu_lz4.bag"));
  const std::size_t place = bytes.find("index_pos=") + 10;
  const auto index = load<std::uint64_t>(bytes.data() + place);
  store<std::uint64_t>(bytes.data() + place, 0);
  const auto file = folder.write("a.bag.active", bytes.substr(0, index));
  const TableRows table = read_columns(file, "", imu_columns());
  EXPECT_EQ(table.columns[0].size(), fixture_samples);
  ASSERT_EQ(table.warnings.size(), 1u);
  EXPECT_THAT(table.warnings[0], HasSubstr("the bag was not closed and has no index: read from its beginning"));
}

TEST(BadBag, AMessageTooShortNamesIt) {
  const TemporaryFolder folder;
  const auto file = folder / "a.db3";
  std::filesystem::copy_file(fixture("imu.db3"), file);
  ASSERT_EQ(run_shell(folder, "sqlite3 a.db3 'UPDATE messages SET data = substr(data, 1, 100) WHERE topic_id = 1 AND id > 20'").exit_code, 0);
  EXPECT_THAT([&] { read_columns(file, "/imu0", {1}); },
              ThrowsMessage<Error>(HasSubstr("a.db3: /imu0: message 18: it is too short for sensor_msgs/Imu")));
  ASSERT_EQ(run_shell(folder, "sqlite3 a.db3 \"UPDATE topics SET type = 'sensor_msgs/msg/Imu' WHERE id = 2\"").exit_code, 0);
  EXPECT_THAT([&] { read_columns(file, "/temp", {1}); }, ThrowsMessage<Error>(HasSubstr("message 1: it is too short")));
}

/// A chunk may promise any size: memory follows what is found.
TEST(BadBag, AChunkThatPromisesTooMuchAllocatesNothing) {
  for (const Compression compression : {Compression::lz4, Compression::zstd, Compression::bzip2}) {
    Buffer buffer;
    const std::string packed = pack(compression, "some bytes");
    EXPECT_EQ(unpack(compression, packed, 10, buffer), "some bytes");
    EXPECT_THROW(unpack(compression, packed, 9, buffer), Damaged);
    EXPECT_THROW(unpack(compression, packed, std::uint64_t{1} << 29, buffer), Damaged);
    EXPECT_THROW(unpack(compression, packed, std::uint64_t{1} << 60, buffer), Damaged);
    EXPECT_LE(buffer.size(), std::size_t{1} << 16);
    EXPECT_THROW(unpack(compression, "", 10, buffer), Damaged);
  }
}

TEST(Compression, OfLargeChunksGivesThemBack) {
  std::string bytes;
  for (std::uint32_t i = 0; i < 300000; ++i) bytes += static_cast<char>(i * i >> 7);
  for (const Compression compression : {Compression::none, Compression::lz4, Compression::zstd, Compression::bzip2}) {
    Buffer buffer;
    EXPECT_TRUE(unpack(compression, pack(compression, bytes), bytes.size(), buffer) == bytes);
    const std::string zeros(3'000'000, '\0');  // far smaller packed: memory grows step by step
    EXPECT_TRUE(unpack(compression, pack(compression, zeros), zeros.size(), buffer) == zeros);
  }
}

}  // namespace
}  // namespace imulab::bag
