// Files as a whole: mapped for reading, written atomically.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace imulab {

/// A file mapped into memory for reading. Throws Error where it cannot be opened or is not a regular file.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::string_view text() const { return {data_, size_}; }

 private:
  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

/// Writes `text` to `path` whole or not at all (a temporary beside it, then a rename). Throws Error.
void write_whole(const std::filesystem::path& path, std::string_view text);

/// SHA-256 of `text` as 64 hexadecimal digits.
std::string sha256(std::string_view text);

}  // namespace imulab
