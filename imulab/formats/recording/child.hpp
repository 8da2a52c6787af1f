// A function in a child process, and its answer through a pipe and shared memory: for libraries that a damaged file can crash.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <semaphore.h>
#include <string>
#include <string_view>

namespace imulab::recording_io {

/// The limits of a child. The memory comes on top of what the program has when the child starts; it is not limited under the address sanitizer.
struct ChildLimits {
  std::uint64_t memory_bytes = 0;
  unsigned computing_s = 0, wall_s = 0;
};

/// Enough for any file of this size, packed as well as deflate can, on a slow machine: 512 MB and 2200 times the file, at most what the machine has;
/// 10 s of computing and 1 s per MB; six times that of wall time.
ChildLimits child_limits(std::uint64_t file_bytes);

/// A file and the library that reads it, for messages: "libhdf5".
struct ChildTask {
  std::filesystem::path file;
  std::string library;
  ChildLimits limits;
};
ChildTask child_task(const std::filesystem::path& file, const std::string& library);

/// Memory of both processes, filled by the child and emptied by the parent slot after slot: a pipe copies twice, and is slower than reading a file. A
/// byte in the pipe says that a slot is full.
class SharedSlots {
 public:
  static constexpr std::size_t slot_bytes = 1 << 17;
  SharedSlots();
  ~SharedSlots();
  SharedSlots(const SharedSlots&) = delete;
  SharedSlots& operator=(const SharedSlots&) = delete;

  /// A child cannot change another's memory.
  void keep_from_children(bool keep);
  char* next();
  void wait_for_empty();
  void add_empty();

 private:
  static constexpr std::size_t count = 8;
  static_assert(count >= sizeof(std::uint64_t));  // so that a parent that takes the bytes of full slots for a number ends the child at once
  struct Memory {
    sem_t empty;
    alignas(64) std::array<std::array<char, slot_bytes>, count> slots;
  };
  Memory* memory_;
  std::size_t turn_ = 0;
};

/// The child's end of the pipe. Whatever goes wrong ends the child.
class ToParent {
 public:
  ToParent(int descriptor, SharedSlots& slots) : descriptor_(descriptor), slots_(slots) {}
  void bytes(const void* data, std::size_t size);
  void number(std::uint64_t n) { bytes(&n, sizeof n); }
  void text(std::string_view t);
  /// A part of the answer follows.
  void next();
  void flush();

 private:
  void write_all(const char* data, std::size_t size) const;

  int descriptor_;
  SharedSlots& slots_;
  std::string buffer_;
};

/// The parent's end. Nothing is believed: a child that went wrong may send anything. Throws what run_in_child catches.
class FromChild {
 public:
  FromChild(int descriptor, SharedSlots& slots, std::uint64_t most_bytes) : descriptor_(descriptor), slots_(slots), most_bytes_(most_bytes) {}
  void bytes(void* data, std::size_t size) const;
  /// Reads bytes without memory that is there already: `each` gets part after part, aligned for any number.
  void parts(std::size_t size, const std::function<void(const char* part, std::size_t bytes)>& each) const;
  std::uint64_t number() const;
  /// The number of elements of `size` bytes that follow: no more in all than the child's memory can hold.
  std::size_t count(std::size_t size);
  /// A number of elements of `size` bytes that will follow at most.
  std::size_t most(std::size_t size) const;
  std::string text();
  /// Throws: what came makes no sense.
  [[noreturn]] void reject() const;

 private:
  void from_pipe(char* data, std::size_t size) const;

  int descriptor_;
  SharedSlots& slots_;
  std::uint64_t most_bytes_;
};

/// Runs `work` in a child process, and in this one `take` for each part that it sends; the program is not touched by what happens in the child.
/// Throws Error with the text of an Error that `work` throws, and "FILE: is damaged: LIBRARY failed on it (segmentation fault)" where the child dies
/// or exceeds its limits. The child has one thread and a copy of the program's memory: `work` must not use TBB nor wait for another thread. May be
/// called from several threads at once.
void run_in_child(const ChildTask& task, const std::function<void(ToParent&)>& work, const std::function<void(FromChild&)>& take);

}  // namespace imulab::recording_io
