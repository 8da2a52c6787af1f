// Limits of memory, checked before the work begins, so that a file that is too large leads to a message.
#pragma once

#include <cstdint>
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

/// Throws MemoryError "WORK takes about 6.8 GB of memory; expected at most 4.0 GB" beyond the limit.
void expect_memory(double bytes, std::string_view work);

/// Gives what was freed back to the system, which the allocator may keep for what comes next: before much is needed in larger pieces.
void give_back_freed_memory();

}  // namespace imulab
