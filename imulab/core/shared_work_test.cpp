#include "imulab/core/shared_work.hpp"

#include "imulab/core/checkpoint_file.hpp"
#include "imulab/core/part_file.hpp"
#include "imulab/error.hpp"
#include "imulab/parallel.hpp"
#include "imulab/version.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace imulab {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::string result_of(std::size_t block) { return std::string(block % 7, 'x') + std::to_string(block * block); }

std::string identity_of(std::size_t count) { return work_identity("squares", {{"runs", std::to_string(count)}}); }

/// All results in the order in which they were taken; `done` counts the blocks that were worked on.
std::string together(std::size_t count, Sharing sharing = {}, std::atomic<int>* done = nullptr, int microseconds = 0) {
  std::string all;
  SharedWork work{.count = count, .work = {}, .take = {}};
  work.work = [&](std::size_t block) {
    if (done != nullptr) ++*done;
    if (microseconds > 0) std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
    return result_of(block);
  };
  work.take = [&](std::size_t block, const std::string& result) { all += std::to_string(block) + ":" + result + "\n"; };
  sharing.identity = identity_of(count);
  for_each(work, &sharing);
  return all;
}

std::string expected(std::size_t count) {
  std::string all;
  for (std::size_t block = 0; block < count; ++block) all += std::to_string(block) + ":" + result_of(block) + "\n";
  return all;
}

Sharing kept_in(const fs::path& folder) { return {.checkpoint = folder}; }

/// The file of a part, with `more` works behind the first.
std::string part_of(std::size_t number, std::size_t of, std::size_t count, int more = 0) {
  const auto part = std::make_shared<PartWriter>(PartNumber{number, of}, "squares");
  for (int work = 0; work <= more; ++work) EXPECT_THROW(together(count, {.part = part}), PartIsDone);
  return part->bytes();
}

Sharing joined_of(const std::vector<std::string>& parts) {
  std::vector<PartReader::Source> sources;
  for (const std::string& bytes : parts) sources.push_back(PartReader::memory("part " + std::to_string(sources.size() + 1), bytes));
  return {.joined = std::make_shared<PartReader>(std::move(sources))};
}

std::string text_in(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

TEST(SharedWork, TakesEveryBlockOnceInOrder) {
  for (const std::size_t count : {0u, 1u, 2u, 1000u}) {
    EXPECT_EQ(together(count), expected(count));
    const TemporaryFolder folder;
    std::atomic<int> done = 0;
    EXPECT_EQ(together(count, kept_in(folder / "work"), &done), expected(count));
    EXPECT_EQ(static_cast<std::size_t>(done), count);
    EXPECT_EQ(together(count, kept_in(folder / "work"), &done), expected(count));  // nothing is left to do
    EXPECT_EQ(static_cast<std::size_t>(done), count);
  }
}

TEST(SharedWork, GoesOnWhereItWasKilled) {
  const TemporaryFolder folder;
  const auto kept = [&] {
    std::error_code no_file_yet;
    const auto size = fs::file_size(folder / "work/results", no_file_yet);
    return !no_file_yet && size > 1000;
  };
  for (int k = 0; k < 20 || (k < 1000 && !kept()); ++k) {  // a busy machine takes longer to the first result
    const pid_t child = fork();
    if (child == 0) {
      const ThreadLimit one(1);  // the threads of the parent are not in the child
      together(400, kept_in(folder / "work"), nullptr, 500);
      _exit(0);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5 + 3 * k));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
  }
  std::atomic<int> done = 0;
  EXPECT_EQ(together(400, kept_in(folder / "work"), &done), expected(400));
  EXPECT_LT(done, 400) << "nothing was kept";
}

TEST(SharedWork, PartsInAnyOrderAreTheWhole) {
  for (const std::size_t count : {0u, 1u, 5u, 100u})
    for (const std::size_t of : {1u, 2u, 8u}) {
      std::vector<std::string> parts;
      for (std::size_t k = 1; k <= of; ++k) parts.push_back(part_of(k, of, count));
      std::rotate(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(of / 2), parts.end());
      std::atomic<int> done = 0;
      const Sharing joined = joined_of(parts);
      EXPECT_EQ(together(count, joined, &done), expected(count)) << count << " in " << of;
      EXPECT_EQ(done, 0);
      EXPECT_EQ(together(3, joined, &done), expected(3)) << "a work that follows is done";
    }
  const Sharing both = joined_of({part_of(1, 2, 9, 1), part_of(2, 2, 9, 1)});
  for (int work = 0; work < 2; ++work) EXPECT_EQ(together(9, both), expected(9)) << "of several works in one file";
}

