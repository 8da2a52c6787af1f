// The checksum of MCAP.
#pragma once

#include <cstdint>
#include <string_view>

namespace imulab::bag {

/// CRC-32 as in zlib: of more bytes after those of `before`.
std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace imulab::bag
