// A new MCAP file with messages of one topic.
#pragma once

#include "imulab/formats/recording/bag/chunk.hpp"
#include "imulab/formats/text/file.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab::bag {

/// What a reader has to know of a topic of ROS 2.
struct NewTopic {
  std::string_view name, type;  ///< "/odometry", "nav_msgs/msg/Odometry"
  std::string_view definition;  ///< of the message and those in it, as ros2msg
};

/// Chunks of a megabyte with their indexes, and a summary. The file appears with `commit`, or not at all.
class McapWriter {
 public:
  /// Throws Error where the file cannot be written.
  McapWriter(const std::filesystem::path& path, const NewTopic& topic);

  /// `cdr`: the message with its four bytes of encapsulation; `time` [ns].
  void add(std::int64_t time, std::string_view cdr);
  void commit();

 private:
  struct Chunk {
    std::int64_t first = 0, last = 0;
    std::uint64_t place = 0, length = 0, index_length = 0, packed = 0, size = 0;
  };

  void put(std::string_view bytes);
  void write_chunk();
  std::string summary_of(const Chunk& chunk) const;

  WholeFile file_;
  std::string channel_;  // records of the schema and the channel
  std::string records_;  // of the chunk that grows
  std::vector<std::pair<std::int64_t, std::uint64_t>> index_;
  std::vector<Chunk> chunks_;
  std::uint64_t written_ = 0, messages_ = 0;
  std::string_view compression_;
};

}  // namespace imulab::bag