TEST(SharedWork, APartGoesOnWhereItWasEnded) {
  const TemporaryFolder folder;
  std::atomic<int> done = 0;
  for (int k = 0; k < 2; ++k) {
    const auto part = std::make_shared<PartWriter>(PartNumber{2, 4}, "squares");
    EXPECT_THROW(together(40, {.checkpoint = folder / "work", .part = part}, &done), PartIsDone);
    EXPECT_EQ(part->bytes(), part_of(2, 4, 40));
  }
  EXPECT_EQ(done, 10);
}

TEST(SharedWork, PartsThatDoNotBelongTogetherAreNamed) {
  const std::string one = part_of(1, 3, 9), two = part_of(2, 3, 9), three = part_of(3, 3, 9);
  const auto joining = [](std::vector<std::string> parts, std::size_t count = 9) { return [=] { together(count, joined_of(parts)); }; };
  EXPECT_THAT(joining({one, three}), ThrowsMessage<Error>(HasSubstr("of 3 parts these are missing: 2")));
  EXPECT_THAT(joining({part_of(7, 100, 9)}), ThrowsMessage<Error>(HasSubstr("missing: 1, 2, 3, 4, 5, 6, 8, 9, 10, 11 and 89 more")));
  EXPECT_THAT(joining({one, two, two, three}), ThrowsMessage<Error>(HasSubstr("part 2, part 3: both are part 2")));
  EXPECT_THAT(joining({one, two, part_of(4, 4, 9)}), ThrowsMessage<Error>(HasSubstr("part 3: is one of 4 parts, part 1 one of 3")));
  EXPECT_THAT(joining({one, two, part_of(3, 3, 10)}), ThrowsMessage<Error>(HasSubstr("part 3: is a part of another run (its \"runs\" differs)")));
  EXPECT_THAT(joining({one, two, three}, 10), ThrowsMessage<Error>(HasSubstr("part 1: is a part of another run (its \"runs\" differs)")));
  EXPECT_THAT(joining({one, "part 2", three}), ThrowsMessage<Error>(HasSubstr("part 2: is no part of a work")));
  EXPECT_THAT(joining({one, two, part_of(3, 3, 9, 1)}), ThrowsMessage<Error>(HasSubstr("part 3: is a part of another command than part 1")));
  const auto other = std::make_shared<PartWriter>(PartNumber{3, 3}, "cubes");
  EXPECT_THROW(together(9, {.part = other}), PartIsDone);
  EXPECT_THAT(joining({one, two, other->bytes()}), ThrowsMessage<Error>(HasSubstr("part 3: is a part of another command than part 1")));
}

TEST(SharedWork, NoChangedByteOfAPartIsAccepted) {
  const std::string first = part_of(1, 2, 20), second = part_of(2, 2, 20);
  std::mt19937 random(1);
  for (int k = 0; k < 1000; ++k) {
    std::string changed = second;
    const std::size_t at = random() % changed.size();
    if (k % 4 == 0)
      changed.resize(at);
    else if (k % 4 == 1)
      changed.insert(at, 1, static_cast<char>(random()));
    else
      changed[at] = static_cast<char>(changed[at] ^ (1 << random() % 8));
    EXPECT_THROW(together(20, joined_of({first, changed})), Error) << "change " << k << " at byte " << at;
  }
}

TEST(SharedWork, NoFlippedBitOfACheckpointGivesAnotherResult) {
  const TemporaryFolder folder;
  together(3, kept_in(folder / "work"));
  const std::string whole = text_in(folder / "work/results");
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    std::string flipped = whole;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
    std::ofstream(folder / "work/results", std::ios::binary) << flipped;
    std::atomic<int> done = 0;
    try {
      EXPECT_EQ(together(3, kept_in(folder / "work"), &done), expected(3)) << "bit " << bit;
      EXPECT_GT(done, 0) << "bit " << bit;
    } catch (const Error&) {  // in the header
    }
  }
}

TEST(SharedWork, DamagedResultsAreDoneAgain) {
  const TemporaryFolder folder;
  together(50, kept_in(folder / "work"));
  const auto size = fs::file_size(folder / "work/results");
  std::fstream(folder / "work/results", std::ios::in | std::ios::out | std::ios::binary).seekp(static_cast<std::streamoff>(size / 2)) << "damage";
  std::atomic<int> done = 0;
  EXPECT_EQ(together(50, kept_in(folder / "work"), &done), expected(50));
  EXPECT_GT(done, 0);
  EXPECT_EQ(fs::file_size(folder / "work/results"), size);
  fs::resize_file(folder / "work/results", 30);  // in the header: nothing is known
  EXPECT_EQ(together(50, kept_in(folder / "work"), &done), expected(50));
}

