#include "imulab/formats/recording/bag/byte_file.hpp"

#include "imulab/error.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <iterator>
#include <limits>
#include <string>
#include <sys/stat.h>
#include <unistd.h>

namespace imulab::bag {
namespace {

constexpr std::uint64_t most_at_once = std::uint64_t{1} << 30;

[[noreturn]] void cannot(const std::filesystem::path& path, const char* what) {
  throw Error(path.string() + ": cannot be " + what + ": " + std::strerror(errno));
}

}  // namespace

ByteFile::ByteFile(const std::filesystem::path& path) : path_(path), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (descriptor_ < 0) cannot(path, "opened");
  struct stat status {};
  if (::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode)) {
    size_ = static_cast<std::uint64_t>(status.st_size);
    return;
  }
  ::close(descriptor_);
  throw Error(path.string() + ": is not a file on disk; expected one, since a bag is read at several places");
}

ByteFile::~ByteFile() { ::close(descriptor_); }

std::string_view ByteFile::read_some(std::uint64_t offset, std::uint64_t count, Buffer& buffer) const {
  return read(offset, offset < size_ ? std::min(count, size_ - offset) : 0, buffer);
}

std::string_view ByteFile::read(std::uint64_t offset, std::uint64_t count, Buffer& buffer) const {
  if (count == 0) return {};
  if (offset > size_ || count > size_ - offset) throw Damaged("a length points beyond the end of the file");
  if (count > most_at_once) throw Damaged("a length of more than a gigabyte");
  const auto bytes = static_cast<std::size_t>(count);
  char* to = buffer.of(bytes);
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t n = ::pread(descriptor_, to + done, bytes - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) cannot(path_, "read");
    if (n == 0) throw Error(path_.string() + ": became shorter while it was read");
    done += static_cast<std::size_t>(n);
  }
  return {to, bytes};
}

void Copy::write(std::string_view bytes) {
  out_.write(bytes);
  if (checksum_) crc_ = crc32(bytes, crc_);
  written_ += bytes.size();
}

void Copy::until(std::uint64_t place) {
  constexpr std::uint64_t piece = 1 << 20;
  while (taken_ < place) {
    const std::uint64_t count = std::min(piece, place - taken_);
    write(in_.read(taken_, count, buffer_));
    taken_ += count;
  }
}

void Copy::put(std::string_view bytes, std::uint64_t place) {
  write(bytes);
  taken_ = place;
  places_.emplace_back(taken_, written_);
}

std::uint64_t Copy::moved(std::uint64_t place) const {
  const auto after = std::upper_bound(places_.begin(), places_.end(), std::pair(place, std::numeric_limits<std::uint64_t>::max()));
  return after == places_.begin() ? place : place - std::prev(after)->first + std::prev(after)->second;
}

}  // namespace imulab::bag
