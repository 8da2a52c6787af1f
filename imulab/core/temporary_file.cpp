#include "imulab/core/temporary_file.hpp"

#include "imulab/error.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <unistd.h>
#include <utility>

namespace imulab {

const char* temporary_place() {
  const char* const named = std::getenv("TMPDIR");
  return named != nullptr && *named != '\0' ? named : "/var/tmp";
}

void temporary_failed(const char* what, int error) {
  throw Error(fmt::format("{}: a temporary file cannot be {}: {}; expected a folder that can be written, TMPDIR names another", temporary_place(),
                          what, std::strerror(error)));
}

TemporaryFile::TemporaryFile() {
  std::string name = std::string(temporary_place()) + "/imulab-XXXXXX";
  descriptor_ = mkostemp(name.data(), O_CLOEXEC);
  if (descriptor_ < 0) temporary_failed("made", errno);
  unlink(name.c_str());
}

TemporaryFile::~TemporaryFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

TemporaryFile::TemporaryFile(TemporaryFile&& from) noexcept : descriptor_(std::exchange(from.descriptor_, -1)), size_(std::exchange(from.size_, 0)) {}

TemporaryFile& TemporaryFile::operator=(TemporaryFile&& from) noexcept {
  std::swap(descriptor_, from.descriptor_);
  std::swap(size_, from.size_);
  return *this;
}

void TemporaryFile::append(std::span<const std::byte> bytes) {
  auto place = static_cast<off_t>(size_);
  for (std::span<const std::byte> left = bytes; !left.empty();) {
    const ssize_t written = pwrite(descriptor_, left.data(), left.size(), place);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) temporary_failed("written", written < 0 ? errno : ENOSPC);
    left = left.subspan(static_cast<std::size_t>(written)), place += written;
  }
  size_ += bytes.size();
}

void TemporaryFile::read(std::uint64_t place, std::span<std::byte> to) const {
  auto from = static_cast<off_t>(place);
  while (!to.empty()) {
    const ssize_t there = pread(descriptor_, to.data(), to.size(), from);
    if (there < 0 && errno == EINTR) continue;
    if (there <= 0) temporary_failed("read", there < 0 ? errno : EIO);
    to = to.subspan(static_cast<std::size_t>(there)), from += there;
  }
}

void TemporaryFile::take_back(std::span<std::byte> to) {
  read(size_ - to.size(), to);
  size_ -= to.size();
  if (ftruncate(descriptor_, static_cast<off_t>(size_)) != 0) temporary_failed("cut", errno);
}

}  // namespace imulab
