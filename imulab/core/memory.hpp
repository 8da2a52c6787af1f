// Limits of memory, checked before the work begins, so that a file that is too large leads to a message.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace imulab {

/// While it exists, work that needs more bytes is refused. Without one the limit is the machine's memory, or that of its control group.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::uint64_t bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  std::uint64_t before_;
};

/// The limit in force [bytes].
std::uint64_t memory_limit();

/// The limit of the control group of this process (proc/self/cgroup; versions 1 and 2) and of the groups that contain it, with the files of /proc
/// and /sys below `root` [bytes]; the largest number if there is none.
std::uint64_t control_group_limit(const std::filesystem::path& root = "/");

/// Throws MemoryError "WORK takes about 6.8 GB of memory; expected at most 4.0 GB" beyond the limit.
void expect_memory(double bytes, std::string_view work);

/// Gives what was freed back to the system, which the allocator may keep for what comes next: before much is needed in larger pieces.
void give_back_freed_memory();

}  // namespace imulab

// IMULAB_ADDRESS_SANITIZER: defined where the code is under it. GCC and clang each say so in a way of their own.
#if defined(__SANITIZE_ADDRESS__)
#define IMULAB_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define IMULAB_ADDRESS_SANITIZER
#endif
#endif
