#include "imulab/formats/recording/bag/kinds.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/recording/bag/mcap.hpp"
#include "imulab/formats/recording/bag/ros1_bag.hpp"
#include "imulab/formats/recording/bag/ros2_database.hpp"

#include <algorithm>

namespace imulab::bag {

namespace {

template <class Kind>
std::unique_ptr<Bag> opened(const std::filesystem::path& path) {
  return std::make_unique<Kind>(path);
}

const BagKind& expected_kind(const std::filesystem::path& path) {
  const BagKind* kind = kind_of(path);
  if (kind == nullptr) throw Error(path.string() + ": is no bag; expected a bag of ROS 1 or ROS 2");
  return *kind;
}

}  // namespace

const std::array<BagKind, 3>& bag_kinds() {
  static const std::array<BagKind, 3> kinds{{{"ROS 1 bag", ".bag", is_ros1_bag, opened<Ros1Bag>, rewrite_ros1_bag},
                                             {"ROS 2 bag in MCAP", ".mcap", is_mcap, opened<Mcap>, rewrite_mcap},
                                             {"ROS 2 bag in SQLite", ".db3", is_sqlite, open_ros2_database, rewrite_ros2_database}}};
  return kinds;
}

const BagKind* kind_of(const std::filesystem::path& path) {
  Buffer buffer;
  const std::string_view head = ByteFile(path).read_some(0, 16, buffer);
  const auto found = std::find_if(bag_kinds().begin(), bag_kinds().end(), [&](const BagKind& kind) { return kind.recognizes(head); });
  return found != bag_kinds().end() ? &*found : nullptr;
}

std::unique_ptr<Bag> open_bag(const std::filesystem::path& path) { return expected_kind(path).open(path); }

void rewrite_bag(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out) {
  if (out.temporary().empty()) throw Error("a bag is written to a file on disk; expected one, no device and no pipe");
  expected_kind(in).rewrite(in, topic, change, out);
}

std::vector<recording_io::TableDescription> describe_bag(const TableRequest& request) {
  const std::unique_ptr<Bag> bag = open_bag(request.file);
  bag->count_messages();
  return describe_topics(*bag);
}

recording_io::RawTable bag_columns(const TableRequest& request, const std::vector<Column>& columns) {
  return topic_columns(*open_bag(request.file), request, columns);
}

}  // namespace imulab::bag
