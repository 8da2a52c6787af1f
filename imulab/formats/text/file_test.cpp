#include "imulab/formats/text/file.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.hpp"
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace imulab {
namespace {

using testing::HasSubstr;

TEST(File, HashesThePublishedVectors) {  // FIPS 180-4 examples and the empty message
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"), "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmnopqrstnopqrstu"),
            "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
  EXPECT_EQ(sha256(std::string(1'000'000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(File, HashesAlikeWithAndWithoutTheProcessorsInstructions) {
  std::string text;
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(sha256(text), sha256(text, false)) << text.size();
    text += static_cast<char>(37 * i);
  }
}

TEST(File, HashesFilesPieceByPiece) {
  const TemporaryFolder folder;
  for (const std::size_t size : {0, 1, 1 << 22, (1 << 22) + 63, 3 << 22, 10'000'001}) {
    std::string text(size, 'a');
    if (size > 0) text.back() = 'b';
    write_whole(folder / "x", text);
    const FileSum sum = file_sum(folder / "x");
    EXPECT_EQ(sum.sha256, sha256(text, false)) << size;
    EXPECT_EQ(sum.bytes, size);
  }
  EXPECT_THROW(file_sum(folder / "none"), Error);
}

TEST(File, ReadsWhatWasWritten) {
  const TemporaryFolder folder;
  const std::string text("a\0b\n", 4);
  write_whole(folder / "x", text);
  EXPECT_EQ(MappedFile(folder / "x").text(), text);
  write_whole(folder / "x", "");  // replaces, and an empty file cannot be mapped but can be read
  EXPECT_EQ(MappedFile(folder / "x").text(), "");
}

TEST(File, AppearsWholeOrNotAtAll) {
  const TemporaryFolder folder;
  write_whole(folder / "kept", "old");
  {
    WholeFile file(folder / "kept");
    file.write("half of the new");
  }
  EXPECT_EQ(MappedFile(folder / "kept").text(), "old");
  std::filesystem::create_directory(folder / "directory");
  EXPECT_THROW(write_whole(folder / "directory", "x"), Error);  // the rename fails
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) files += entry.is_regular_file();
  EXPECT_EQ(files, 1) << "a temporary file was left behind";
}

/// As -o /dev/null: the rename that makes files whole would put a file in the device's place.
TEST(File, APipeOrDeviceStaysWhatItIs) {
  const TemporaryFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_whole(pipe, "abc");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  char text[4] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 3);
  EXPECT_STREQ(text, "abc");
  ::close(reader);
}

TEST(File, NamesWhatCannotBeRead) {
  const TemporaryFolder folder;
  EXPECT_THAT([&] { MappedFile(folder / "missing"); }, testing::ThrowsMessage<Error>(HasSubstr("missing: cannot be opened: No such file")));
  EXPECT_THAT([&] { MappedFile(folder.path()); }, testing::ThrowsMessage<Error>(HasSubstr("is a folder; expected a file")));
  EXPECT_THAT([&] { write_whole(folder / "no" / "x", "x"); }, testing::ThrowsMessage<Error>(HasSubstr("cannot be written: No such file")));
}

TEST(File, FollowsLinksAndKeepsModes) {
  const TemporaryFolder folder;
  write_whole(folder / "real", "a");
  ASSERT_EQ(::chmod((folder / "real").c_str(), 0600), 0);
  std::filesystem::create_symlink("real", folder / "link");
  write_whole(folder / "link", "b");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(MappedFile(folder / "real").text(), "b");
  EXPECT_EQ(std::filesystem::status(folder / "real").permissions(), std::filesystem::perms(0600));
  std::filesystem::create_symlink("later", folder / "dangling");
  write_whole(folder / "dangling", "c");
  EXPECT_EQ(MappedFile(folder / "later").text(), "c");
}

TEST(File, AFolderThatExistsGetsAllNewFilesOrNone) {
  const TemporaryFolder folder;
  const auto names = [&] {
    std::set<std::string> out;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "out"))
      out.insert(entry.path().lexically_relative(folder / "out").string());
    return out;
  };
  std::filesystem::create_directories(folder / "out");
  write_whole(folder / "out/old", "old");
  write_whole(folder / "out/a", "old");
  ASSERT_EQ(::chmod((folder / "out/a").c_str(), 0600), 0);
  EXPECT_THROW(NewFolder(folder / "out"), Error);
  const auto fill = [&](bool whole) {
    NewFolder filled(folder / "out", NewFolder::Existing::add);
    for (const char* name : {"a", "b"}) write_whole(filled.path() / name, "new");
    EXPECT_EQ(MappedFile(folder / "out/a").text(), "old");
    EXPECT_FALSE(std::filesystem::exists(folder / "out/b"));
    if (whole) filled.commit();
  };
  fill(false);
  EXPECT_EQ(names(), (std::set<std::string>{"a", "old"}));
  fill(true);
  EXPECT_EQ(names(), (std::set<std::string>{"a", "b", "old"}));
  EXPECT_EQ(MappedFile(folder / "out/a").text(), "new");
  EXPECT_EQ(std::filesystem::status(folder / "out/a").permissions(), std::filesystem::perms(0600));
}

TEST(File, AFolderThatExistsHasLinksToOtherDisks) {
  const TemporaryFolder folder;
  char other[] = "/dev/shm/imulab-XXXXXX";  // another disk, where there is one
  const bool there = ::mkdtemp(other) != nullptr;
  const std::filesystem::path far = there ? std::filesystem::path(other) : folder / "far";
  std::filesystem::create_directories(far);
  std::filesystem::create_directories(folder / "out/place");
  write_whole(far / "b", "old");
  std::filesystem::create_symlink(far / "b", folder / "out/b");
  const auto add = [&](const std::vector<std::string>& names) {
    NewFolder filled(folder / "out", NewFolder::Existing::add);
    for (const std::string& name : names) write_whole(filled.path() / name, "new");
    filled.commit();
  };
  EXPECT_THAT([&] { add({"a", "b", "place"}); }, testing::ThrowsMessage<Error>(HasSubstr("place: cannot be written")));  // a folder
  std::filesystem::create_symlink("gone/c", folder / "out/c");                                                           // a link into no folder
  EXPECT_THAT([&] { add({"a", "b", "c"}); }, testing::ThrowsMessage<Error>(HasSubstr("c: cannot be written")));
  EXPECT_FALSE(std::filesystem::exists(folder / "out/a"));
  EXPECT_EQ(MappedFile(far / "b").text(), "old");
  add({"a", "b"});
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "out/b"));
  for (const std::filesystem::path& file : {far / "b", folder / "out/a"}) EXPECT_EQ(MappedFile(file).text(), "new");
  const auto count = [](const std::filesystem::path& place) { return std::distance(std::filesystem::directory_iterator(place), {}); };
  EXPECT_EQ(count(far), 1);
  EXPECT_EQ(count(folder / "out"), 4);
  std::filesystem::remove_all(far);
}

}  // namespace
}  // namespace imulab
