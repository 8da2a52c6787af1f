#include "imulab/io/file.hpp"

#include "imulab/core/error.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace imulab {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw Error(path.string() + ": " + what + (errno != 0 ? std::string(": ") + std::strerror(errno) : std::string()));
}

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

bool write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path) {
  errno = 0;
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.fd < 0) fail(path, "cannot be opened");
  struct stat status {};
  if (::fstat(file.fd, &status) != 0) fail(path, "cannot be read");
  if (!S_ISREG(status.st_mode)) throw Error(path.string() + ": is not a regular file");
  size_ = static_cast<std::size_t>(status.st_size);
  if (size_ == 0) return;  // nothing to map
  void* mapped = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file.fd, 0);
  if (mapped == MAP_FAILED) fail(path, "cannot be read");
  ::madvise(mapped, size_, MADV_SEQUENTIAL);
  data_ = static_cast<const char*>(mapped);
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<char*>(data_), size_);
}

void write_whole(const std::filesystem::path& path, std::string_view text) {
  errno = 0;
  std::string temporary = path.string() + ".XXXXXX";  // in the same folder, so that the rename is atomic
  const Descriptor file{::mkstemp(temporary.data())};
  if (file.fd < 0) fail(path, "cannot be written");
  const mode_t mask = ::umask(0);
  ::umask(mask);
  if (!write_all(file.fd, text) || ::fchmod(file.fd, 0666 & ~mask) != 0 || std::rename(temporary.c_str(), path.c_str()) != 0) {
    const int reason = errno;
    ::unlink(temporary.c_str());
    errno = reason;
    fail(path, "cannot be written");
  }
}

}  // namespace imulab
