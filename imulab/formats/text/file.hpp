// Whole files: mapped for reading, written atomically. All throw Error with the path and the reason of the system.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace imulab {

/// Limits: the most that is read from a stream, the most that is read from a file of settings (a session, a calibration, a result), and the most that
/// is copied instead of mapped. Bytes.
inline constexpr std::size_t longest_stream = std::size_t{1} << 30, longest_settings = std::size_t{1} << 26, most_copied = std::size_t{1} << 24;

enum class Content { readings, settings };

/// A file in memory for reading: a long regular file is mapped; a short one, a pipe, a device or standard input ("-") is read to its end. Throws
/// Error where it cannot be opened, is a folder, is a pipe to which nobody writes within seconds, is longer than it may be, or becomes shorter
/// meanwhile (of a mapped file: see unfinished.hpp). An empty file has an empty text.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path, Content content = Content::readings);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  /// Releases the memory before `offset`; the text there can still be read.
  void release(std::size_t offset) const;
  std::string_view text() const { return data_ != nullptr ? std::string_view{data_, size_} : std::string_view{text_}; }

 private:
  std::string text_, message_;
  std::shared_ptr<const std::string> kept_;
  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

/// A pipe, a device, standard input ("-"): read once, and perhaps without an end.
bool is_stream(const std::filesystem::path& path);

struct StreamText {
  std::string text;
  bool ended = true;  ///< else it was read for as long as was allowed
};
/// A stream until its end, or for a time [s] where that is first. Throws Error as MappedFile does.
StreamText read_stream(const std::filesystem::path& path, double longest_s);

/// A file being written: a temporary file in the same folder that gets the name at commit(), when it is on the disk, or is removed. A device, a pipe
/// or standard output ("-") is written directly.
class WholeFile {
 public:
  explicit WholeFile(const std::filesystem::path& path);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  void write(std::string_view text);
  /// Replaces the text written there before; not for a device or a pipe.
  void write_at(std::uint64_t place, std::string_view text);
  /// The name until commit(), for a library that writes by name; empty where it is written directly.
  const std::string& temporary() const { return temporary_; }
  /// The name that it gets.
  const std::filesystem::path& path() const { return path_; }
  /// On the disk under its temporary name, with its mode: the name is all that commit() adds.
  void put_down();
  void commit();

 private:
  std::filesystem::path path_;
  std::string temporary_;  // empty after commit
  int descriptor_ = -1;
};

/// A folder whose files appear all together: filled under another name, renamed at commit(), or removed. One that exists already keeps what it has
/// (`Existing::add`): its new files are filled in below it, and at commit(), when all of them are on the disk, they are renamed one after the other.
/// Only then could a kill leave a part of them, each whole. Where a name is a link, the file is put beside the link's target before, on its disk.
class NewFolder {
 public:
  enum class Existing { refuse, add };  ///< refuse: throws Error where the folder exists and is not empty
  explicit NewFolder(const std::filesystem::path& place, Existing existing = Existing::refuse);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;
  /// The folder in which to write its files until then; no folders.
  const std::filesystem::path& path() const { return filling_; }
  void commit();

 private:
  void move_each();
  std::filesystem::path place_, filling_;
  bool into_existing_ = false, committed_ = false;
};

/// The file that a symbolic link leads to, even if it is not there yet; any other path as it is.
std::filesystem::path behind_links(std::filesystem::path path);

/// Throws Error where no file can begin under this name: its folder is not there, or nothing may be written into it.
void expect_place_for(const std::filesystem::path& path);

/// The name of a file in messages: "-" is "standard input".
std::string input_name(const std::filesystem::path& path);

/// SHA-256 of `text` as 64 hexadecimal digits; by the processor's own instructions where it has them and nothing else is wanted.
std::string sha256(std::string_view text, bool by_instructions = true);

struct FileSum {
  std::string sha256;
  std::uint64_t bytes = 0;
};
/// The checksum of a file of any size, in little memory; of a recording that is several files (several_files.hpp) that of their checksums and names.
/// Throws Error as MappedFile does.
FileSum file_sum(const std::filesystem::path& path);

// A text that is read as if it were a file: rows that came through a pipe, and are read more than once.

/// From now on a file of this name is this text, for all that opens it as MappedFile does.
void keep_as_file(const std::filesystem::path& name, std::string text);
bool is_kept(const std::filesystem::path& path);
/// When nothing reads them any more.
void forget_kept();

/// A text that is kept while this exists: a member of an archive, unpacked.
class KeptFile {
 public:
  KeptFile(std::filesystem::path name, std::string text);
  ~KeptFile();
  KeptFile(const KeptFile&) = delete;
  KeptFile& operator=(const KeptFile&) = delete;

 private:
  std::shared_ptr<const std::string> text_;
};

}  // namespace imulab
