// All bags have topics of messages, which are their tables.
#pragma once

#include "imulab/formats/recording/bag/ros_message.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/text/file.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::bag {

struct Topic {
  std::string name;
  std::string type;                  ///< of its messages
  std::string encoding;              ///< "ros1", "cdr" or another name
  std::set<std::uint32_t> channels;  ///< the file's numbers of it
  std::uint64_t messages = 0;

  /// The type of messages that are read, where it is known and so is their encoding; else null.
  const MessageType* readable() const;
  Encoding message_encoding() const { return encoding == "ros1" ? Encoding::ros1 : Encoding::cdr; }
};

/// Adds a channel to the topic of that name, or a topic. Throws Damaged where the topic has another type already.
void add_channel(std::vector<Topic>& topics, std::uint32_t channel, std::string_view name, std::string_view type, std::string_view encoding);
Topic* topic_of(std::vector<Topic>& topics, std::uint32_t channel);

/// Gets each message of a topic in the file's order: when it was logged [ns], and its bytes.
using MessageSink = std::function<void(std::int64_t log_time_ns, std::string_view message)>;
/// Gets each message of a topic, to be changed in place.
using MessageChange = std::function<void(std::span<char> message)>;

/// A bag that is open.
class Bag {
 public:
  virtual ~Bag() = default;
  const std::vector<Topic>& topics() const { return topics_; }
  /// The losses and their consequences.
  const std::vector<std::string>& warnings() const { return warnings_; }
  virtual void each_message(const Topic& topic, const MessageSink& sink) = 0;
  /// Counts the messages of each topic, where that was not done on opening.
  virtual void count_messages() {}

 protected:
  std::vector<Topic> topics_;
  std::vector<std::string> warnings_;
};

/// The topic of that name; without a name, the only one with messages of an IMU. Throws Error that names those that can be read.
const Topic& choose_topic(const std::vector<Topic>& topics, const std::string& name, const std::string& file);

/// Opens a bag of a format, and copies one with the readings of one topic replaced. Everything else then stays as it is, byte for byte, but for
/// checksums and places that follow from it.
struct BagFormat {
  std::string_view extension;
  std::unique_ptr<Bag> (*open)(const std::filesystem::path& path);
  void (*rewrite)(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);
};

template <class Kind>
std::unique_ptr<Bag> opened(const std::filesystem::path& path) {
  return std::make_unique<Kind>(path);
}

/// The format of a bag; null where a file is none.
const RecordingFormat* bag_format(const std::filesystem::path& path);

/// Throws Error where it is no bag.
std::unique_ptr<Bag> open_bag(const std::filesystem::path& path);

/// Changes each message of the topic in place, in the order of Bag::each_message; its length stays. Only a chunk is in memory. `out` is not
/// committed. Throws Error for a bag that is damaged or was not closed.
void rewrite_bag(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);

/// A row of the table of formats.
RecordingFormat bag_row(std::string_view name, bool (*recognizes)(std::string_view head), const BagFormat& format);

}  // namespace imulab::bag
