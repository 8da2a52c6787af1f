#include "imulab/formats/recording/child/child_channel.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <limits>
#include <new>
#include <poll.h>
#include <sys/mman.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace imulab::recording_io {
namespace {

/// From this size on, bytes go through the shared memory.
constexpr std::size_t through_slots = 4096;

}  // namespace

int beyond_standard(int descriptor) {
  if (descriptor < 0 || descriptor > STDERR_FILENO) return descriptor;
  const int copy = ::fcntl(descriptor, F_DUPFD_CLOEXEC, STDERR_FILENO + 1), why = errno;
  ::close(descriptor);
  errno = why;
  return copy;
}

SharedSlots::SharedSlots() : descriptor_(beyond_standard(::memfd_create("imulab", MFD_CLOEXEC | MFD_ALLOW_SEALING))) {
  // Sealed, since reading what a child has cut off would end this process.
  if (descriptor_ < 0 || ::ftruncate(descriptor_, sizeof(Memory)) != 0 ||
      ::fcntl(descriptor_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    const int why = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    throw std::system_error(why, std::generic_category());
  }
  map();
  ::sem_init(&memory_->empty, 1, count);
}

SharedSlots::SharedSlots(int descriptor) : descriptor_(descriptor) { map(); }

SharedSlots::~SharedSlots() {
  ::munmap(memory_, sizeof(Memory));
  ::close(descriptor_);
}

void SharedSlots::map() {
  void* const memory = ::mmap(nullptr, sizeof(Memory), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_, 0);
  if (memory == MAP_FAILED) {
    ::close(descriptor_);
    throw std::bad_alloc();
  }
  memory_ = static_cast<Memory*>(memory);
  ::madvise(memory_, sizeof(Memory), MADV_DONTFORK);  // no child of another file has it
}

char* SharedSlots::next() { return memory_->slots[turn_++ % count].data(); }

void SharedSlots::wait_for_empty() {
  while (::sem_wait(&memory_->empty) != 0 && errno == EINTR) {
  }
}

void SharedSlots::add_empty() { ::sem_post(&memory_->empty); }

void ToParent::bytes(const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  if (size < through_slots) {
    buffer_.append(from, size);
    if (buffer_.size() > 16 * through_slots) flush();
    return;
  }
  for (std::size_t part = 0; size > 0; from += part, size -= part) {
    part = std::min(size, SharedSlots::slot_bytes);
    slots_.wait_for_empty();
    std::memcpy(slots_.next(), from, part);
    buffer_ += '\0';
    flush();
  }
}

void ToParent::text(std::string_view t) {
  number(t.size());
  bytes(t.data(), t.size());
}

void ToParent::flush() {
  write_all(buffer_.data(), buffer_.size());
  buffer_.clear();
}

void ToParent::next() { number(ChildMarks::part); }

void ToParent::write_all(const char* data, std::size_t size) const {
  while (size > 0) {
    const ssize_t written = ::write(descriptor_, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);
    data += written;
    size -= static_cast<std::size_t>(written);
  }
}

void FromChild::wait_for_pipe() const {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(end_ - std::chrono::steady_clock::now()).count();
  if (left <= 0) throw NoAnswer::late;
  pollfd pipe{.fd = descriptor_, .events = POLLIN, .revents = 0};
  ::poll(&pipe, 1, static_cast<int>(std::min<std::int64_t>(left, std::numeric_limits<int>::max())));  // in vain: the next reading comes here again
}

void FromChild::from_pipe(char* data, std::size_t size) const {
  while (size > 0) {
    const ssize_t got = ::read(descriptor_, data, size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) {
      wait_for_pipe();
      continue;
    }
    if (got == 0) throw NoAnswer::ended;
    if (got < 0) reject();
    data += got;
    size -= static_cast<std::size_t>(got);
  }
}

void FromChild::bytes(void* data, std::size_t size) const {
  char* to = static_cast<char*>(data);
  if (size < through_slots) return from_pipe(to, size);
  parts(size, [&](const char* part, std::size_t bytes) { to = std::copy_n(part, bytes, to); });
}

void FromChild::parts(std::size_t size, const std::function<void(const char* part, std::size_t bytes)>& each) const {
  if (size < through_slots) {
    alignas(std::max_align_t) std::array<char, through_slots> few;
    from_pipe(few.data(), size);
    return each(few.data(), size);
  }
  for (std::size_t part = 0; size > 0; size -= part) {
    char full = 0;
    from_pipe(&full, 1);
    part = std::min(size, SharedSlots::slot_bytes);
    each(slots_.next(), part);
    slots_.add_empty();
  }
}

std::uint64_t FromChild::number() const {
  std::uint64_t n = 0;
  bytes(&n, sizeof n);
  return n;
}

std::size_t FromChild::most(std::size_t size) const {
  const std::uint64_t n = number();
  if (n > most_bytes_ / size) reject();
  return static_cast<std::size_t>(n);
}

std::size_t FromChild::count(std::size_t size) {
  const std::size_t n = most(size);
  most_bytes_ -= n * size;
  return n;
}

void FromChild::reject() const { throw NoAnswer::nonsense; }

std::string FromChild::text() {
  std::string t(count(1), '\0');
  bytes(t.data(), t.size());
  return t;
}

}  // namespace imulab::recording_io
