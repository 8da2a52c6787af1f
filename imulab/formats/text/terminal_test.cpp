#include "imulab/formats/text/terminal.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <string>
#include <thread>
#include <unistd.h>

namespace imulab {
namespace {

/// The output of `work` on standard error, where that is a terminal.
template <class Work>
std::string on_terminal(const Work& work) {
  const int controller = ::posix_openpt(O_RDWR | O_NOCTTY);
  if (controller < 0 || ::grantpt(controller) != 0 || ::unlockpt(controller) != 0) return "no terminal";
  const int terminal = ::open(::ptsname(controller), O_RDWR | O_NOCTTY);
  const int before = ::dup(STDERR_FILENO);
  ::dup2(terminal, STDERR_FILENO);
  work();
  ::dup2(before, STDERR_FILENO);
  ::close(before), ::close(terminal);
  std::string text(65536, '\0');
  const ssize_t n = ::read(controller, text.data(), text.size());
  text.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  ::close(controller);
  return text;
}

void wait_s(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

TEST(ProgressLine, ShowsHowLongTheReadingOfAFileWillTake) {
  const std::string text = on_terminal([] {
    const Progress progress("inspecting");
    const ReadingMeter file(100);
    std::thread([&] { file.add(25); }).join();  // whichever thread counts
    wait_s(1.1);
  });
  // 1 to 1.1 s for a quarter: 3 to 4 s for the others, rounded up.
  EXPECT_THAT(text, testing::ContainsRegex("reading: 25 %, [34] s left")) << text;
}

TEST(ProgressLine, ShowsTheWorkAgainAfterTheReading) {
  const std::string text = on_terminal([] {
    const Progress progress("inspecting");
    {
      const ReadingMeter file(100);
      file.add(100);
    }
    wait_s(1.1);
  });
  EXPECT_THAT(text, testing::HasSubstr("inspecting: 1 s")) << text;
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("reading")));
}

TEST(ProgressLine, PartsThatWorkReportsComeFirst) {
  const std::string text = on_terminal([] {
    Progress progress("calibrating", 4);
    progress.report(1);
    const ReadingMeter file(100);
    file.add(80);
    wait_s(1.1);
  });
  EXPECT_THAT(text, testing::ContainsRegex("calibrating: 25 %, [34] s left")) << text;
}

TEST(ReadingMeter, CountsForTheOutermostOfAThread) {
  ReadingCounts counts;
  {
    const WatchedReading watched(counts);
    const ReadingMeter file(10);
    file.add(4);
    {
      const ReadingMeter part(5);
      part.add(5);
    }
    EXPECT_EQ(counts.all, 10U);
    EXPECT_EQ(counts.done, 4U);
    std::thread([&] {
      const ReadingMeter other(7);
      EXPECT_EQ(counts.all, 10U) << "of another thread";
    }).join();
  }
  EXPECT_EQ(counts.all, 0U);
  EXPECT_EQ(counts.finished, 4U);
  const ReadingMeter nobody(3);
  nobody.add(3);
  EXPECT_EQ(counts.finished, 4U) << "nobody looks any more";
}

}  // namespace
}  // namespace imulab
