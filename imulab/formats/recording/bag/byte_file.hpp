// A file that is read at places: a bag may be larger than memory, and most of it is cameras.
#pragma once

#include "imulab/formats/recording/bag/bytes.hpp"

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace imulab::bag {

class ByteFile {
 public:
  /// Throws Error where it cannot be opened or is no regular file.
  explicit ByteFile(const std::filesystem::path& path);
  ~ByteFile();
  ByteFile(const ByteFile&) = delete;
  ByteFile& operator=(const ByteFile&) = delete;

  std::uint64_t size() const { return size_; }
  const std::filesystem::path& path() const { return path_; }

  /// `count` bytes from `offset`, in `buffer`. Throws Damaged, and allocates nothing, where the file ends before or they are more than a gigabyte;
  /// Error where the system cannot read.
  std::string_view read(std::uint64_t offset, std::uint64_t count, Buffer& buffer) const;
  /// The same of as many bytes as there are, `count` at most.
  std::string_view read_some(std::uint64_t offset, std::uint64_t count, Buffer& buffer) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace imulab::bag
