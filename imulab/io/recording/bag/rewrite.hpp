// A bag of any kind opened; copied with the readings of one topic replaced: everything else stays as it is, byte for byte, but for checksums and
// places that follow from it.
#pragma once

#include "imulab/io/recording/bag/topics.hpp"
#include "imulab/io/text/file.hpp"

#include <filesystem>
#include <memory>

namespace imulab::bag {

/// Throws Error where it is no bag.
std::unique_ptr<Bag> open_bag(const std::filesystem::path& path);

/// Changes each message of the topic in place, in the order of Bag::each_message; its length stays. Only a chunk is in memory. `out` is not
/// committed. Throws Error for a bag that is damaged or was not closed.
void rewrite_bag(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);

void rewrite_mcap(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);
void rewrite_ros1_bag(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);
void rewrite_ros2_database(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);

}  // namespace imulab::bag
