// A file that nobody else sees, in which numbers wait: it has no name, and is gone when it is closed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace imulab::recording_io {

/// Where temporary files go: TMPDIR, else /var/tmp (/tmp is often memory).
const char* temporary_place();

/// Throws Error where the place for temporary files has less room, saying what is needed.
void expect_room(std::uint64_t bytes);

/// Numbers of eight bytes that are appended and read again. All throw Error with the place and the reason of the system.
class ColumnFile {
 public:
  ColumnFile();
  ~ColumnFile();
  ColumnFile(ColumnFile&& from) noexcept;
  ColumnFile& operator=(ColumnFile&& from) noexcept;

  template <class Number>
  void append(std::span<const Number> numbers) {
    static_assert(sizeof(Number) == 8);
    write(numbers.data(), numbers.size());
  }
  /// From place `begin` on.
  void read(std::size_t begin, std::span<double> to) const;
  std::size_t size() const { return size_; }
  int descriptor() const { return descriptor_; }

 private:
  void write(const void* numbers, std::size_t count);
  int descriptor_ = -1;
  std::size_t size_ = 0;
};

/// The numbers of such a file as memory that the system reads when it is looked at, and may forget.
class MappedStamps {
 public:
  MappedStamps() = default;
  explicit MappedStamps(const ColumnFile& file);
  ~MappedStamps();
  MappedStamps(MappedStamps&& from) noexcept;
  MappedStamps& operator=(MappedStamps&& from) noexcept;
  std::span<const std::int64_t> stamps() const { return {data_, size_}; }
  /// Lets go of the memory; the stamps can still be read.
  void release() const;

 private:
  const std::int64_t* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace imulab::recording_io
