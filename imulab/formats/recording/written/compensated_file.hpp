// Names of bags.
#pragma once

#include "imulab/session.hpp"

#include <filesystem>

namespace imulab {

struct CompensatedRecording;

/// True if a file is named like a bag: .bag, .mcap or .db3.
bool is_bag_name(const std::filesystem::path& path);

}  // namespace imulab
