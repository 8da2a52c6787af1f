// The kinds of bags, in one table: how each is opened, and copied with the readings of one topic replaced. Everything else stays as it is then, byte
// for byte, but for checksums and places that follow from it.
#pragma once

#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/formats/text/file.hpp"

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>

namespace imulab::bag {

struct BagKind {
  std::string_view name, extension;
  bool (*recognizes)(std::string_view head);  ///< by the first 16 bytes
  std::unique_ptr<Bag> (*open)(const std::filesystem::path& path);
  void (*rewrite)(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);
};
const std::array<BagKind, 3>& bag_kinds();
/// The kind of a file; null where it is no bag.
const BagKind* kind_of(const std::filesystem::path& path);

/// Throws Error where it is no bag.
std::unique_ptr<Bag> open_bag(const std::filesystem::path& path);

/// Changes each message of the topic in place, in the order of Bag::each_message; its length stays. Only a chunk is in memory. `out` is not
/// committed. Throws Error for a bag that is damaged or was not closed.
void rewrite_bag(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);

/// What a RecordingFormat has, of bags of every kind (format.hpp).
std::vector<recording_io::TableDescription> describe_bag(const TableRequest& request);
recording_io::RawTable bag_columns(const TableRequest& request, const std::vector<Column>& columns);

}  // namespace imulab::bag
