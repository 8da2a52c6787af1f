// A file that is read at places: a bag may be larger than memory, and most of it is cameras.
#pragma once

#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/text/file.hpp"

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

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
  /// Reads as many bytes as there are, `count` at most.
  std::string_view read_some(std::uint64_t offset, std::uint64_t count, Buffer& buffer) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// A file copied with pieces replaced by others, which may be longer or shorter: it knows where everything comes to be.
class Copy {
 public:
  Copy(const ByteFile& in, WholeFile& out, bool checksum) : in_(in), out_(out), checksum_(checksum) {}

  /// Copies up to this byte of the input.
  void until(std::uint64_t place);
  /// Writes `bytes` in place of those of the input up to `place`.
  void put(std::string_view bytes, std::uint64_t place);
  /// Where a byte of the input is in the output, of what has been copied.
  std::uint64_t moved(std::uint64_t place) const;
  /// CRC-32 of all that was written.
  std::uint32_t crc() const { return crc_; }

 private:
  void write(std::string_view bytes);

  const ByteFile& in_;
  WholeFile& out_;
  bool checksum_;
  std::uint64_t taken_ = 0, written_ = 0;
  std::uint32_t crc_ = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> places_;  // of the input from here on, and of the output
  Buffer buffer_;
};

}  // namespace imulab::bag