TEST(SharedWork, AnotherWorksFolderIsRefused) {
  const TemporaryFolder folder;
  together(50, kept_in(folder / "work"));
  EXPECT_THAT([&] { together(51, kept_in(folder / "work")); },
              ThrowsMessage<Error>(HasSubstr("is the checkpoint of another run (its \"runs\" differs)")));
  fs::create_directory(folder / "mine");
  std::ofstream(folder / "mine/thesis.tex") << "text";
  EXPECT_THAT([&] { together(50, kept_in(folder / "mine")); }, ThrowsMessage<Error>(HasSubstr("is no checkpoint")));
  EXPECT_THROW(together(50, kept_in(folder / "mine/thesis.tex")), Error);
  const CheckpointFile held(folder / "work", identity_of(50), [](std::size_t, const std::string&) {});
  EXPECT_THAT([&] { together(50, kept_in(folder / "work")); }, ThrowsMessage<Error>(HasSubstr("another process works on it")));
}

TEST(SharedWork, ALinkInItsFolderIsNotFollowed) {
  const TemporaryFolder folder;
  std::ofstream(folder / "victim") << "thesis";
  fs::create_directory(folder / "work");
  fs::create_symlink(folder / "victim", folder / "work/results");
  EXPECT_THROW(together(5, kept_in(folder / "work")), Error);
  EXPECT_EQ(text_in(folder / "victim"), "thesis");
}

TEST(SharedWork, WhatABlockThrowsIsThrown) {
  SharedWork work{.count = 100, .work = {}, .take = [](std::size_t, const std::string&) {}};
  work.work = [](std::size_t block) -> std::string {
    if (block == 50) throw Error("block 50");
    return "";
  };
  EXPECT_THAT([&] { for_each(work); }, ThrowsMessage<Error>(HasSubstr("block 50")));
  const TemporaryFolder folder;
  Sharing here = kept_in(folder / "work");
  EXPECT_THAT([&] { for_each(work, &here); }, ThrowsMessage<Error>(HasSubstr("the work has no identity")));
  here.identity = "x";
  EXPECT_THAT([&] { for_each(work, &here); }, ThrowsMessage<Error>(HasSubstr("block 50")));
}

TEST(SharedWork, NothingIsTakenAfterAResultThatCannotBe) {
  std::atomic<bool> thrown = false;
  std::vector<std::size_t> taken;
  SharedWork work{.count = 2, .work = {}, .take = {}};
  work.work = [&](std::size_t block) -> std::string {
    while (block == 1 && !thrown) std::this_thread::yield();  // it is done by another thread, later
    return "";
  };
  work.take = [&](std::size_t block, const std::string&) {
    taken.push_back(block);
    thrown = true;
    throw Error("cannot be taken");
  };
  EXPECT_THROW(for_each(work), Error);
  EXPECT_EQ(taken, std::vector<std::size_t>{0});
}

TEST(SharedWork, FieldsOfAnIdentityStayApart) {
  const std::string one = work_identity("fleet", {{"station", "A B"}, {"operator", "C"}});
  EXPECT_NE(one, work_identity("fleet", {{"station", "A"}, {"operator", "B C"}}));
  EXPECT_NE(one, work_identity("plan", {{"station", "A B"}, {"operator", "C"}}));
  EXPECT_NE(work_identity("fleet", {{"station", "A\noperator=C"}}), work_identity("fleet", {{"station", "A"}, {"operator", "C"}}));
  EXPECT_NE(work_identity("fleet", {{"station", "\\n"}}), work_identity("fleet", {{"station", "\n"}}));
  EXPECT_THAT(one, HasSubstr("\nversion=" + build().version + "\n"));
}

