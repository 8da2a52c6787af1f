#include "imulab/formats/recording/crc32.hpp"

#include <libdeflate.h>

namespace imulab::recording_io {

std::uint32_t crc32(std::string_view bytes, std::uint32_t before) { return libdeflate_crc32(before, bytes.data(), bytes.size()); }

}  // namespace imulab::recording_io
