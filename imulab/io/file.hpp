// Files as a whole: mapped for reading, written atomically.
#pragma once

#include <filesystem>
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

/// A file being written: a temporary beside its place that takes its name at commit(), or vanishes. A device or a pipe is written as it is. Throws
/// Error.
class WholeFile {
 public:
  explicit WholeFile(const std::filesystem::path& path);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  void write(std::string_view text);
  void commit();

 private:
  std::filesystem::path path_;
  std::string temporary_;  // empty once it has its name
  int descriptor_ = -1;
};

/// A folder that appears whole or not at all: filled beside its place, then renamed; removed where something went wrong. Throws Error, for a place
/// that holds something too.
class NewFolder {
 public:
  explicit NewFolder(const std::filesystem::path& place);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  const std::filesystem::path& path() const { return filling_; }
  void finish();

 private:
  std::filesystem::path place_, filling_;
  bool finished_ = false;
};

/// Writes `text` to `path` whole or not at all. Throws Error.
void write_whole(const std::filesystem::path& path, std::string_view text);

/// SHA-256 of `text` as 64 hexadecimal digits.
std::string sha256(std::string_view text);

}  // namespace imulab
