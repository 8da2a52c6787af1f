// Files that are no usual files, and files that another program changes.
#include "imulab/error.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/unfinished.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <fcntl.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace imulab {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(Reading, ALongFileIsMappedAndAShortOneCopied) {
  const TemporaryFolder folder;
  for (const std::size_t size : {most_copied, most_copied + 1}) {
    std::string text(size, 'a');
    text.back() = 'z';
    const fs::path file = folder.write("x", text);
    const MappedFile mapped(file);
    mapped.release(size);
    EXPECT_EQ(mapped.text(), text);
  }
}

/// A copy does not change with the file; lost pages of a mapped one end the program in good order: with a message, exit code 2 and nothing half made.
TEST(Reading, AFileThatBecomesShorter) {
  const TemporaryFolder folder;
  const fs::path small = folder.write("small", "abc"), large = folder.write("large", std::string(most_copied + 1, 'a'));
  const MappedFile copied(small);
  fs::resize_file(small, 0);
  EXPECT_EQ(copied.text(), "abc");
  const auto lose_it = [&] {
    remove_unfinished_on_signals();
    WholeFile output(folder / "output");
    const MappedFile mapped(large);
    fs::resize_file(large, 0);
    if (mapped.text()[most_copied / 2] == 'a') std::_Exit(0);
  };
  EXPECT_EXIT(lose_it(), testing::ExitedWithCode(2),
              "imulab: .*large: became shorter while it was read; expected a file that no other program changes");
  for (const auto& entry : fs::directory_iterator(folder.path())) EXPECT_EQ(entry.path().filename().string().find("output"), std::string::npos);
}

TEST(Reading, AnotherBusErrorEndsTheProgramAsAlways) {
  EXPECT_EXIT((remove_unfinished_on_signals(), ::raise(SIGBUS), ::raise(SIGBUS)), testing::KilledBySignal(SIGBUS), "");
}

TEST(Reading, APipeNeedsAWriterAndMayBeSlow) {  // ctest: once
  const TemporaryFolder folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT([&] { MappedFile{pipe}; }, testing::ThrowsMessage<Error>(HasSubstr("pipe: nobody writes to this pipe; expected a writer within 5 s")));
  std::thread writer([&] {
    const int end = ::open(pipe.c_str(), O_WRONLY);
    for (const char* piece : {"a", "bc"}) {
      ::usleep(300'000);  // longer than the reader looks for data at a time
      EXPECT_GT(::write(end, piece, std::string_view(piece).size()), 0);
    }
    ::close(end);
  });
  EXPECT_EQ(MappedFile(pipe).text(), "abc");
  writer.join();
}

TEST(Reading, SettingsAreShort) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("x", "");
  fs::resize_file(file, longest_settings);
  EXPECT_EQ(MappedFile(file, Content::settings).text().size(), longest_settings);
  fs::resize_file(file, longest_settings + 1);
  EXPECT_THAT([&] { MappedFile(file, Content::settings); }, testing::ThrowsMessage<Error>(HasSubstr("x: is longer than 64 MiB; expected less")));
  EXPECT_THAT([&] { MappedFile("/dev/zero", Content::settings); }, testing::ThrowsMessage<Error>(HasSubstr("/dev/zero: is longer than 64 MiB")));
}

TEST(Reading, AnUnfinishedLinkLeadsToItsFile) {
  const TemporaryFolder folder;
  fs::create_symlink("later", folder / "a");
  fs::create_symlink("a", folder / "b");
  fs::create_symlink("loop", folder / "loop");
  EXPECT_EQ(behind_links(folder / "b"), folder / "later");
  EXPECT_EQ(behind_links(folder / "loop"), folder / "loop");
  EXPECT_EQ(behind_links("none"), "none");
}

}  // namespace
}  // namespace imulab
