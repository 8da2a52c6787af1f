// What all bags have: topics of messages. Each kind of bag gives these, and has its columns and its writer from here.
#pragma once

#include "imulab/formats/recording/bag/ros_message.hpp"
#include "imulab/formats/recording/format.hpp"

#include <cstdint>
#include <functional>
#include <set>
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

  /// Of messages that are read: a type that is known, in an encoding that is.
  const MessageType* readable() const;
  Encoding message_encoding() const { return encoding == "ros1" ? Encoding::ros1 : Encoding::cdr; }
};

/// Adds a channel to the topic of that name, or a topic. Throws Damaged where the topic has another type already.
void add_channel(std::vector<Topic>& topics, std::uint32_t channel, std::string_view name, std::string_view type, std::string_view encoding);
Topic* topic_of(std::vector<Topic>& topics, std::uint32_t channel);

/// Gets each message of a topic in the file's order: when it was logged [ns], and its bytes.
using MessageSink = std::function<void(std::int64_t log_time_ns, std::string_view message)>;
/// The same, to be changed in place.
using MessageChange = std::function<void(std::span<char> message)>;

/// A bag that is open.
class Bag {
 public:
  virtual ~Bag() = default;
  const std::vector<Topic>& topics() const { return topics_; }
  /// What was lost, and what it means.
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

std::vector<recording_io::TableDescription> describe_topics(const Bag& bag);
recording_io::RawTable topic_columns(Bag& bag, const TableRequest& request, const std::vector<Column>& columns);

}  // namespace imulab::bag
