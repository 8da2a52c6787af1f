// What the system gives elsewhere and WebAssembly does not: calls that emscripten's C library answers with a stand-in, and programs.
#include "imulab/error.hpp"
#include "imulab/formats/recording/child/read_program.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

extern "C" {

long __syscall_fcntl64(long descriptor, long command, ...);

/// Emscripten's begins with a mask that forbids everything.
mode_t umask(mode_t mask) {
  static mode_t now = 022;
  const mode_t before = now;
  now = mask;
  return before;
}

/// Emscripten's knows no F_DUPFD_CLOEXEC; no program is started here.
int fcntl(int descriptor, int command, ...) {
  va_list rest;
  va_start(rest, command);
  const long argument = va_arg(rest, long);
  va_end(rest);
  const long result = __syscall_fcntl64(descriptor, command == F_DUPFD_CLOEXEC ? F_DUPFD : command, argument);
  if (result >= 0) return static_cast<int>(result);
  errno = static_cast<int>(-result);
  return -1;
}

/// Its file systems have no links: a copy, which appears under a name that is free.
int link(const char* from, const char* to) {
  const int source = ::open(from, O_RDONLY), copy = source < 0 ? -1 : ::open(to, O_WRONLY | O_CREAT | O_EXCL, 0644);
  char bytes[1 << 16];
  ssize_t size = copy < 0 ? -1 : 1;
  while (size > 0 && (size = ::read(source, bytes, sizeof bytes)) > 0)
    if (::write(copy, bytes, static_cast<std::size_t>(size)) != size) size = -1;
  const int why = errno;
  if (source >= 0) ::close(source);
  if (copy >= 0) ::close(copy);
  errno = why;
  return size < 0 ? -1 : 0;
}

}  // extern "C"

namespace imulab::recording_io {
namespace {

[[noreturn]] void fail(const ProgramFormat& format, const TableRequest& request) {
  throw Error(fmt::format("{}: is {}, which this build of imulab for WebAssembly does not read; expected another format, such as CSV or NumPy",
                          request.file.string(), format.noun));
}

}  // namespace

std::vector<TableDescription> describe_by_program(const ProgramFormat& format, const TableRequest& request) { fail(format, request); }
TableRows columns_by_program(const ProgramFormat& format, const TableRequest& request, const std::vector<Column>&) { fail(format, request); }

}  // namespace imulab::recording_io
