#include "imulab/core/memory.hpp"

#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <limits>
#include <mutex>
#include <string>
#include <unistd.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace imulab {
namespace {

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();

std::uint64_t of_machine() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), page = ::sysconf(_SC_PAGESIZE);
  const std::uint64_t bytes = pages > 0 && page > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page) : unlimited;
  return std::min(bytes, control_group_limit());
}

/// The smallest limit in the file `name` of the folder `base`/`group` and of the folders above it up to `base`. A file that holds "max" has none.
std::uint64_t limit_up_to(const std::filesystem::path& base, std::filesystem::path group, const char* name) {
  std::uint64_t bytes = unlimited;
  for (;; group = group.parent_path()) {
    if (std::uint64_t limit = 0; std::ifstream(base / group / name) >> limit && limit > 0) bytes = std::min(bytes, limit);
    if (group.empty()) return bytes;
  }
}

std::atomic<std::uint64_t> limit_in_force = 0;  // 0: the machine's

}  // namespace

MemoryLimit::MemoryLimit(std::uint64_t bytes) : before_(limit_in_force.exchange(bytes)) {}
MemoryLimit::~MemoryLimit() { limit_in_force = before_; }

std::uint64_t memory_limit() {
  static const std::uint64_t machine = of_machine();
  const std::uint64_t set = limit_in_force;
  return set > 0 ? set : machine;
}

std::uint64_t control_group_limit(const std::filesystem::path& root) {
  std::uint64_t bytes = unlimited;
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {  // "0::/user.slice" in version 2, "4:memory:/docker/1f" in version 1
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    const std::filesystem::path group = std::filesystem::path(line.substr(second + 1)).relative_path(), base = root / "sys/fs/cgroup";
    if (controllers == ",,") bytes = std::min(bytes, limit_up_to(base, group, "memory.max"));
    if (controllers.find(",memory,") != std::string::npos) bytes = std::min(bytes, limit_up_to(base / "memory", group, "memory.limit_in_bytes"));
  }
  return bytes;
}

void expect_memory(double bytes, std::string_view work) {
  const auto limit = static_cast<double>(memory_limit());
  if (bytes > limit)
    throw MemoryError(fmt::format("{} takes about {:.3g} GB of memory; expected at most {:.3g} GB", work, 1e-9 * bytes, 1e-9 * limit));
}

void give_back_freed_memory() {
#ifdef __GLIBC__
  // The first use of glibc's heap is not safe among threads where another allocator, as a sanitizer's, stands in its place.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  malloc_trim(0);
#endif
}

}  // namespace imulab
