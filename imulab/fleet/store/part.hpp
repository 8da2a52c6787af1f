// The store of a part of a fleet's sessions: which part, of which task, and whether it is finished.
#pragma once

#include "imulab/core/part_file.hpp"
#include "imulab/fleet.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace imulab::fleet {

/// Marks a store as a part that is being made, or goes on with it. `task`: a work's identity. Throws Error where the store is another part, or has
/// units without being one.
void begin_part(FleetStore& store, PartNumber part, const std::string& task);
/// Marks it as finished.
void end_part(FleetStore& store);

/// Throws Error where the store is a part, which takes nothing else.
void expect_no_part(FleetStore& store);

/// The stores in the order of their parts; as they are where none of them is a part. Throws Error for parts that are missing, there twice, of
/// different tasks or not finished.
std::vector<std::filesystem::path> all_parts(std::vector<std::filesystem::path> stores);

}  // namespace imulab::fleet
