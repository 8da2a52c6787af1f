#include "imulab/formats/recording/child.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/memory.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <fstream>
#include <mutex>
#include <new>
#include <string_view>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#ifdef IMULAB_ADDRESS_SANITIZER
#include <sanitizer/common_interface_defs.h>
#endif

namespace imulab::recording_io {
namespace {

constexpr std::uint64_t part_mark = 0x1b6d756c61627265, error_mark = 0x1b6d756c61626572, end_mark = 0x1b6d756c6162656e;

/// The child ended before its answer did, or its answer makes no sense.
struct NoAnswer {};

/// From this size on, bytes go through the shared memory.
constexpr std::size_t through_slots = 4096;

/// Lowers a limit of this process.
void limit(int resource, rlim_t most) {
  rlimit now{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  now.rlim_cur = std::min(now.rlim_cur, most);
  ::setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

/// The address space that the program takes now.
[[maybe_unused]] std::uint64_t addresses_bytes() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Makes a process of the child: it dies of what goes wrong, says nothing, leaves no core file, and does not outlive its parent.
void prepare_child(const ChildLimits& limits) {
  std::set_new_handler(nullptr);  // the parent's may end it by a thread that is not here
  for (int number = 1; number < NSIG; ++number) {
    struct sigaction now {};
    const bool deadly = number == SIGALRM || number == SIGXCPU || number == SIGSEGV || number == SIGABRT || number == SIGPIPE;
    if (::sigaction(number, nullptr, &now) == 0 && (deadly || now.sa_handler != SIG_IGN)) std::signal(number, SIG_DFL);
  }
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (const int nothing = ::open("/dev/null", O_WRONLY); nothing >= 0) ::dup2(nothing, STDOUT_FILENO), ::dup2(nothing, STDERR_FILENO);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, limits.computing_s);
#ifdef IMULAB_ADDRESS_SANITIZER
  __sanitizer_set_death_callback(nullptr);  // a fuzzer's: what the library does wrong is no finding
#else
  limit(RLIMIT_AS, addresses_bytes() + limits.memory_bytes);
#endif
  ::alarm(limits.wall_s);
}

[[noreturn]] void be_child(int descriptor, SharedSlots& slots, const ChildTask& task, const std::function<void(ToParent&)>& work) {
  prepare_child(task.limits);
  ToParent to(descriptor, slots);
  const auto fail = [&](std::string_view text) {
    to.number(error_mark);
    to.text(text);
  };
  try {
    work(to);
  } catch (const Error& e) {
    fail(e.what());
  } catch (const std::bad_alloc&) {
    fail(fmt::format("{}: is damaged: {} needs more memory for it than a file of its size can hold", task.file.string(), task.library));
  } catch (const std::exception& e) {
    fail(fmt::format("{}: {}", task.file.string(), e.what()));
  }
  to.number(end_mark);
  to.flush();
  ::_exit(0);  // without the program's destructors and unwritten output
}

/// A running child and the pipe from it; stopped and waited for at the end, so that no zombie stays.
class Child {
 public:
  Child(pid_t id, int descriptor, SharedSlots& slots) : id_(id), descriptor_(descriptor), slots_(slots) {}
  ~Child() {
    close_pipe();
    int status = 0;
    if (id_ > 0 && ::waitpid(id_, &status, WNOHANG) == 0) ::kill(id_, SIGKILL), wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  int descriptor() const { return descriptor_; }

  /// The child's exit status after a wrong answer; 0 in a program that ignores its children and is not told.
  int end() {
    close_pipe();        // so that it does not wait for a reader,
    slots_.add_empty();  // nor for a slot
    return wait();
  }

 private:
  void close_pipe() {
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  }
  int wait() {
    int status = 0;
    while (::waitpid(id_, &status, 0) < 0)
      if (errno != EINTR) return 0;
    id_ = 0;
    return status;
  }

  pid_t id_;
  int descriptor_;
  SharedSlots& slots_;
};

Child start_child(const ChildTask& task, SharedSlots& slots, const std::function<void(ToParent&)>& work) {
  // One at a time, so that no child holds another's end of a pipe open.
  static std::mutex starting;
  const std::lock_guard lock(starting);
  int ends[2];
  const auto fail = [&](const char* what) {
    throw Error(fmt::format("{}: cannot be read: {}: {}", task.file.string(), what, std::generic_category().message(errno)));
  };
  if (::pipe2(ends, O_CLOEXEC) != 0) fail("no pipe");
  slots.keep_from_children(false);
  const pid_t id = ::fork();
  if (id != 0) slots.keep_from_children(true);
  if (id == 0) {
    ::close(ends[0]);  // so that a parent that reads no more is noticed
    be_child(ends[1], slots, task, work);
  }
  ::close(ends[1]);
  if (id < 0) {
    ::close(ends[0]);
    fail("no process");
  }
  return {id, ends[0], slots};
}

std::string failure(const ChildTask& task, int status) {
  const auto text = [&](const std::string& how) {
    return fmt::format("{}: is damaged: {} failed on it ({}); expected a whole file", task.file.string(), task.library, how);
  };
  if (!WIFSIGNALED(status)) return text(fmt::format("it ended with code {}", WIFEXITED(status) ? WEXITSTATUS(status) : 0));
  if (WTERMSIG(status) == SIGXCPU) return text(fmt::format("no end after {} s of computing", task.limits.computing_s));
  if (WTERMSIG(status) == SIGPIPE) return text("its answer makes no sense");
  if (WTERMSIG(status) == SIGALRM) return text(fmt::format("no end after {} s", task.limits.wall_s));
  const char* const name = ::sigdescr_np(WTERMSIG(status));
  std::string how = name != nullptr ? name : fmt::format("signal {}", WTERMSIG(status));
  std::transform(how.begin(), how.begin() + 1, how.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text(how);
}

}  // namespace

ChildLimits child_limits(std::uint64_t file_bytes) {
  constexpr std::uint64_t megabyte = 1'000'000, most_packed = 2200;
  const auto machine = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const std::uint64_t file = std::min<std::uint64_t>(file_bytes, machine) * most_packed;
  const auto computing_s = static_cast<unsigned>(10 + std::min<std::uint64_t>(file_bytes / megabyte, 1'000'000));
  return {std::min(512 * megabyte + file, machine), computing_s, 6 * computing_s};
}

ChildTask child_task(const std::filesystem::path& file, const std::string& library) {
  std::error_code missing;
  const std::uintmax_t bytes = std::filesystem::file_size(file, missing);
  return {file, library, child_limits(missing ? 0 : bytes)};
}

SharedSlots::SharedSlots() {
  void* const memory = ::mmap(nullptr, sizeof(Memory), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  memory_ = static_cast<Memory*>(memory);
  keep_from_children(true);
  ::sem_init(&memory_->empty, 1, count);
}

SharedSlots::~SharedSlots() { ::munmap(memory_, sizeof(Memory)); }

void SharedSlots::keep_from_children(bool keep) { ::madvise(memory_, sizeof(Memory), keep ? MADV_DONTFORK : MADV_DOFORK); }

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

void ToParent::next() { number(part_mark); }

void ToParent::write_all(const char* data, std::size_t size) const {
  while (size > 0) {
    const ssize_t written = ::write(descriptor_, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);
    data += written;
    size -= static_cast<std::size_t>(written);
  }
}

void FromChild::from_pipe(char* data, std::size_t size) const {
  while (size > 0) {
    const ssize_t got = ::read(descriptor_, data, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw NoAnswer();
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
  if (n > most_bytes_ / size) throw NoAnswer();
  return static_cast<std::size_t>(n);
}

std::size_t FromChild::count(std::size_t size) {
  const std::size_t n = most(size);
  most_bytes_ -= n * size;
  return n;
}

void FromChild::reject() const { throw NoAnswer(); }

std::string FromChild::text() {
  std::string t(count(1), '\0');
  bytes(t.data(), t.size());
  return t;
}

void run_in_child(const ChildTask& task, const std::function<void(ToParent&)>& work, const std::function<void(FromChild&)>& take) {
  SharedSlots slots;
  Child child = start_child(task, slots, work);
  FromChild from(child.descriptor(), slots, task.limits.memory_bytes);
  std::string error;
  try {
    std::uint64_t mark = 0;
    while ((mark = from.number()) == part_mark) take(from);
    if (mark == error_mark) error = from.text(), mark = from.number();
    if (mark != end_mark) throw NoAnswer();
  } catch (const NoAnswer&) {
    throw Error(failure(task, child.end()));
  }
  if (!error.empty()) throw Error(error);
}

}  // namespace imulab::recording_io
