// Chunks of a bag: their compression, and those that cannot be read.
#pragma once

#include "imulab/formats/recording/bag/bytes.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab::bag {

enum class Compression { none, lz4, zstd, bzip2 };

/// By its name in a file: "", "none", "lz4", "zstd", "bz2". Throws Damaged where it is unknown, and Error where this build has not its library.
Compression compression_of(std::string_view name);

/// `packed` unpacked, in `buffer` (or `packed` itself where it is not compressed). Memory grows with what is found, not with what `size` promises.
/// Throws Damaged where it is not exactly `size` bytes, and MemoryError with `file` where that is more than may be taken.
std::string_view unpack(Compression compression, std::string_view packed, std::uint64_t size, Buffer& buffer, const std::string& file = "a bag");

/// Zstandard, or none in a build without it.
std::string_view compression_of_new_bags();

/// The reverse of `unpack`. LZ4 is a frame of independent blocks with a checksum, which ROS 1 asks for.
std::string pack(Compression compression, std::string_view bytes);

/// Notes the parts of a bag that cannot be read: they are left out and reported.
class Damage {
 public:
  explicit Damage(std::string file) : file_(std::move(file)) {}

  /// The chunk at this byte is left out.
  void chunk(std::uint64_t at, const std::string& what) { chunks_.emplace(at, what); }
  /// The file is of no use from this byte on.
  void end(std::uint64_t at, const std::string& what) { ends_.emplace(at, what); }
  /// The index cannot be used.
  void index(const std::string& what) { index_ = what; }
  bool any_index() const { return !index_.empty(); }

  bool any() const { return !chunks_.empty() || !ends_.empty(); }
  std::vector<std::string> warnings() const;
  /// "run.mcap: chunk at byte 12: what"
  std::string place(std::uint64_t at) const;
  /// The compression of a chunk. Throws Error with the place where there is none.
  Compression compression(std::string_view name, std::uint64_t at) const;

 private:
  std::string file_, index_;
  std::map<std::uint64_t, std::string> chunks_, ends_;
};

}  // namespace imulab::bag
