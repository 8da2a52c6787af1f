// Bags of ROS 2 that are not one file as it stands: what to name or to do instead.
#pragma once

#include <filesystem>
#include <string_view>

namespace imulab::bag {

/// Throws Error that names the files in it for a folder with the metadata.yaml of a bag.
void expect_no_folder(const std::filesystem::path& path);
/// Throws Error that says how to unpack a file that is compressed as a whole, by its first bytes.
void expect_not_packed(const std::filesystem::path& path, std::string_view head);

}  // namespace imulab::bag
