// Work in a child process, and its answer: for libraries that a damaged file can crash.
#pragma once

#include "imulab/formats/recording/child/child_channel.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <sys/types.h>
#include <unistd.h>

namespace imulab::recording_io {

/// The limits of a child. The memory comes on top of what the program has when the child starts; it is not limited under the address sanitizer.
struct ChildLimits {
  std::uint64_t memory_bytes = 0;
  unsigned computing_s = 0, wall_s = 0;
};

/// Enough for any file of this size, packed as well as deflate can, on a slow machine: 512 MB and 2200 times the file, at most what the machine has;
/// 10 s of computing and 1 s per MB; six times that of wall time.
ChildLimits child_limits(std::uint64_t file_bytes);

/// A file and the library that reads it, for messages: "libhdf5".
struct ChildTask {
  std::filesystem::path file;
  std::string library;
  ChildLimits limits;
  pid_t parent = ::getpid();  ///< without which the child ends
};
ChildTask child_task(const std::filesystem::path& file, const std::string& library);

/// Makes a process that calls answer_parent with these descriptors: its id, or -1 with errno.
using StartChild = std::function<pid_t(int pipe, int memory)>;

/// Starts a child and calls `take` for each part that it sends; the program is not touched by what happens in the child. Throws Error with the text
/// of an Error that the child's work throws, and "FILE: is damaged: LIBRARY failed on it (segmentation fault)" where the child dies, exceeds its
/// limits or sends nonsense; it is killed then. May be called from several threads at once.
void run_in_child(const ChildTask& task, const StartChild& start, const std::function<void(FromChild&)>& take);

/// The child: `work` sends its answer, within the limits of the task, silently, without a core file or any other descriptor, and not longer than the
/// parent lives.
[[noreturn]] void answer_parent(int pipe, int memory, const ChildTask& task, const std::function<void(ToParent&)>& work);

/// Lowers a limit of this process (RLIMIT_CPU ...) for good.
void lower_limit(int resource, std::uint64_t most);

}  // namespace imulab::recording_io
