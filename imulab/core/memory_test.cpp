#include "imulab/core/memory.hpp"

#include "imulab/error.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <atomic>
#include <limits>
#include <thread>
#include <vector>

namespace imulab {
namespace {

TEST(MemoryLimit, RefusesWhatIsLargerWhileItLives) {
  const std::uint64_t machine = memory_limit();
  EXPECT_GT(machine, 1u << 26);
  {
    const MemoryLimit limit(4'000'000'000);
    EXPECT_NO_THROW(expect_memory(4e9, "a day"));
    try {
      expect_memory(6.8e9, "a day");
      FAIL();
    } catch (const MemoryError& e) {
      EXPECT_STREQ(e.what(), "a day takes about 6.8 GB of memory; expected at most 4 GB");
    }
  }
  EXPECT_EQ(memory_limit(), machine);
  EXPECT_THROW(expect_memory(1.01 * static_cast<double>(machine), "more than there is"), MemoryError);
}

/// The limit where the machine's files are these.
std::uint64_t limit_with(const std::vector<std::pair<std::string, std::string>>& files) {
  const TemporaryFolder root;
  for (const auto& [name, text] : files) {
    std::filesystem::create_directories((root / name).parent_path());
    root.write(name, text);
  }
  return control_group_limit(root.path());
}

TEST(MemoryLimit, IsThatOfTheProcessesOwnControlGroup) {
  EXPECT_EQ(limit_with({}), std::numeric_limits<std::uint64_t>::max());
  // Version 2: the group's own file, and those of the groups that contain it.
  EXPECT_EQ(limit_with({{"proc/self/cgroup", "0::/system.slice/job.service\n"},
                        {"sys/fs/cgroup/system.slice/memory.max", "3000000000\n"},
                        {"sys/fs/cgroup/system.slice/job.service/memory.max", "2000000000\n"},
                        {"sys/fs/cgroup/other/memory.max", "1000000000\n"}}),
            2'000'000'000u);
  EXPECT_EQ(limit_with({{"proc/self/cgroup", "0::/system.slice/job.service\n"},
                        {"sys/fs/cgroup/system.slice/memory.max", "3000000000\n"},
                        {"sys/fs/cgroup/system.slice/job.service/memory.max", "max\n"}}),
            3'000'000'000u);
  // A container sees its group as the root.
  EXPECT_EQ(limit_with({{"proc/self/cgroup", "0::/\n"}, {"sys/fs/cgroup/memory.max", "4000000000\n"}}), 4'000'000'000u);
  // Version 1, beside an empty hierarchy of version 2; the container does not show the host's path.
  EXPECT_EQ(limit_with({{"proc/self/cgroup", "5:cpu,cpuacct:/docker/1f\n4:hugetlb,memory:/docker/1f\n0::/\n"},
                        {"sys/fs/cgroup/memory/memory.limit_in_bytes", "5000000000\n"},
                        {"sys/fs/cgroup/cpu/memory.limit_in_bytes", "1000000000\n"}}),
            5'000'000'000u);
}

TEST(GiveBackFreedMemory, MayBeAskedByThreadsAtOnce) {
  std::atomic<int> ready = 0;
  std::vector<std::jthread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([&] {
      for (++ready; ready < 8;) std::this_thread::yield();
      give_back_freed_memory();
    });
  threads.clear();
  EXPECT_EQ(ready, 8);
}

}  // namespace
}  // namespace imulab
