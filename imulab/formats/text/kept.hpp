// A text that is read as if it were a file: rows that came through a pipe, and are read more than once.
#pragma once

#include <filesystem>
#include <string>

namespace imulab {

/// From now on a file of this name is this text, for all that opens it as MappedFile does.
void keep_as_file(const std::filesystem::path& name, std::string text);
bool is_kept(const std::filesystem::path& path);
/// When nothing reads them any more.
void forget_kept();

}  // namespace imulab
