// Files and folders that are being written: what a signal that ends the program has to remove.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

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

// Files that are mapped, and what becomes of the program if another one makes such a file shorter: its pages are gone, and reading them is a signal.

/// "FILE: became shorter while it was read; expected a file that no other program changes".
std::string lost_text(const std::filesystem::path& path);

/// These bytes are a mapped file, and are no more. `message`, which stays where it is until then, is for people, with its line end.
void begin_mapped(const char* data, std::size_t size, const std::string& message);
void end_mapped(const char* data);

/// From now on reading lost pages ends the program with exit code 2, after the message on standard error and the removal of what is unfinished (see
/// unfinished.hpp, which calls this). Any other SIGBUS ends it as always.
void explain_lost_pages(void (*remove_unfinished_and_exit)());

}  // namespace imulab
