// Compressed texts and archives, as other programs wrote them (tests/recordings/packed_texts.py); cut, damaged, encrypted and hostile ones.
#include "imulab/formats/recording/archive/archive.hpp"

#include "imulab/core/memory.hpp"
#include "imulab/formats/recording/signals.hpp"

#include <fmt/core.h>

#include "tests/recording_files.hpp"
#include "tests/zip_file.hpp"

namespace imulab {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::vector<Column> walk_columns{"gx", "gy", "gz", "ax", "ay", "az"};
double walk_value(std::size_t i, std::size_t c) { return c < 3 ? fixture_gyro(i, c) : fixture_accel(i, c - 3); }

std::string packed_by_gzip(const std::string& text) {
  using recording_io::append;
  std::string file("\x1F\x8B\x08\0\0\0\0\0\0\x03", 10);
  file += deflated_text(text);
  append<std::uint32_t>(file, recording_io::crc32(text));
  append<std::uint32_t>(file, static_cast<std::uint32_t>(text.size()));
  return file;
}

/// Flags of the members' heads say that they are encrypted.
std::string marked_as_encrypted(std::string zip) {
  for (std::size_t at = zip.find("PK\3\4"); at != std::string::npos; at = zip.find("PK\3\4", at + 1)) zip[at + 6] = 1;
  for (std::size_t at = zip.find("PK\1\2"); at != std::string::npos; at = zip.find("PK\1\2", at + 1)) zip[at + 8] = 1;
  return zip;
}

TEST(PackedTexts, AreReadInEveryForm) {
  if (built_without({.file = recording_file("walk.csv.xz")})) GTEST_SKIP();
  for (const std::string ending : {"gz", "bz2", "xz", "zst", "lz4"}) {
    const TableRequest request{.file = recording_file("walk.csv." + ending)};
    expect_columns(request, walk_columns, walk_value);
    const SignalTable table = read_tables(request.file).front();
    EXPECT_EQ(table.topic, "") << ending;
    EXPECT_EQ(table.rows(), fixture_samples) << ending;
  }
}

/// One member after the other is one text, as gzip joins files; with or without libarchive.
TEST(PackedTexts, OfSeveralPartsAreOneText) {
  const TemporaryFolder folder;
  const auto file = folder.write("a.csv.gz", packed_by_gzip("t,x\n0,1\n") + packed_by_gzip("0.01,2\n"));
  expect_columns(
      {.file = file}, {"x"}, [](std::size_t i, std::size_t) { return static_cast<double>(i + 1); }, 2);
}

TEST(PackedTexts, OfAnArchiveAreEachARecording) {
  TableRequest request{.file = recording_file("walk.tar.xz")};
  if (built_without(request)) GTEST_SKIP();
  EXPECT_THAT(error_of(request, {"gx"}), AllOf(HasSubstr("walk.tar.xz"), HasSubstr("logs/evening"), HasSubstr("logs/morning")));
  EXPECT_THAT([&] { read_tables(request.file); },
              testing::ThrowsMessage<Error>(HasSubstr("several tables have both gyros and accelerometers by name; expected a topic of logs/")));
  request.topic = "logs/morning";
  expect_columns(request, walk_columns, walk_value);
}

/// Also where the text could be read to the place of the damage: each form but a tar has checksums.
TEST(PackedTexts, CutOrDamagedAreErrors) {
  const TemporaryFolder folder;
  const bool all = !built_without({.file = recording_file("walk.csv.xz")});
  for (const std::string ending : {"gz", "bz2", "xz", "zst", "lz4"}) {
    if (!all && ending != "gz") continue;
    const std::string whole = file_bytes(recording_file("walk.csv." + ending));
    for (const std::size_t size : {whole.size() / 2, whole.size() - 1})
      EXPECT_THAT(error_of({.file = folder.write("a.csv." + ending, whole.substr(0, size))}, {"gx"}),
                  AllOf(HasSubstr("a.csv." + ending), HasSubstr("cannot be unpacked: ")))
          << ending << " " << size;
    for (std::size_t at = 12; at < whole.size(); at += 7) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
      const auto file = folder.write("b.csv." + ending, damaged);
      if (error_of({.file = file}, {"gx"}) == "no error") expect_columns({.file = file}, walk_columns, walk_value);  // of what is not a reading
    }
  }
}

TEST(PackedTexts, AreRefusedWhereTheyAreEncrypted) {
  const TemporaryFolder folder;
  const auto zip = folder.write("log.zip", marked_as_encrypted(zip_file({{"log.csv", "t,x\n0,1\n"}})));
  if (built_without({.file = zip})) GTEST_SKIP();
  EXPECT_THAT(error_of({.file = zip}, {1}), HasSubstr("log.zip/log.csv: is encrypted; expected an archive without a password"));
}

TEST(PackedTexts, AreNotUnpackedBeyondTheMemoryAllowed) {
  const TemporaryFolder folder;
  std::string rows = "t,x\n";
  while (rows.size() < (1 << 22)) rows += "1,0000000000000000000000000000\n";
  const auto bomb = folder.write("bomb.csv.gz", packed_by_gzip(rows));
  ASSERT_LT(std::filesystem::file_size(bomb), rows.size() / 100);
  const MemoryLimit limit(std::uint64_t{1} << 22);
  EXPECT_THAT([&] { read_tables(bomb); }, testing::ThrowsMessage<MemoryError>(HasSubstr("bomb.csv: unpacking it takes about")));
}

}  // namespace
}  // namespace imulab
