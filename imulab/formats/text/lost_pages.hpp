// Files that are mapped, and what becomes of the program if another one makes such a file shorter: its pages are gone, and reading them is a signal.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace imulab {

/// "FILE: became shorter while it was read; expected a file that no other program changes".
std::string lost_text(const std::filesystem::path& path);

/// These bytes are a mapped file, and are no more. `message`, which stays where it is until then, is for people, with its line end.
void begin_mapped(const char* data, std::size_t size, const std::string& message);
void end_mapped(const char* data);

/// From now on reading lost pages ends the program with exit code 2, after the message on standard error and the removal of what is unfinished (see
/// unfinished.hpp, which calls this). Any other SIGBUS ends it as always.
void explain_lost_pages(void (*remove_unfinished_and_exit)());

}  // namespace imulab
