// Files and folders that are being written: what a signal that ends the program has to remove.
#pragma once

#include <filesystem>

namespace imulab {

/// A file, or a folder with all that is in it, is being written under this name; and is no more.
void begin_unfinished(const std::filesystem::path& path);
void end_unfinished(const std::filesystem::path& path);

/// From now on SIGINT, SIGTERM and SIGHUP, unless they are ignored, remove what is unfinished before they end the program as they always do.
void remove_unfinished_on_signals();

}  // namespace imulab
