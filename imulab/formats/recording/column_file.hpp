// Temporary files in which numbers wait.
#pragma once

#include "imulab/core/temporary_file.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace imulab::recording_io {

/// Throws Error where the place for temporary files has less room, saying what is needed.
void expect_room(std::uint64_t bytes);

/// Numbers of eight bytes that are appended and read again. All throw Error with the place and the reason of the system.
class ColumnFile {
 public:
  template <class Number>
  void append(std::span<const Number> numbers) {
    static_assert(sizeof(Number) == 8);
    file_.append(std::as_bytes(numbers));
  }
  /// From place `begin` on.
  void read(std::size_t begin, std::span<double> to) const { file_.read(8 * std::uint64_t{begin}, std::as_writable_bytes(to)); }
  std::size_t size() const { return static_cast<std::size_t>(file_.size() / 8); }
  int descriptor() const { return file_.descriptor(); }

 private:
  TemporaryFile file_;
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
