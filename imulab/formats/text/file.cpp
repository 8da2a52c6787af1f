#include "imulab/formats/text/file.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/unfinished.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace imulab {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw Error(path.string() + ": " + what + (errno != 0 ? std::string(": ") + std::strerror(errno) : std::string()));
}

}  // namespace

std::string input_name(const fs::path& path) { return path == "-" ? "standard input" : path.string(); }

fs::path behind_links(fs::path path) {
  constexpr int most_links = 40;  // as Linux
  std::error_code failure;
  for (int i = 0; i < most_links && fs::is_symlink(path, failure); ++i) {
    const fs::path target = fs::read_symlink(path, failure);
    path = target.is_absolute() ? target : path.parent_path() / target;
  }
  return path;
}

void expect_place_for(const fs::path& path) {
  if (is_stream(path)) return;
  const fs::path folder = behind_links(path).parent_path();
  errno = 0;
  if (::access((folder / ".").c_str(), W_OK | X_OK) == 0) return;
  if (errno == ENOENT || errno == ENOTDIR) throw Error(path.string() + ": cannot be written: " + folder.string() + " is no folder");
  fail(path, "cannot be written");
}

namespace {

/// The permissions that the user gives new files and folders.
mode_t usual_mode(mode_t all) {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return all & ~mask;
}

/// Waits until the written bytes are on the disk. The system may keep it in memory for half a minute: after a loss of power the new name would stand
/// for an empty file.
void put_on_disk(int descriptor, const fs::path& path) {
  while (::fsync(descriptor) != 0) {
    if (errno == EINVAL || errno == ENOTSUP || errno == EROFS) return;  // a file system that has no disk
    if (errno != EINTR) fail(path, "cannot be written");
  }
}

/// Waits until the name of a file or folder is on the disk.
void put_name_on_disk(const fs::path& path) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0 && errno == EACCES) return;  // one may write into a folder that one may not list
  if (descriptor < 0) fail(path, "cannot be written");
  try {
    put_on_disk(descriptor, path);
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  ::close(descriptor);
}

}  // namespace

WholeFile::WholeFile(const std::filesystem::path& path) : path_(path == "-" ? "standard output" : path), temporary_(path.string() + ".XXXXXX") {
  if (path == "-") {
    temporary_.clear();
    std::fflush(stdout);
    descriptor_ = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
    if (descriptor_ < 0) fail(path_, "cannot be written");
    return;
  }
  if (is_stream(path)) {  // a file in its place would end it
    temporary_.clear();
    descriptor_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail(path, "cannot be written");
    return;
  }
  path_ = behind_links(path);
  temporary_ = path_.string() + ".XXXXXX";
  errno = 0;
  descriptor_ = ::mkstemp(temporary_.data());  // in the same folder, so that the rename is atomic
  if (descriptor_ < 0) fail(path_, "cannot be written");
  try {
    begin_unfinished(temporary_);
  } catch (...) {  // memory has ended, and nobody destroys what is not made
    ::close(descriptor_);
    ::unlink(temporary_.c_str());
    throw;
  }
}

WholeFile::~WholeFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (temporary_.empty()) return;
  ::unlink(temporary_.c_str());
  try {
    end_unfinished(temporary_);
  } catch (...) {  // a name that is not there any more does no harm
  }
}

void WholeFile::write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor_, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_, "cannot be written");
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void WholeFile::write_at(std::uint64_t place, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::pwrite(descriptor_, text.data(), text.size(), static_cast<off_t>(place));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_, "cannot be written");
    place += static_cast<std::uint64_t>(written);
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void WholeFile::put_down() {
  if (temporary_.empty()) return;
  struct stat before {};  // mkstemp's file is private: a file that was there keeps its mode
  const bool replaces = ::stat(path_.c_str(), &before) == 0 && S_ISREG(before.st_mode);
  const mode_t mode = replaces ? before.st_mode & 07777 : usual_mode(0666);
  if (::fchmod(descriptor_, mode) != 0) fail(path_, "cannot be written");
  put_on_disk(descriptor_, path_);
}

void WholeFile::commit() {
  if (temporary_.empty()) return;
  put_down();
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail(path_, "cannot be written");
  end_unfinished(temporary_);
  temporary_.clear();
  put_name_on_disk(path_);
}

NewFolder::NewFolder(const fs::path& place, Existing existing) : place_(fs::absolute(place).lexically_normal()) {
  if (!place_.has_filename()) place_ = place_.parent_path();  // "out/"
  into_existing_ = existing == Existing::add && fs::is_directory(place_);
  if (!into_existing_ && fs::exists(place_) && !(fs::is_directory(place_) && fs::is_empty(place_)))
    throw Error(place.string() + ": exists; expected a new or an empty folder");
  std::error_code failure;
  fs::create_directories(place_.parent_path(), failure);
  std::string filling = (into_existing_ ? place_ / "new" : place_).string() + ".part-XXXXXX";  // on the same disk
  if (failure || ::mkdtemp(filling.data()) == nullptr) {
    if (!failure) failure = std::error_code(errno, std::generic_category());
    throw Error(place_.string() + ": cannot be made: " + failure.message());
  }
  try {
    filling_ = filling;
    if (::chmod(filling.c_str(), usual_mode(0777)) != 0) throw Error(place_.string() + ": cannot be made: " + std::strerror(errno));
    begin_unfinished(filling_);
  } catch (...) {
    ::rmdir(filling.c_str());
    throw;
  }
}

NewFolder::~NewFolder() {
  std::error_code ignored;
  if (committed_) return;
  try {
    fs::remove_all(filling_, ignored);
    end_unfinished(filling_);
  } catch (...) {  // memory has ended: the folder stays, under a name that blocks nothing
  }
}

void NewFolder::move_each() {
  std::vector<fs::path> files;
  std::vector<std::unique_ptr<WholeFile>> behind;  // links, whose targets may be on another disk, and devices
  for (const fs::directory_entry& file : fs::directory_iterator(filling_)) {
    const fs::path place = place_ / file.path().filename();
    errno = EISDIR;
    if (fs::is_directory(place)) fail(place, "cannot be written");
    const fs::file_status status = fs::symlink_status(place);
    if (!fs::exists(status) || fs::is_regular_file(status)) {
      files.push_back(file.path());
      continue;
    }
    behind.push_back(std::make_unique<WholeFile>(place));
    behind.back()->write(MappedFile(file.path()).text());
    behind.back()->put_down();
  }
  for (const fs::path& file : files) {
    const fs::path place = place_ / file.filename();
    struct stat before {};
    const bool replaces = ::stat(place.c_str(), &before) == 0;
    if ((replaces && ::chmod(file.c_str(), before.st_mode & 07777) != 0) || ::rename(file.c_str(), place.c_str()) != 0)
      fail(place, "cannot be written");
  }
  for (const std::unique_ptr<WholeFile>& file : behind) file->commit();
  std::error_code ignored;
  fs::remove_all(filling_, ignored);
  put_name_on_disk(place_ / "");
}

void NewFolder::commit() {
  if (into_existing_) {
    move_each();
    end_unfinished(filling_);
    committed_ = true;
    return;
  }
  std::error_code failure;
  fs::rename(filling_, place_, failure);
  if (failure) throw Error(place_.string() + ": cannot be made: " + failure.message());
  end_unfinished(filling_);
  committed_ = true;
  put_name_on_disk(place_);
}

void write_whole(const std::filesystem::path& path, std::string_view text) {
  WholeFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace imulab
