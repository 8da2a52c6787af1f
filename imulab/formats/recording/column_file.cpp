#include "imulab/formats/recording/column_file.hpp"

#include "imulab/error.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <limits>
#include <sys/mman.h>
#include <sys/statvfs.h>
#include <utility>

namespace imulab::recording_io {

void expect_room(std::uint64_t bytes) {
  struct statvfs room {};
  if (statvfs(temporary_place(), &room) != 0) temporary_failed("made", errno);
  const std::uint64_t free = static_cast<std::uint64_t>(room.f_bavail) * room.f_frsize;
  if (free < bytes)
    throw Error(fmt::format("{}: has {:.3g} GB free; expected about {:.3g} GB for the recording's columns, TMPDIR names another folder",
                            temporary_place(), 1e-9 * static_cast<double>(free), 1e-9 * static_cast<double>(bytes)));
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
