#include "imulab/formats/recording/column_file.hpp"

#include "imulab/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <limits>
#include <string>
#include <sys/mman.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <utility>

namespace imulab::recording_io {
namespace {

[[noreturn]] void temporary_failed(const char* what, int error) {
  throw Error(fmt::format("{}: a temporary file cannot be {}: {}; expected a folder that can be written, TMPDIR names another", temporary_place(),
                          what, std::strerror(error)));
}

}  // namespace

const char* temporary_place() {
  const char* const named = std::getenv("TMPDIR");
  return named != nullptr && *named != '\0' ? named : "/var/tmp";
}

void expect_room(std::uint64_t bytes) {
  struct statvfs room {};
  if (statvfs(temporary_place(), &room) != 0) temporary_failed("made", errno);
  const std::uint64_t free = static_cast<std::uint64_t>(room.f_bavail) * room.f_frsize;
  if (free < bytes)
    throw Error(fmt::format("{}: has {:.3g} GB free; expected about {:.3g} GB for the recording's columns, TMPDIR names another folder",
                            temporary_place(), 1e-9 * static_cast<double>(free), 1e-9 * static_cast<double>(bytes)));
}

ColumnFile::ColumnFile() {
  std::string name = std::string(temporary_place()) + "/imulab-XXXXXX";
  descriptor_ = mkostemp(name.data(), O_CLOEXEC);
  if (descriptor_ < 0) temporary_failed("made", errno);
  unlink(name.c_str());
}

ColumnFile::~ColumnFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

ColumnFile::ColumnFile(ColumnFile&& from) noexcept : descriptor_(std::exchange(from.descriptor_, -1)), size_(std::exchange(from.size_, 0)) {}

ColumnFile& ColumnFile::operator=(ColumnFile&& from) noexcept {
  std::swap(descriptor_, from.descriptor_);
  std::swap(size_, from.size_);
  return *this;
}

void ColumnFile::write(const void* numbers, std::size_t count) {
  const char* from = static_cast<const char*>(numbers);
  for (std::size_t left = 8 * count; left > 0;) {
    const ssize_t written = ::write(descriptor_, from, left);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) temporary_failed("written", written < 0 ? errno : ENOSPC);
    from += written, left -= static_cast<std::size_t>(written);
  }
  size_ += count;
}

void ColumnFile::read(std::size_t begin, std::span<double> to) const {
  char* into = reinterpret_cast<char*>(to.data());
  off_t place = 8 * static_cast<off_t>(begin);
  for (std::size_t left = to.size_bytes(); left > 0;) {
    const ssize_t there = pread(descriptor_, into, left, place);
    if (there < 0 && errno == EINTR) continue;
    if (there <= 0) temporary_failed("read", there < 0 ? errno : EIO);
    into += there, place += there, left -= static_cast<std::size_t>(there);
  }
}

MappedStamps::MappedStamps(const ColumnFile& file) : size_(file.size()) {
  if (size_ == 0) return;
  if (size_ > std::numeric_limits<std::size_t>::max() / 8) temporary_failed("mapped", ENOMEM);
  void* const memory = mmap(nullptr, 8 * size_, PROT_READ, MAP_SHARED, file.descriptor(), 0);
  if (memory == MAP_FAILED) temporary_failed("mapped", errno);
  data_ = static_cast<const std::int64_t*>(memory);
}

MappedStamps::~MappedStamps() {
  if (data_ != nullptr) munmap(const_cast<std::int64_t*>(data_), 8 * size_);
}

MappedStamps::MappedStamps(MappedStamps&& from) noexcept : data_(std::exchange(from.data_, nullptr)), size_(std::exchange(from.size_, 0)) {}

MappedStamps& MappedStamps::operator=(MappedStamps&& from) noexcept {
  std::swap(data_, from.data_);
  std::swap(size_, from.size_);
  return *this;
}

void MappedStamps::release() const {
  if (data_ != nullptr) madvise(const_cast<std::int64_t*>(data_), 8 * size_, MADV_DONTNEED);
}

}  // namespace imulab::recording_io
