#include "imulab/core/shared_work.hpp"

#include "imulab/core/build.hpp"
#include "imulab/core/checkpoint_folder.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/parallel.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace imulab {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::string result_of(std::size_t part) { return std::string(part % 7, 'x') + std::to_string(part * part); }

std::string identity_of(std::size_t count) { return work_identity("squares", {{"runs", std::to_string(count)}}); }

/// All results in the order in which they were taken; `done` counts the parts that were worked on.
std::string together(std::size_t count, const Checkpoint* checkpoint, std::atomic<int>* done = nullptr, int microseconds = 0) {
  std::string all;
  SharedWork work{.count = count, .work = {}, .take = {}};
  work.work = [&](std::size_t part) {
    if (done != nullptr) ++*done;
    if (microseconds > 0) std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
    return result_of(part);
  };
  work.take = [&](std::size_t part, const std::string& result) { all += std::to_string(part) + ":" + result + "\n"; };
  if (checkpoint == nullptr) {
    for_each(work);
    return all;
  }
  Checkpoint identified = *checkpoint;
  identified.identity = identity_of(count);
  for_each(work, &identified);
  return all;
}

std::string expected(std::size_t count) {
  std::string all;
  for (std::size_t part = 0; part < count; ++part) all += std::to_string(part) + ":" + result_of(part) + "\n";
  return all;
}

TEST(SharedWork, TakesEveryPartOnceInOrder) {
  for (const std::size_t count : {0u, 1u, 2u, 1000u}) {
    EXPECT_EQ(together(count, nullptr), expected(count));
    const TemporaryFolder folder;
    const Checkpoint here{folder / "work"};
    std::atomic<int> done = 0;
    EXPECT_EQ(together(count, &here, &done), expected(count));
    EXPECT_EQ(static_cast<std::size_t>(done), count);
    EXPECT_EQ(together(count, &here, &done), expected(count));  // nothing is left to do
    EXPECT_EQ(static_cast<std::size_t>(done), count);
  }
}

TEST(SharedWork, MorePartsThanClaims) {
  const TemporaryFolder folder;
  const Checkpoint here{folder / "work"};
  std::atomic<int> done = 0;
  EXPECT_EQ(together(25'000, &here, &done), expected(25'000));
  EXPECT_EQ(done, 25'000);
}

TEST(SharedWork, GoesOnWhereItWasKilled) {
  const TemporaryFolder folder;
  const Checkpoint here{folder / "work"};
  const auto kept = [&] {
    std::error_code no_folder_yet;
    const fs::directory_iterator entries(here.folder, no_folder_yet);
    return std::any_of(begin(entries), end(entries),
                       [](const auto& entry) { return entry.path().filename().string().starts_with("results-") && entry.file_size() > 0; });
  };
  for (int k = 0; k < 10 || (k < 1000 && !kept()); ++k) {  // a busy machine takes longer to the first result
    const pid_t child = fork();
    if (child == 0) {
      const ThreadLimit one(1);  // the threads of the parent are not in the child
      together(400, &here, nullptr, 500);
      _exit(0);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5 + 3 * k));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
  }
  std::atomic<int> done = 0;
  EXPECT_EQ(together(400, &here, &done), expected(400));
  EXPECT_LT(done, 400) << "nothing was kept";
}

TEST(SharedWork, ProcessesShareIt) {
  const TemporaryFolder folder;
  const Checkpoint here{folder / "work"};
  std::vector<pid_t> children;
  for (int k = 0; k < 5; ++k) {
    children.push_back(fork());
    if (children.back() != 0) continue;
    const ThreadLimit one(1);
    std::atomic<int> done = 0;
    const bool right = together(300, &here, &done, 1000) == expected(300);
    _exit(!right ? 100 : std::min(static_cast<int>(done), 99));
  }
  int most = 0;
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_LT(WEXITSTATUS(status), 100);
    most = std::max(most, WEXITSTATUS(status));
  }
  EXPECT_LT(most, 99) << "one process did a third of the work or more";
}

TEST(SharedWork, RunsMadeApartAreMerged) {
  const TemporaryFolder folder;
  const Checkpoint a{folder / "a"}, b{folder / "b"};
  {
    CheckpointFolder first(a.folder, identity_of(100)), second(b.folder, identity_of(100));
    for (std::size_t part = 0; part < 100; ++part) (part % 2 == 0 ? first : second).append(part, result_of(part));
  }
  std::atomic<int> done = 0;
  const Checkpoint both{folder / "both", {a.folder, b.folder}};
  EXPECT_EQ(together(100, &both, &done), expected(100));
  EXPECT_EQ(done, 0);
}

