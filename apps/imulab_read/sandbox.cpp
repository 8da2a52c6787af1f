#include "apps/imulab_read/sandbox.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/child/child.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <fcntl.h>
#include <initializer_list>
#include <memory>
#include <new>
#include <string>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <system_error>
#include <unistd.h>
#include <vector>

#ifdef IMULAB_WITH_SECCOMP
#include <seccomp.h>
#endif

namespace imulab::recording_io {

#ifdef IMULAB_WITH_SECCOMP

namespace {

struct ReleaseFilter {
  void operator()(void* filter) const { seccomp_release(filter); }
};

/// A list of what the kernel lets through; everything else is an error of the call (EPERM), as for a missing file.
class Filter {
 public:
  Filter() : filter_(seccomp_init(SCMP_ACT_ERRNO(EPERM))) {
    if (!filter_) throw std::bad_alloc();
    seccomp_attr_set(filter_.get(), SCMP_FLTATR_CTL_SSB, 1);  // the processor's speculation stays as it is: there is no secret in this process
  }
  /// Calls that another processor or kernel does not have are passed over.
  void allow(std::initializer_list<const char*> calls, const std::vector<scmp_arg_cmp>& conditions = {}) {
    for (const char* name : calls)
      if (const int call = seccomp_syscall_resolve_name(name); call != __NR_SCMP_ERROR && failed_ == 0)
        failed_ = seccomp_rule_add_array(filter_.get(), SCMP_ACT_ALLOW, call, static_cast<unsigned>(conditions.size()), conditions.data());
  }
  void load(const std::filesystem::path& file) {
    if (failed_ == 0) failed_ = seccomp_load(filter_.get());
    if (failed_ != 0)
      throw Error(
          fmt::format("{}: is not read, since this system offers no sandbox for it (seccomp: {}); expected a kernel with CONFIG_SECCOMP_FILTER, "
                      "or an imulab-read built with -DIMULAB_WITH_SECCOMP=OFF",
                      file.string(), std::generic_category().message(-failed_)));
  }

 private:
  std::unique_ptr<void, ReleaseFilter> filter_;
  int failed_ = 0;
};

/// Memory, reading what is open, time, and an end.
void allow_computing(Filter& filter) {
  filter.allow(
      {"read", "readv", "pread64", "preadv", "lseek", "_llseek", "fstat", "fstat64", "newfstatat", "fstatat64", "statx", "fadvise64", "close"});
  filter.allow({"brk", "munmap", "mremap", "madvise", "futex", "futex_time64", "sysinfo", "getrandom", "sched_yield"});
  filter.allow({"mmap", "mmap2", "mprotect"}, {{2, SCMP_CMP_MASKED_EQ, PROT_EXEC, 0}});
  filter.allow({"clock_gettime", "clock_gettime64", "gettimeofday", "time", "restart_syscall", "exit", "exit_group"});
  filter.allow({"rt_sigaction", "rt_sigprocmask", "rt_sigreturn", "sigreturn", "sigaltstack", "getpid", "gettid"});
  filter.allow({"tgkill"}, {{0, SCMP_CMP_EQ, static_cast<scmp_datum_t>(::getpid()), 0}});  // abort()
}

/// The condition that an argument, of which the kernel takes 32 bits, is this one.
std::vector<scmp_arg_cmp> argument_is(unsigned argument, int number) {
  return {{argument, SCMP_CMP_MASKED_EQ, 0xffffffff, static_cast<scmp_datum_t>(number)}};
}

int answers_to = -1;

Filter closed_filter() {
  Filter filter;
  allow_computing(filter);
  filter.allow({"write"}, {{0, SCMP_CMP_EQ, static_cast<scmp_datum_t>(answers_to), 0}});
  return filter;
}

}  // namespace

void enter_sandbox(int pipe, const std::filesystem::path& file) {
  constexpr scmp_datum_t writing = O_ACCMODE | O_CREAT | O_TRUNC | O_APPEND;
  answers_to = pipe;
  Filter filter = closed_filter();
  filter.allow({"open"}, {{1, SCMP_CMP_MASKED_EQ, writing, O_RDONLY}});
  filter.allow({"openat"}, {{2, SCMP_CMP_MASKED_EQ, writing, O_RDONLY}});
  filter.allow({"stat", "stat64", "lstat", "lstat64", "access", "faccessat", "faccessat2", "readlink", "readlinkat", "getcwd", "flock"});
  for (const int command : {F_GETFD, F_SETFD, F_GETFL, F_GETLK, F_SETLK})  // others can make the kernel send signals
    filter.allow({"fcntl", "fcntl64"}, argument_is(1, command));
  filter.allow({"seccomp"});  // to close it
  for (const int option : {PR_SET_NO_NEW_PRIVS, PR_SET_SECCOMP}) filter.allow({"prctl"}, argument_is(0, option));
  filter.load(file);
}

void close_sandbox(const std::filesystem::path& file) { closed_filter().load(file); }

#else

void enter_sandbox(int, const std::filesystem::path&) {}
void close_sandbox(const std::filesystem::path&) { lower_limit(RLIMIT_NOFILE, 0); }

#endif

}  // namespace imulab::recording_io
