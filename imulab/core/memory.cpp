#include "imulab/core/memory.hpp"

#include "imulab/core/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <limits>
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
  std::uint64_t bytes = pages > 0 && page > 0 ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page) : unlimited;
  if (std::uint64_t group = 0; std::ifstream("/sys/fs/cgroup/memory.max") >> group && group > 0) bytes = std::min(bytes, group);
  return bytes;
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

void expect_memory(double bytes, std::string_view work) {
  const auto limit = static_cast<double>(memory_limit());
  if (bytes > limit)
    throw MemoryError(fmt::format("{} takes about {:.3g} GB of memory; expected at most {:.3g} GB", work, 1e-9 * bytes, 1e-9 * limit));
}

void give_back_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace imulab
