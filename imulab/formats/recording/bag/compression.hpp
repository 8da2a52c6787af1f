// The compressions of a bag's chunks.
#pragma once

#include "imulab/formats/recording/bag/bytes.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace imulab::bag {

enum class Compression { none, lz4, zstd, bzip2 };

/// By its name in a file: "", "none", "lz4", "zstd", "bz2". Throws Damaged where it is unknown, and Error where this build has not its library.
Compression compression_of(std::string_view name);

/// `packed` unpacked, in `buffer` (or `packed` itself where it is not compressed). Memory grows with what is found, not with what `size` promises.
/// Throws Damaged where it is not exactly `size` bytes.
std::string_view unpack(Compression compression, std::string_view packed, std::uint64_t size, Buffer& buffer);

/// The reverse. LZ4 is a frame of independent blocks with a checksum, which ROS 1 asks for.
std::string pack(Compression compression, std::string_view bytes);

}  // namespace imulab::bag
