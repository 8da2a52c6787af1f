#include "imulab/formats/recording/bag/topics.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/bag/byte_file.hpp"
#include "imulab/formats/text/reading_meter.hpp"
#include "imulab/formats/text/several_files.hpp"

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

const RecordingFormat* bag_format(const std::filesystem::path& path) {
  Buffer buffer;
  const bool several = is_several_files(path);
  const std::string_view head = several ? std::string_view() : ByteFile(path).read_some(0, 16, buffer);
  const std::vector<RecordingFormat>& formats = recording_formats();
  const auto found = std::find_if(formats.begin(), formats.end(), [&](const RecordingFormat& f) {
    return f.bag != nullptr && (several ? f.recognizes_path != nullptr && f.recognizes_path(path) : f.recognizes(head));
  });
  return found != formats.end() ? &*found : nullptr;
}

namespace {

const BagFormat& expected_bag(const std::filesystem::path& path) {
  const RecordingFormat* format = bag_format(path);
  if (format == nullptr) throw Error(path.string() + ": is no bag; expected a bag of ROS 1 or ROS 2");
  return *format->bag;
}

}  // namespace

std::unique_ptr<Bag> open_bag(const std::filesystem::path& path) { return expected_bag(path).open(path); }

void rewrite_bag(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out) {
  if (out.temporary().empty()) throw Error("a bag is written to a file on disk; expected one, no device and no pipe");
  expected_bag(in).rewrite(in, topic, change, out);
}

namespace {

std::vector<recording_io::TableDescription> describe_bag(const TableRequest& request) {
  const std::unique_ptr<Bag> bag = open_bag(request.file);
  bag->count_messages();
  std::vector<recording_io::TableDescription> tables;
  for (const Topic& topic : bag->topics()) {
    const MessageType* type = topic.readable();
    tables.push_back({topic.name, topic.type, type != nullptr ? type->columns() : std::vector<recording_io::ColumnDescription>{},
                      static_cast<std::size_t>(topic.messages)});
  }
  return tables;
}

void read_bag(const TableRequest& request, const recording_io::Wanted& wanted, const recording_io::PieceSink& sink) {
  constexpr std::uint64_t most_reserved = 1 << 22;  // rows, of a count that the file says: more only as they come
  const std::string file = request.file.string();
  const std::unique_ptr<Bag> bag = open_bag(request.file);
  const Topic& topic = choose_topic(bag->topics(), request.topic, file);
  const MessageType& type = *topic.readable();
  const recording_io::TableDescription table{topic.name, topic.type, type.columns(), 0};
  std::vector<std::size_t> indices;
  for (const Column& column : wanted.columns) indices.push_back(recording_io::find_column(table, column, file));

  MessageColumns read(topic.message_encoding(), type, indices, static_cast<std::size_t>(std::min(topic.messages, most_reserved)));
  const ReadingMeter meter(topic.messages);
  bag->each_message(topic, [&](std::int64_t log_time_ns, std::string_view message) {
    meter.add(1);
    try {
      read.add(log_time_ns, message);
    } catch (const Damaged& e) {
      throw Error(fmt::format("{}: {}: message {}: {}", file, topic.name, read.rows() + 1, e.what()));
    }
  });
  std::vector<std::string> warnings = bag->warnings();
  if (warnings.empty() && topic.messages > read.rows())
    warnings.push_back(fmt::format("{}: {}: {} messages were found and its index promises {}: the others are missing", file, topic.name, read.rows(),
                                   topic.messages));
  if (read.rows() == 0 && !warnings.empty()) throw Error(warnings.front() + "; expected messages");
  sink({read.take(), "message", std::move(warnings)});
}

}  // namespace

RecordingFormat bag_row(std::string_view name, bool (*recognizes)(std::string_view head), const BagFormat& format) {
  return {.name = name, .recognizes = recognizes, .describe = describe_bag, .read = read_bag, .bag = &format};
}

}  // namespace imulab::bag
