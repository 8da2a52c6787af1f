// The checksum of MCAP, zip archives and many other files.
#pragma once

#include <cstdint>
#include <string_view>

namespace imulab::recording_io {

/// CRC-32 (ISO-HDLC): of more bytes after those of `before`.
std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace imulab::recording_io
