// A fault in a child process stays there: its answer or its death is all that the program sees.
#include "imulab/error.hpp"
#include "imulab/formats/recording/child/child_tables.hpp"

#include <gmock/gmock.h>

#include "tests/tested_build.hpp"
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <functional>
#include <iostream>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace imulab::recording_io {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const ChildTask task{"imu.h5", "libtest", {.memory_bytes = 1 << 30, .computing_s = 5, .wall_s = 20}};

/// This program once more as a child, which does this work.
StartChild forked(const ChildTask& with, const std::function<void(ToParent&)>& work) {
  return [&](int pipe, int memory) {
    const pid_t id = ::fork();
    if (id == 0) answer_parent(pipe, memory, with, work);
    return id;
  };
}

std::vector<TableDescription> described(const std::function<std::vector<TableDescription>()>& work, const ChildTask& with = task) {
  return describe_in_child(with, forked(with, [&](ToParent& to) { send_tables(to, work()); }));
}

TableRows columns_sent(std::size_t columns, const std::function<void(const SendColumn&)>& work) {
  return columns_in_child(task, columns, forked(task, [&](ToParent& to) { work(column_sender(to)); }));
}

/// The message where a child does this.
std::string error_of_child(const std::function<void()>& work, const ChildTask& with = task) {
  try {
    described(
        [&] {
          work();
          return std::vector<TableDescription>{};
        },
        with);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

std::ptrdiff_t open_descriptors() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
}

bool has_children() { return ::waitpid(-1, nullptr, WNOHANG) >= 0 || errno != ECHILD; }

TEST(Child, DescribesTables) {
  const std::vector<TableDescription> tables{{"imu", "double", {{"t", "s"}, {"gyro.1", ""}}, 40}, {"", "", {{std::string(100'000, 'x'), ""}}, 1}};
  const auto got = described([&] { return tables; });
  ASSERT_EQ(got.size(), 2u);
  EXPECT_EQ(got[0].name, "imu");
  EXPECT_EQ(got[0].type, "double");
  EXPECT_EQ(got[0].rows, 40u);
  ASSERT_EQ(got[0].columns.size(), 2u);
  EXPECT_EQ(got[0].columns[0].unit, "s");
  EXPECT_EQ(got[0].columns[1].name, "gyro.1");
  EXPECT_EQ(got[1].columns.at(0).name, tables[1].columns[0].name);
}

TEST(Child, SendsColumnsExactly) {
  constexpr std::size_t rows = 300'000;  // several times what a pipe holds
  const auto table = columns_sent(2, [](const SendColumn& send) {
    for (std::size_t begin = 0; begin < rows; begin += 1000) {
      RawColumn numbers, integers;
      for (std::size_t i = begin; i < begin + 1000; ++i) numbers.numbers.push_back(1.0 / static_cast<double>(i + 1));
      for (std::size_t i = begin; i < begin + 1000; ++i) integers.integers.push_back(std::numeric_limits<std::int64_t>::max() - std::int64_t(i));
      send(1, integers, rows);
      send(0, numbers, rows);
    }
  });
  ASSERT_EQ(table.columns.size(), 2u);
  ASSERT_EQ(table.columns[0].numbers.size(), rows);
  ASSERT_EQ(table.columns[1].integers.size(), rows);
  for (std::size_t i = 0; i < rows; ++i) {
    ASSERT_EQ(table.columns[0].numbers[i], 1.0 / static_cast<double>(i + 1));
    ASSERT_EQ(table.columns[1].integers[i], std::numeric_limits<std::int64_t>::max() - static_cast<std::int64_t>(i));
  }
}

/// A small answer goes through the pipe, a large one through slots of memory, and a larger one through several.
TEST(Child, AnySizeComesAsItWasSent) {
  for (const std::size_t count : {0, 1, 511, 512, 513, 16383, 16384, 16385, 8 * 16384, 200'001}) {
    std::vector<double> numbers(count);
    for (std::size_t i = 0; i < count; ++i) numbers[i] = static_cast<double>(i) / 3;
    const TableRows table = columns_sent(1, [&](const SendColumn& send) {
      send(0, {.numbers = numbers, .integers = {}}, count + 1), send(0, {{1}, {}}, count + 1);
    });
    numbers.push_back(1);
    EXPECT_EQ(table.columns[0].numbers, numbers) << count;
  }
  for (const std::size_t size : {4095, 4096, 4097, 131'072, 131'073}) {
    std::string name(size, 'x');
    for (std::size_t i = 0; i < size; ++i) name[i] = static_cast<char>('a' + i % 26);
    EXPECT_EQ(described([&] { return std::vector<TableDescription>{{name, "", {}, 7}}; }).at(0).name, name) << size;
  }
}

TEST(Child, ColumnBecomesNumbersWhereIntegersAreTooSmall) {
  const auto table = columns_sent(1, [](const SendColumn& send) {
    send(0, {.numbers = {}, .integers = {1, 2}}, 6);
    send(0, {.numbers = {3, 1e19}, .integers = {}}, 6);
    send(0, {.numbers = {}, .integers = {5, 6}}, 6);
  });
  EXPECT_THAT(table.columns[0].numbers, testing::ElementsAre(1, 2, 3, 1e19, 5, 6));
  EXPECT_TRUE(table.columns[0].integers.empty());
}

TEST(Child, ErrorsArePassedOn) {
  EXPECT_EQ(error_of_child([] { throw Error("imu.h5: column z is not there"); }), "imu.h5: column z is not there");
  EXPECT_EQ(error_of_child([] { throw std::runtime_error("odd"); }), "imu.h5: odd");
  EXPECT_THAT(error_of_child([] { throw std::bad_alloc(); }), HasSubstr("imu.h5: is damaged: libtest needs more memory"));
}

TEST(Child, ErrorAfterSomeRows) {
  EXPECT_THROW(columns_sent(1,
                            [](const SendColumn& send) {
                              for (int i = 0; i < 100; ++i) send(0, {.numbers = std::vector<double>(10'000), .integers = {}}, 1'000'000);
                              throw Error("imu.h5: ends here");
                            }),
               Error);
}

TEST(Child, DeathIsAnError) {
  EXPECT_EQ(error_of_child([] { std::raise(SIGSEGV); }), "imu.h5: is damaged: libtest failed on it (segmentation fault); expected a whole file");
  EXPECT_THAT(error_of_child([] { std::abort(); }), HasSubstr("libtest failed on it (aborted)"));
  EXPECT_THAT(error_of_child([] { std::raise(SIGKILL); }), HasSubstr("libtest failed on it (killed)"));
  EXPECT_THAT(error_of_child([] { ::_exit(3); }), HasSubstr("libtest failed on it (it ended with code 3)"));
  EXPECT_FALSE(has_children());
}

TEST(Child, EndlessWorkIsStopped) {
  ChildTask impatient = task;
  impatient.limits = {1 << 30, 1, 20};
  volatile std::uint64_t turns = 0;
  EXPECT_THAT(error_of_child(
                  [&] {
                    while (true) turns = turns + 1;
                  },
                  impatient),
              HasSubstr("no end after 1 s of computing"));
  impatient.limits = {1 << 30, 20, 1};
  EXPECT_THAT(error_of_child(
                  [] {
                    while (true) ::pause();
                  },
                  impatient),
              HasSubstr("no end after 1 s)"));
  EXPECT_FALSE(has_children());
}

TEST(Child, MemoryIsLimited) {
  if (under_sanitizers()) GTEST_SKIP() << "the address sanitizer reserves all addresses";
  ChildTask small = task;
  small.limits.memory_bytes = 64 << 20;
  const auto take = [](std::size_t bytes) { return [bytes] { std::vector<char> memory(bytes, 'x'); }; };
  EXPECT_EQ(error_of_child(take(32 << 20), small), "no error");
  EXPECT_THAT(error_of_child(take(256 << 20), small), HasSubstr("libtest needs more memory"));
}

/// A child whose memory was damaged may send anything.
TEST(Child, NonsenseIsAnError) {
  const auto sent = [](const std::function<void(ToParent&)>& work) {
    std::vector<std::string> texts;
    try {
      run_in_child(task, forked(task, work), [&](FromChild& from) { texts.push_back(from.text()); });
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_EQ(sent([](ToParent& to) { to.next(), to.text("good"); }), "no error");
  EXPECT_THAT(sent([](ToParent& to) { to.next(), to.number(std::numeric_limits<std::uint64_t>::max()); }), HasSubstr("is damaged"));
  EXPECT_THAT(sent([](ToParent& to) { to.next(), to.number(1 << 20); }), HasSubstr("is damaged"));
  EXPECT_THAT(sent([](ToParent& to) {
                const std::string nonsense(10'000'000, 'n');  // more than a pipe holds
                to.bytes(nonsense.data(), nonsense.size());
              }),
              HasSubstr("its answer makes no sense"));
  EXPECT_FALSE(has_children());
}

/// Readers take it for granted that all columns have one length, and that it is the stated one.
TEST(Child, ColumnsOfOtherLengthsAreAnError) {
  using Sent = std::vector<std::array<std::size_t, 3>>;  // column, rows, rows in all
  for (const Sent& sent : {Sent{{0, 3, 3}, {1, 2, 3}}, Sent{{0, 3, 3}}, Sent{{0, 3, 3}, {1, 4, 3}}, Sent{{0, 3, 3}, {1, 4, 4}},
                           Sent{{0, 2, 3}, {1, 2, 3}}, Sent{{0, 0, 0}, {1, 1, 0}}, Sent{{0, 1, std::size_t{1} << 60}}})
    EXPECT_THROW(columns_sent(2,
                              [&](const SendColumn& send) {
                                for (const auto& [column, rows, all] : sent) send(column, {std::vector<double>(rows, 1), {}}, all);
                              }),
                 Error)
        << sent.size() << ' ' << sent.back()[1];
  EXPECT_FALSE(has_children());
}

/// A child that was taken over puts off its alarm, and ends neither when its answer does nor when the pipe is closed.
TEST(Child, ThatDoesNotEndIsKilled) {
  const auto stay = [] {
    ::alarm(0);
    std::signal(SIGPIPE, SIG_IGN);
    while (true) ::pause();
  };
  ChildTask impatient = task;
  impatient.limits.wall_s = 1;
  EXPECT_THAT(error_of_child(stay, impatient), HasSubstr("no end after 1 s)"));  // in silence
  const auto error = [&](const std::function<void(ToParent&, int pipe)>& last) {
    try {
      const StartChild start = [&](int pipe, int memory) {
        const pid_t id = ::fork();
        if (id == 0) answer_parent(pipe, memory, task, [&](ToParent& to) { last(to, pipe), stay(); });
        return id;
      };
      describe_in_child(task, start);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(error([](ToParent& to, int) { to.number(0), to.flush(); }), HasSubstr("its answer makes no sense"));
  EXPECT_THAT(error([](ToParent&, int pipe) { ::close(pipe); }), HasSubstr("(killed)"));
  EXPECT_EQ(error([](ToParent& to, int) { to.number(ChildMarks::end), to.flush(); }), "no error");
  EXPECT_FALSE(has_children());
}

TEST(Child, WithoutItsParentItEnds) {
  ChildTask orphan = task;
  orphan.parent = 1;
  EXPECT_THAT(error_of_child([] {}, orphan), HasSubstr("does not start (it ended with code 1)"));
}

/// Nor does one end this program that takes the memory away which both share.
TEST(Child, CannotShortenTheSharedMemory) {
  const StartChild start = [](int pipe, int memory) {
    const pid_t id = ::fork();
    if (id != 0) return id;
    const int failed = ::ftruncate(memory, 0);
    answer_parent(pipe, memory, task, [&](ToParent& to) {
      const std::string text(100'000, 'x');
      to.next(), to.text(failed != 0 ? text : "cut");
    });
  };
  std::string got;
  run_in_child(task, start, [&](FromChild& from) { got = from.text(); });
  EXPECT_EQ(got, std::string(100'000, 'x'));
}

TEST(Child, ThatNeverBeginsIsNotADamagedFile) {
  const auto error = [](const StartChild& start) {
    try {
      describe_in_child(task, start);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(error([](int, int) {
                const pid_t id = ::fork();
                if (id == 0) ::_exit(127);
                return id;
              }),
              HasSubstr("imu.h5: cannot be read: imulab-read, the program that reads it, does not start (it ended with code 127)"));
  EXPECT_THAT(error([](int, int) {
                errno = EAGAIN;
                return pid_t{-1};
              }),
              HasSubstr("imu.h5: cannot be read: no process: Resource temporarily unavailable"));
}

/// Not even one that its parent forgot to keep to itself.
TEST(Child, HasNoOtherDescriptor) {
  const int kept = ::open("/dev/null", O_WRONLY);
  EXPECT_EQ(error_of_child([&] {
              if (::write(kept, "x", 1) != -1) throw Error("it is open");
            }),
            "no error");
  ::close(kept);
}

TEST(Child, LeavesNothingBehind) {
  const auto before = open_descriptors();
  std::cout << "unwritten output is not written twice" << std::flush;
  std::cout << ".\n";
  for (int i = 0; i < 20; ++i)
    error_of_child([i] {
      if (i % 2 == 0) std::raise(SIGSEGV);
    });
  EXPECT_EQ(open_descriptors(), before);
  EXPECT_FALSE(has_children());
}

/// A child that dies lets no other wait.
TEST(Child, FromSeveralThreads) {  // ctest: once
  std::vector<std::string> errors(8);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < errors.size(); ++i)
    threads.emplace_back([&, i] {
      for (int k = 0; k < 10; ++k) errors[i] = error_of_child([i] { i % 2 == 0 ? throw Error("own " + std::to_string(i)) : std::abort(); });
    });
  for (auto& thread : threads) thread.join();
  for (std::size_t i = 0; i < errors.size(); ++i) EXPECT_THAT(errors[i], i % 2 == 0 ? HasSubstr("own " + std::to_string(i)) : HasSubstr("(aborted)"));
  EXPECT_FALSE(has_children());
}

/// A program that does not want to know of its children's ends.
TEST(Child, WhereChildrenAreIgnored) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  EXPECT_EQ(described([] { return std::vector<TableDescription>{{"imu", "", {}, 7}}; }).at(0).rows, 7u);
  EXPECT_THAT(error_of_child([] { std::abort(); }), StartsWith("imu.h5: is damaged: libtest failed on it"));
  std::signal(SIGCHLD, before);
}

TEST(Child, LimitsGrowWithTheFile) {
  const ChildLimits none = child_limits(0), large = child_limits(1'000'000'000);
  EXPECT_GE(none.memory_bytes, std::uint64_t{256'000'000});
  EXPECT_EQ(none.computing_s, 10u);
  EXPECT_EQ(large.computing_s, 1010u);
  EXPECT_EQ(large.wall_s, 6060u);
  EXPECT_GE(large.memory_bytes, none.memory_bytes);
  EXPECT_LE(child_limits(std::numeric_limits<std::uint64_t>::max()).computing_s, 2'000'000u);
}

}  // namespace
}  // namespace imulab::recording_io
