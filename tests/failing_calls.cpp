// A library that is loaded before the C library (LD_PRELOAD): the call that the environment names fails, as on a full disk or a broken one.
// IMULAB_FAULT="write 3": the third write of a file in the working folder. IMULAB_FAULT="malloc 3": the third allocation after main() begins.
// IMULAB_FAULT_SEEN: a file that is created when it happens. IMULAB_FAULT="malloc 0" and the like: none fails, and that file gets their number.
#include <climits>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <string_view>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

// On 32 bits these calls, with offsets of 64, have the names of those with 64 in them, and are defined once.
#if __SIZEOF_POINTER__ == 4
#define WITH_OFFSET(name) name "64"
#else
#define WITH_OFFSET(name) name
#endif

extern "C" void* __libc_malloc(size_t size);

namespace {

std::atomic<long> calls{0};
std::atomic<bool> in_main{false};

template <class F>
F* next(const char* name) {
  return reinterpret_cast<F*>(dlsym(RTLD_NEXT, name));
}

void write_seen(long number) {
  const char* const seen = std::getenv("IMULAB_FAULT_SEEN");
  const long file = seen != nullptr ? syscall(SYS_openat, AT_FDCWD, seen, O_CREAT | O_WRONLY, 0600) : -1;
  if (file < 0) return;
  char text[24];
  char* begin = text + sizeof text;
  do {
    *--begin = static_cast<char>('0' + number % 10);
    number /= 10;
  } while (number != 0);
  syscall(SYS_write, file, begin, text + sizeof text - begin);
  syscall(SYS_close, file);
}

/// True for the call that has to fail.
bool fails(std::string_view name) {
  static const char* const fault = std::getenv("IMULAB_FAULT");
  static const char* const space = fault != nullptr ? std::strchr(fault, ' ') : nullptr;
  if (space == nullptr || name != std::string_view(fault, static_cast<std::size_t>(space - fault))) return false;
  if (++calls != std::atol(space)) return false;
  write_seen(calls);
  errno = name == "malloc" ? ENOMEM : name == "write" || name == "pwrite" ? ENOSPC : EIO;
  return true;
}

/// A file of the test, not of the system.
bool is_ours(const char* path) {
  const char* const place = std::getenv("TMPDIR");
  return path[0] != '/' || std::string_view(path).starts_with(place != nullptr ? place : "/tmp/");
}

bool is_ours(int descriptor, bool folder = false) {
  char target[PATH_MAX + 1] = {}, link[40];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const long size = syscall(SYS_readlinkat, AT_FDCWD, link, target, PATH_MAX);
  struct stat status {};
  return size > 0 && target[0] == '/' && is_ours(target) && descriptor > STDERR_FILENO && fstat(descriptor, &status) == 0 &&
         (S_ISREG(status.st_mode) || (folder && S_ISDIR(status.st_mode)));
}

int (*real_main)(int, char**, char**) = nullptr;

int counted_main(int count, char** arguments, char** environment) {
  in_main = true;
  const int code = real_main(count, arguments, environment);
  in_main = false;
  if (const char* const fault = std::getenv("IMULAB_FAULT"); fault != nullptr && std::strstr(fault, " 0") != nullptr) write_seen(calls);
  return code;
}

}  // namespace

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int count, char** arguments, void (*begin)(), void (*end)(), void (*loader_end)(),
                      void* stack) {
  real_main = main;
  using Start = int(int (*)(int, char**, char**), int, char**, void (*)(), void (*)(), void (*)(), void*);
  return next<Start>("__libc_start_main")(counted_main, count, arguments, begin, end, loader_end, stack);
}

void* malloc(size_t size) { return in_main && fails("malloc") ? nullptr : __libc_malloc(size); }

