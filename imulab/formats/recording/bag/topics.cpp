#include "imulab/formats/recording/bag/topics.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/text/reading_meter.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace imulab::bag {
namespace {

/// "/imu0 (sensor_msgs/Imu), /cam0 (sensor_msgs/Image)"
std::string topic_names(const std::vector<Topic>& topics) {
  std::string names;
  for (const Topic& topic : topics)
    names += fmt::format("{}{} ({}{})", names.empty() ? "" : ", ", topic.name, topic.type,
                         topic.readable() == nullptr && message_type(topic.type) != nullptr ? " in " + topic.encoding : "");
  return names.empty() ? "none" : names;
}

constexpr std::uint64_t most_reserved = 1 << 22;  // rows, of a count that the file says: more only as they come

}  // namespace

const MessageType* Topic::readable() const { return encoding == "ros1" || encoding == "cdr" ? message_type(type) : nullptr; }

void add_channel(std::vector<Topic>& topics, std::uint32_t channel, std::string_view name, std::string_view type, std::string_view encoding) {
  const auto found = std::find_if(topics.begin(), topics.end(), [&](const Topic& t) { return t.name == name; });
  if (found == topics.end()) {
    topics.push_back({std::string(name), std::string(type), std::string(encoding), {channel}});
    return;
  }
  if (found->type != type || found->encoding != encoding) throw Damaged(fmt::format("topic {} has messages of two types", name));
  found->channels.insert(channel);
}

Topic* topic_of(std::vector<Topic>& topics, std::uint32_t channel) {
  const auto found = std::find_if(topics.begin(), topics.end(), [&](const Topic& t) { return t.channels.contains(channel); });
  return found != topics.end() ? &*found : nullptr;
}

const Topic& choose_topic(const std::vector<Topic>& topics, const std::string& name, const std::string& file) {
  const auto chosen = [&](const Topic& t) { return name.empty() ? t.readable() != nullptr && is_imu(t.type) : t.name == name; };
  const auto found = std::find_if(topics.begin(), topics.end(), chosen);
  if (found == topics.end())
    throw Error(name.empty() ? fmt::format("{}: has no topic of sensor_msgs/Imu; it has {}", file, topic_names(topics))
                             : fmt::format("{}: topic {} is not there; expected one of {}", file, name, topic_names(topics)));
  if (name.empty() && std::count_if(topics.begin(), topics.end(), chosen) > 1)
    throw Error(
        fmt::format("{}: has several topics of sensor_msgs/Imu and the session names none; expected topic = one of {}", file, topic_names(topics)));
  if (found->readable() == nullptr)
    throw Error(fmt::format("{}: topic {} has messages of {} in {}; expected sensor_msgs/Imu or sensor_msgs/Temperature in ros1 or cdr", file,
                            found->name, found->type.empty() ? "no type" : found->type, found->encoding));
  return *found;
}

std::vector<recording_io::TableDescription> describe_topics(const Bag& bag) {
  std::vector<recording_io::TableDescription> tables;
  for (const Topic& topic : bag.topics()) {
    const MessageType* type = topic.readable();
    tables.push_back({topic.name, topic.type, type != nullptr ? type->columns() : std::vector<recording_io::ColumnDescription>{},
                      static_cast<std::size_t>(topic.messages)});
  }
  return tables;
}

recording_io::RawTable topic_columns(Bag& bag, const TableRequest& request, const std::vector<Column>& columns) {
  const std::string file = request.file.string();
  const Topic& topic = choose_topic(bag.topics(), request.topic, file);
  const MessageType& type = *topic.readable();
  const recording_io::TableDescription table{topic.name, topic.type, type.columns(), 0};
  std::vector<std::size_t> indices;
  for (const Column& column : columns) indices.push_back(recording_io::find_column(table, column, file));

  MessageColumns read(topic.message_encoding(), type, indices, static_cast<std::size_t>(std::min(topic.messages, most_reserved)));
  const ReadingMeter meter(topic.messages);
  bag.each_message(topic, [&](std::int64_t log_time_ns, std::string_view message) {
    meter.add(1);
    try {
      read.add(log_time_ns, message);
    } catch (const Damaged& e) {
      throw Error(fmt::format("{}: {}: message {}: {}", file, topic.name, read.rows() + 1, e.what()));
    }
  });
  std::vector<std::string> warnings = bag.warnings();
  if (warnings.empty() && topic.messages > read.rows())
    warnings.push_back(fmt::format("{}: {}: {} messages were found and its index promises {}: the others are missing", file, topic.name, read.rows(),
                                   topic.messages));
  if (read.rows() == 0 && !warnings.empty()) throw Error(warnings.front() + "; expected messages");
  return {read.take(), "message", std::move(warnings)};
}

}  // namespace imulab::bag
