// Files and folders that are being written: what a signal that ends the program has to remove.
#pragma once

#include <filesystem>

namespace imulab {

/// A file, or a folder with all that is in it, is being written under this name; and is no more.
void begin_unfinished(const std::filesystem::path& path);
void end_unfinished(const std::filesystem::path& path);

/// From now on SIGINT, SIGTERM and SIGHUP, unless they are ignored, remove what is unfinished before they end the program as they always do. A
/// limit on the size of files makes writing fail, as a full disk does.
void remove_unfinished_on_signals();

/// From now on an allocation that fails ends the program with exit code 2: `message`, which stays where it is, goes to standard error, and what is
/// unfinished is removed. Not every library is whole after std::bad_alloc. For programs that call remove_unfinished_on_signals(); the child of a fork
/// sets its own handler.
void end_when_memory_ends(const char* message);

}  // namespace imulab