ssize_t write(int descriptor, const void* data, size_t size) {
  return is_ours(descriptor) && fails("write") ? -1 : next<ssize_t(int, const void*, size_t)>("write")(descriptor, data, size);
}
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t place) {
  return is_ours(descriptor) && fails("pwrite")
             ? -1
             : next<ssize_t(int, const void*, size_t, off_t)>(WITH_OFFSET("pwrite"))(descriptor, data, size, place);
}
ssize_t read(int descriptor, void* data, size_t size) {
  return is_ours(descriptor) && fails("read") ? -1 : next<ssize_t(int, void*, size_t)>("read")(descriptor, data, size);
}
ssize_t pread(int descriptor, void* data, size_t size, off_t place) {
  return is_ours(descriptor) && fails("pread") ? -1 : next<ssize_t(int, void*, size_t, off_t)>(WITH_OFFSET("pread"))(descriptor, data, size, place);
}
int fsync(int descriptor) { return is_ours(descriptor, true) && fails("fsync") ? -1 : next<int(int)>("fsync")(descriptor); }
int fdatasync(int descriptor) { return is_ours(descriptor, true) && fails("fsync") ? -1 : next<int(int)>("fdatasync")(descriptor); }
int ftruncate(int descriptor, off_t size) noexcept {
  return is_ours(descriptor) && fails("ftruncate") ? -1 : next<int(int, off_t)>(WITH_OFFSET("ftruncate"))(descriptor, size);
}
int rename(const char* from, const char* to) noexcept {
  return is_ours(from) && fails("rename") ? -1 : next<int(const char*, const char*)>("rename")(from, to);
}
int link(const char* from, const char* to) noexcept {
  return is_ours(from) && fails("link") ? -1 : next<int(const char*, const char*)>("link")(from, to);
}
int fchmod(int descriptor, mode_t mode) noexcept {
  return is_ours(descriptor) && fails("fchmod") ? -1 : next<int(int, mode_t)>("fchmod")(descriptor, mode);
}
int mkstemp(char* name) { return is_ours(name) && fails("mkstemp") ? -1 : next<int(char*)>(WITH_OFFSET("mkstemp"))(name); }
char* mkdtemp(char* name) noexcept { return is_ours(name) && fails("mkdtemp") ? nullptr : next<char*(char*)>("mkdtemp")(name); }
int mkdir(const char* name, mode_t mode) noexcept {
  return is_ours(name) && fails("mkdir") ? -1 : next<int(const char*, mode_t)>("mkdir")(name, mode);
}
FILE* fopen(const char* name, const char* how) {
  return is_ours(name) && fails("fopen") ? nullptr : next<FILE*(const char*, const char*)>(WITH_OFFSET("fopen"))(name, how);
}
size_t fwrite(const void* data, size_t size, size_t count, FILE* file) {
  return is_ours(fileno(file)) && fails("fwrite") ? 0 : next<size_t(const void*, size_t, size_t, FILE*)>("fwrite")(data, size, count, file);
}
int open(const char* name, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return is_ours(name) && fails("open") ? -1 : next<int(const char*, int, ...)>(WITH_OFFSET("open"))(name, flags, mode);
}
void* mmap(void* where, size_t size, int protection, int flags, int descriptor, off_t offset) noexcept {
  if (descriptor >= 0 && is_ours(descriptor) && fails("mmap")) return MAP_FAILED;
  return next<void*(void*, size_t, int, int, int, off_t)>(WITH_OFFSET("mmap"))(where, size, protection, flags, descriptor, offset);
}
#if __SIZEOF_POINTER__ == 8
ssize_t pwrite64(int descriptor, const void* data, size_t size, off64_t place) { return pwrite(descriptor, data, size, place); }
ssize_t pread64(int descriptor, void* data, size_t size, off64_t place) { return pread(descriptor, data, size, place); }
int ftruncate64(int descriptor, off64_t size) noexcept { return ftruncate(descriptor, size); }
int open64(const char* name, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return open(name, flags, mode);
}
void* mmap64(void* where, size_t size, int protection, int flags, int descriptor, off64_t offset) noexcept {
  return mmap(where, size, protection, flags, descriptor, offset);
}
#endif

}  // extern "C"