TEST(SharedWork, DamagedResultsAreDoneAgain) {
  const TemporaryFolder folder;
  const Checkpoint here{folder / "work"};
  together(50, &here);
  for (const auto& entry : fs::directory_iterator(here.folder)) {
    if (!entry.path().filename().string().starts_with("results-")) continue;
    const auto size = fs::file_size(entry.path());
    std::fstream(entry.path(), std::ios::in | std::ios::out | std::ios::binary).seekp(static_cast<std::streamoff>(size / 2)) << "damage";
    fs::resize_file(entry.path(), size - 3);
  }
  std::atomic<int> done = 0;
  EXPECT_EQ(together(50, &here, &done), expected(50));
  EXPECT_GT(done, 0);
}

TEST(SharedWork, AnotherWorksFolderIsRefused) {
  const TemporaryFolder folder;
  const Checkpoint here{folder / "work"};
  together(50, &here);
  EXPECT_THAT([&] { together(51, &here); }, ThrowsMessage<Error>(HasSubstr("is the checkpoint of another run")));
  const Checkpoint merged{folder / "new", {here.folder}};
  EXPECT_THAT([&] { together(51, &merged); }, ThrowsMessage<Error>(HasSubstr("is the checkpoint of another run")));
  fs::create_directory(folder / "mine");
  std::ofstream(folder / "mine/thesis.tex") << "text";
  const Checkpoint mine{folder / "mine"};
  EXPECT_THAT([&] { together(50, &mine); }, ThrowsMessage<Error>(HasSubstr("is no checkpoint")));
  const Checkpoint file{folder / "mine/thesis.tex"};
  EXPECT_THROW(together(50, &file), Error);
}

TEST(SharedWork, WhatAPartThrowsIsThrown) {
  SharedWork work{.count = 100, .work = {}, .take = [](std::size_t, const std::string&) {}};
  work.work = [](std::size_t part) -> std::string {
    if (part == 50) throw Error("part 50");
    return "";
  };
  EXPECT_THAT([&] { for_each(work); }, ThrowsMessage<Error>(HasSubstr("part 50")));
  const TemporaryFolder folder;
  Checkpoint here{.folder = folder / "work"};
  EXPECT_THAT([&] { for_each(work, &here); }, ThrowsMessage<Error>(HasSubstr("the work has no identity")));
  here.identity = "x";
  EXPECT_THAT([&] { for_each(work, &here); }, ThrowsMessage<Error>(HasSubstr("part 50")));
}

TEST(SharedWork, NoFlippedBitGivesAnotherResult) {
  const TemporaryFolder folder;
  constexpr std::size_t parts = 3;
  {
    CheckpointFolder made(folder / "work", identity_of(parts));
    for (std::size_t part = 0; part < parts; ++part) made.append(part, result_of(part));
  }
  fs::path file;
  for (const auto& entry : fs::directory_iterator(folder / "work"))
    if (entry.path().filename().string().starts_with("results-")) file = entry.path();
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  for (std::size_t bit = 0; bit < 8 * bytes.str().size(); ++bit) {
    std::string flipped = bytes.str();
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
    std::ofstream(file, std::ios::binary) << flipped;
    std::size_t taken = 0;
    CheckpointFolder::read(folder / "work", identity_of(parts), [&](std::size_t part, const std::string& result) {
      EXPECT_EQ(result, result_of(part)) << "part " << part << ", bit " << bit;
      ++taken;
    });
    EXPECT_LT(taken, parts) << "bit " << bit;  // the record counts as one that is not there
  }
}

TEST(SharedWork, ALinkInItsFolderIsNotFollowed) {
  const TemporaryFolder folder;
  const Checkpoint here{folder / "work"};
  std::ofstream(folder / "victim") << "thesis";
  fs::create_directory(here.folder);
  fs::create_symlink(folder / "victim", here.folder / fmt::format("identity.{}", getpid()));
  EXPECT_EQ(together(5, &here), expected(5));
  std::string text;
  std::ifstream(folder / "victim") >> text;
  EXPECT_EQ(text, "thesis");
}

TEST(SharedWork, FieldsOfAnIdentityStayApart) {
  const std::string one = work_identity("fleet", {{"station", "A B"}, {"operator", "C"}});
  EXPECT_NE(one, work_identity("fleet", {{"station", "A"}, {"operator", "B C"}}));
  EXPECT_NE(one, work_identity("plan", {{"station", "A B"}, {"operator", "C"}}));
  EXPECT_NE(work_identity("fleet", {{"station", "A\noperator=C"}}), work_identity("fleet", {{"station", "A"}, {"operator", "C"}}));
  EXPECT_NE(work_identity("fleet", {{"station", "\\n"}}), work_identity("fleet", {{"station", "\n"}}));
  EXPECT_THAT(one, HasSubstr("\nversion=" + build().version + "\n"));
}

TEST(SharedWork, ARefusalNamesWhatDiffers) {
  const TemporaryFolder folder;
  const CheckpointFolder made(folder / "work", identity_of(50));
  EXPECT_THAT([&] { CheckpointFolder(folder / "work", identity_of(51)); },
              ThrowsMessage<Error>(HasSubstr("is the checkpoint of another run (its \"runs\" differs)")));
}

}  // namespace
}  // namespace imulab
