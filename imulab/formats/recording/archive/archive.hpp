// Texts that are compressed, and texts in archives (.csv.gz, .zst, .xz, .bz2, .lz4; .zip, .tar, .tar.gz, .7z), as libarchive reads them. Gunzipping
// is zlib's, which alone compares the checksums. zip.hpp has zip for arrays, which are read where they stand in the file.
#pragma once

#include "imulab/formats/recording/archive/text_tables.hpp"

#include <filesystem>
#include <string_view>
#include <vector>

namespace imulab::recording_io {

/// By the first bytes of a file.
bool is_packed(std::string_view head);

/// The texts, in the order of their names. Throws Error where there is none, where one is encrypted, and where what is packed is cut or damaged.
std::vector<TextMember> texts_of_archive(const std::filesystem::path& path);

}  // namespace imulab::recording_io
