// Where the files of a session are.
#pragma once

#include "imulab/session.hpp"

#include <filesystem>
#include <string>
#include <string_view>

namespace imulab {

/// The path of a file that the session names: relative to the session's own folder.
std::filesystem::path session_path(const Session& session, const std::string& file);

}  // namespace imulab
