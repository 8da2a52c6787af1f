#include "imulab/io/recording/bag/rewrite.hpp"

#include "imulab/core/error.hpp"
#include "imulab/io/recording/bag/mcap.hpp"
#include "imulab/io/recording/bag/ros1_bag.hpp"
#include "imulab/io/recording/bag/ros2_database.hpp"

namespace imulab::bag {

namespace {

[[noreturn]] void no_bag(const std::filesystem::path& path) { throw Error(path.string() + ": is no bag; expected a bag of ROS 1 or ROS 2"); }

}  // namespace

std::unique_ptr<Bag> open_bag(const std::filesystem::path& path) {
  Buffer buffer;
  const std::string_view head = ByteFile(path).read_some(0, 16, buffer);
  if (is_mcap(head)) return std::make_unique<Mcap>(path);
  if (is_ros1_bag(head)) return std::make_unique<Ros1Bag>(path);
  if (is_sqlite(head)) return open_ros2_database(path);
  no_bag(path);
}

void rewrite_bag(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out) {
  if (out.temporary().empty()) throw Error("a bag is written to a file on disk; expected one, no device and no pipe");
  Buffer buffer;
  const std::string_view head = ByteFile(in).read_some(0, 16, buffer);
  if (is_mcap(head)) return rewrite_mcap(in, topic, change, out);
  if (is_ros1_bag(head)) return rewrite_ros1_bag(in, topic, change, out);
  if (is_sqlite(head)) return rewrite_ros2_database(in, topic, change, out);
  no_bag(in);
}

}  // namespace imulab::bag
