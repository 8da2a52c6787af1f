// What a child process sends to its parent, through a pipe and shared memory.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <semaphore.h>
#include <string>
#include <string_view>

namespace imulab::recording_io {

/// What an answer consists of: its begin, parts, at most one error, its end.
struct ChildMarks {
  static constexpr std::uint64_t begin = 0x1b6d756c61626567, part = 0x1b6d756c61627265, error = 0x1b6d756c61626572, end = 0x1b6d756c6162656e;
};

/// The child ended before its answer did, its answer makes no sense, or it takes longer than it may.
enum class NoAnswer { ended, nonsense, late };

/// A descriptor that does not stand for standard input, output or errors, which a program may have been started without: the same, or a copy in place
/// of it. Gives -1 with errno where there is none.
int beyond_standard(int descriptor);

/// Memory of both processes, filled by the child and emptied by the parent slot after slot: a pipe copies twice, and is slower than reading a file. A
/// byte in the pipe says that a slot is full. The child finds it by a descriptor, and cannot change its size.
class SharedSlots {
 public:
  static constexpr std::size_t slot_bytes = 1 << 17;
  /// Throws std::system_error where the system refuses the memory.
  SharedSlots();
  explicit SharedSlots(int descriptor);
  ~SharedSlots();
  SharedSlots(const SharedSlots&) = delete;
  SharedSlots& operator=(const SharedSlots&) = delete;

  int descriptor() const { return descriptor_; }
  static constexpr std::size_t bytes() { return sizeof(Memory); }
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
  void map();

  int descriptor_;
  Memory* memory_ = nullptr;
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

/// The parent's end, which does not block (O_NONBLOCK). Nothing is believed: a child that went wrong may send anything, or nothing for ever. Throws
/// NoAnswer, which run_in_child catches.
class FromChild {
 public:
  FromChild(int descriptor, SharedSlots& slots, std::uint64_t most_bytes, std::chrono::steady_clock::time_point end)
      : descriptor_(descriptor), slots_(slots), most_bytes_(most_bytes), end_(end) {}
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
  void wait_for_pipe() const;

  int descriptor_;
  SharedSlots& slots_;
  std::uint64_t most_bytes_;
  std::chrono::steady_clock::time_point end_;
};

}  // namespace imulab::recording_io
