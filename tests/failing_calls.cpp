// A library that is loaded before the C library (LD_PRELOAD): the call that the environment names fails, as on a full disk or a broken one.
// IMULAB_FAULT="write 3": the third write of a file in the working folder. IMULAB_FAULT_SEEN: a file that is created when it happens.
#include <climits>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <string>
#include <string_view>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

std::atomic<int> calls{0};

template <class F>
F* next(const char* name) {
  return reinterpret_cast<F*>(dlsym(RTLD_NEXT, name));
}

/// Whether this call is the one to fail.
bool fails(std::string_view name) {
  const char* const fault = std::getenv("IMULAB_FAULT");
  const char* const space = fault != nullptr ? std::strchr(fault, ' ') : nullptr;
  if (space == nullptr || name != std::string_view(fault, static_cast<std::size_t>(space - fault))) return false;
  if (++calls != std::atoi(space)) return false;
  if (const char* const seen = std::getenv("IMULAB_FAULT_SEEN"))
    if (const long file = syscall(SYS_openat, AT_FDCWD, seen, O_CREAT | O_WRONLY, 0600); file >= 0) syscall(SYS_close, file);
  errno = name == "write" || name == "pwrite" ? ENOSPC : EIO;
  return true;
}

/// A file of the test, not of the system.
bool is_ours(const char* path) {
  return path[0] != '/' || std::string_view(path).starts_with(std::getenv("TMPDIR") ? std::getenv("TMPDIR") : "/tmp/");
}

bool is_ours(int descriptor) {
  char target[PATH_MAX + 1] = {};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const long size = syscall(SYS_readlink, link.c_str(), target, PATH_MAX);
  struct stat status {};
  return size > 0 && target[0] == '/' && is_ours(target) && descriptor > STDERR_FILENO && fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* data, size_t size) {
  return is_ours(descriptor) && fails("write") ? -1 : next<ssize_t(int, const void*, size_t)>("write")(descriptor, data, size);
}
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t place) {
  return is_ours(descriptor) && fails("pwrite") ? -1 : next<ssize_t(int, const void*, size_t, off_t)>("pwrite")(descriptor, data, size, place);
}
ssize_t read(int descriptor, void* data, size_t size) {
  return is_ours(descriptor) && fails("read") ? -1 : next<ssize_t(int, void*, size_t)>("read")(descriptor, data, size);
}
int rename(const char* from, const char* to) noexcept {
  return is_ours(from) && fails("rename") ? -1 : next<int(const char*, const char*)>("rename")(from, to);
}
int fchmod(int descriptor, mode_t mode) noexcept {
  return is_ours(descriptor) && fails("fchmod") ? -1 : next<int(int, mode_t)>("fchmod")(descriptor, mode);
}
int mkstemp(char* name) { return is_ours(name) && fails("mkstemp") ? -1 : next<int(char*)>("mkstemp")(name); }
char* mkdtemp(char* name) noexcept { return is_ours(name) && fails("mkdtemp") ? nullptr : next<char*(char*)>("mkdtemp")(name); }
int mkdir(const char* name, mode_t mode) noexcept {
  return is_ours(name) && fails("mkdir") ? -1 : next<int(const char*, mode_t)>("mkdir")(name, mode);
}
FILE* fopen(const char* name, const char* how) {
  return is_ours(name) && fails("fopen") ? nullptr : next<FILE*(const char*, const char*)>("fopen")(name, how);
}
int open(const char* name, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return is_ours(name) && fails("open") ? -1 : next<int(const char*, int, ...)>("open")(name, flags, mode);
}
void* mmap(void* where, size_t size, int protection, int flags, int descriptor, off_t offset) noexcept {
  if (descriptor >= 0 && is_ours(descriptor) && fails("mmap")) return MAP_FAILED;
  return next<void*(void*, size_t, int, int, int, off_t)>("mmap")(where, size, protection, flags, descriptor, offset);
}

}  // extern "C"
