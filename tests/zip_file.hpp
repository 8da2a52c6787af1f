// For tests: zip archives, deflated, whose directory may lie.
#pragma once

#include "imulab/formats/recording/logs/binary.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>
#include <zlib.h>

namespace imulab {

/// Deflated without a head.
inline std::string deflated_text(const std::string& text) {
  z_stream stream{};
  deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// `claimed`: the size that the directory states for each member.
inline std::string zip_file(const std::vector<std::pair<std::string, std::string>>& members, std::optional<std::uint32_t> claimed = {}) {
  using recording_io::append;
  std::string file, directory;
  for (const auto& [name, text] : members) {
    const std::string packed = deflated_text(text);
    std::string common;
    for (const int word : {20, 0, 8, 0, 0x21}) append<std::uint16_t>(common, static_cast<std::uint16_t>(word));
    append<std::uint32_t>(common, recording_io::crc32(text));
    append<std::uint32_t>(common, static_cast<std::uint32_t>(packed.size()));
    append<std::uint32_t>(common, claimed.value_or(static_cast<std::uint32_t>(text.size())));
    append<std::uint16_t>(common, static_cast<std::uint16_t>(name.size()));
    append<std::uint16_t>(common, 0);
    const auto offset = static_cast<std::uint32_t>(file.size());
    file += "PK\3\4" + common + name + packed;
    directory += std::string("PK\1\2\x14\0", 6) + common + std::string(10, '\0');
    append<std::uint32_t>(directory, offset);
    directory += name;
  }
  std::string end("PK\5\6\0\0\0\0", 8);
  for (int k = 0; k < 2; ++k) append<std::uint16_t>(end, static_cast<std::uint16_t>(members.size()));
  append<std::uint32_t>(end, static_cast<std::uint32_t>(directory.size()));
  append<std::uint32_t>(end, static_cast<std::uint32_t>(file.size()));
  append<std::uint16_t>(end, 0);
  return file + directory + end;
}

}  // namespace imulab
