// A file copied with pieces replaced by others, which may be longer or shorter: where everything comes to be.
#pragma once

#include "imulab/formats/recording/bag/byte_file.hpp"
#include "imulab/formats/text/file.hpp"

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab::bag {

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