/// Variables of the environment while it lives; those of schedulers alone are there.
class Environment {
 public:
  explicit Environment(const std::vector<std::pair<const char*, const char*>>& variables) {
    for (const char* name : {"SLURM_ARRAY_TASK_ID", "SLURM_PROCID", "OMPI_COMM_WORLD_RANK", "PMI_RANK", "JOB_COMPLETION_INDEX"}) unsetenv(name);
    for (const auto& [name, value] : variables) setenv(name, value, 1), names_.push_back(name);
  }
  ~Environment() {
    for (const char* name : names_) unsetenv(name);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  std::vector<const char*> names_;
};

std::string named(const std::string& text) {
  const PartNumber part = part_named(text);
  return std::to_string(part.number) + "/" + std::to_string(part.of);
}

TEST(PartNumber, ComesFromTheEnvironment) {
  using Array = std::vector<std::pair<const char*, const char*>>;
  const Array array{{"SLURM_ARRAY_TASK_ID", "30"},
                    {"SLURM_ARRAY_TASK_COUNT", "8"},
                    {"SLURM_ARRAY_TASK_MIN", "10"},
                    {"SLURM_ARRAY_TASK_MAX", "80"},
                    {"SLURM_ARRAY_TASK_STEP", "10"}};
  const Array step{{"SLURM_PROCID", "2"}, {"SLURM_STEP_NUM_TASKS", "4"}};
  EXPECT_EQ((Environment(array), named("auto")), "3/8");
  EXPECT_EQ((Environment(step), named("auto")), "3/4");
  Array both = array;
  both.insert(both.end(), step.begin(), step.end());
  EXPECT_EQ((Environment(both), named("auto")), "11/32");
  EXPECT_EQ(
      (Environment({{"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "4"}, {"OMPI_COMM_WORLD_RANK", "1"}, {"OMPI_COMM_WORLD_SIZE", "2"}}), named("auto")),
      "2/2")
      << "a batch script is no step";
  EXPECT_EQ((Environment({{"PMI_RANK", "0"}, {"PMI_SIZE", "3"}}), named("auto")), "1/3");
  EXPECT_EQ((Environment({{"JOB_COMPLETION_INDEX", "4"}}), named("auto/5")), "5/5");
  Array lost{{"SLURM_ARRAY_TASK_ID", "16"}, {"SLURM_ARRAY_TASK_COUNT", "2"}, {"SLURM_ARRAY_TASK_MIN", "15"}, {"SLURM_ARRAY_TASK_MAX", "16"}};
  EXPECT_EQ((Environment(lost), named("auto/20")), "16/20") << "--array=15,16 repeats two of 20 tasks";
  EXPECT_EQ((Environment(lost), named("auto")), "2/2");
  lost[1].second = "3", lost[2].second = "2";  // --array=2,3,16
  EXPECT_EQ((Environment(lost), named("auto/20")), "16/20");
  Array lost_of_steps = lost;
  lost_of_steps.insert(lost_of_steps.end(), step.begin(), step.end());
  EXPECT_EQ((Environment(lost_of_steps), named("auto/80")), "63/80") << "20 tasks of an array, of 4 processes each";
  const auto refused = [](const Array& variables, const std::string& text) {
    return [=] {
      const Environment environment(variables);
      part_named(text);
    };
  };
  Array uneven = array;
  uneven[1].second = "3";  // --array=10,30,80
  EXPECT_THAT(refused(uneven, "auto"), ThrowsMessage<Error>(HasSubstr("not evenly spaced")));
  EXPECT_THAT(refused({{"JOB_COMPLETION_INDEX", "4"}}, "auto"), ThrowsMessage<Error>(HasSubstr("expected auto/N")));
  EXPECT_THAT(refused({{"JOB_COMPLETION_INDEX", "5"}}, "auto/5"), ThrowsMessage<Error>(HasSubstr("auto/5")));
  EXPECT_THAT(refused(lost, "auto/15"), ThrowsMessage<Error>(HasSubstr("expected --array with indices from 1 to 15")));
  EXPECT_THAT(refused({{"SLURM_ARRAY_TASK_ID", "0"}}, "auto/4"), ThrowsMessage<Error>(HasSubstr("0 is the index")));
  EXPECT_THAT(refused(lost_of_steps, "auto/78"), ThrowsMessage<Error>(HasSubstr("the environment has 76 parts")));
  EXPECT_THAT(refused(step, "auto/8"), ThrowsMessage<Error>(HasSubstr("the environment has 4 parts")));
  EXPECT_THAT(refused({}, "auto"), ThrowsMessage<Error>(HasSubstr("expected K/N")));
}

TEST(PartNumber, IsOneOfN) {
  EXPECT_EQ(named("3/8"), "3/8");
  for (const char* wrong : {"", "3", "0/8", "9/8", "-1/8", "3/", "/8", "3/8/9", "3 /8", "a/8", "1/2000000", "3/8x", "18446744073709551617/8"})
    EXPECT_THAT([&] { part_named(wrong); }, ThrowsMessage<Error>(HasSubstr("expected K/N"))) << wrong;
}

}  // namespace
}  // namespace imulab
