// The sandbox of imulab-read: a file that takes over the library that reads it can compute and answer, and nothing else.
//
// The kernel refuses every call that is not on a list (seccomp, by libseccomp): the program cannot start another, use the network, write to anything
// but its pipe, or make memory executable. Files can be opened for reading until one is open, and none from then on. Without libseccomp only limits
// of the process hold: no data get into a file, and none is opened once one is open; but it can remove, rename and empty files, and start programs.
#pragma once

#include <filesystem>

namespace imulab::recording_io {

/// Enters the sandbox, in which files can still be opened for reading; `pipe`: the only descriptor to which it can write. Throws Error that names
/// `file` where the system has none: nothing is read without it.
void enter_sandbox(int pipe, const std::filesystem::path& file);

/// From now on nothing can be opened. Throws Error as above.
void close_sandbox(const std::filesystem::path& file);

}  // namespace imulab::recording_io
