// Aids in ROS bags: sensor_msgs/NavSatFix (height above the ellipsoid), geometry_msgs/TwistStamped and TwistWithCovarianceStamped, and poses:
// geometry_msgs/PoseStamped, PoseWithCovarianceStamped, TransformStamped, tf2_msgs/TFMessage and nav_msgs/Odometry. A receiver's twist is in
// east-north-up axes (REP 103); that of wheels has the forward speed in x.
#include "imulab/error.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace imulab::aid_io {
namespace {

using bag::MessageType;

/// The numbers of a message of an aid, and what they are of it.
struct AidMessage {
  MessageType type;
  bool (*is_of)(AidKind kind);
  void (*put)(AidKind kind, const std::vector<double>& v, AidRow& row);
  bool is_list = false;  ///< of messages, each of a frame
};

void put_fix(AidKind, const std::vector<double>& v, AidRow& row) {
  row.position = {v[0] * unit::deg, v[1] * unit::deg, v[2]};
  row.position_sigma = {std::sqrt(v[3]), std::sqrt(v[7]), std::sqrt(v[11])};
}

void put_twist(AidKind kind, const std::vector<double>& v, AidRow& row) {
  if (kind == AidKind::wheels)
    row.value = v[0];
  else
    row.velocity = {v[0], v[1], v[2]};
}

void put_twist_with_covariance(AidKind kind, const std::vector<double>& v, AidRow& row) {
  put_twist(kind, v, row);
  constexpr std::size_t covariance = 6, size = 6;
  const auto sigma = [&](std::size_t i) { return std::sqrt(v[covariance + i * (size + 1)]); };
  if (kind == AidKind::wheels)
    row.value_sigma = sigma(0);
  else
    row.velocity_sigma = {sigma(0), sigma(1), sigma(2)};
}

/// Position, then quaternion x, y, z, w. Messages without a measurement of the attitude's or position's error state variances of 0 or less.
void put_pose(AidKind kind, const std::vector<double>& v, AidRow& row) {
  if (kind != AidKind::attitude) row.place = {v[0], v[1], v[2]};
  row.attitude = {v[3], v[4], v[5], v[6]};
}

void put_pose_with_covariance(AidKind kind, const std::vector<double>& v, AidRow& row) {
  put_pose(kind, v, row);
  constexpr std::size_t covariance = 7, size = 6;
  const auto variance = [&](std::size_t i) { return v[covariance + i * (size + 1)]; };
  const auto sigma = [&](std::size_t i) { return variance(i) > 0 ? std::sqrt(variance(i)) : AidRow::none; };
  if (kind != AidKind::attitude) row.position_sigma = {sigma(0), sigma(1), sigma(2)};
  row.value_sigma = std::sqrt((std::pow(sigma(3), 2) + std::pow(sigma(4), 2) + std::pow(sigma(5), 2)) / 3);
}

bool is_of_receiver(AidKind kind) { return kind == AidKind::gnss; }
bool is_of_velocity(AidKind kind) { return kind == AidKind::gnss || kind == AidKind::wheels; }

const std::vector<AidMessage>& aid_messages() {
  static const std::vector<AidMessage> messages{
      {{"sensor_msgs/NavSatFix", 12, {}, bag::Between::fix_status}, is_of_receiver, put_fix},
      {{"geometry_msgs/TwistStamped", 6, {}}, is_of_velocity, put_twist},
      {{"geometry_msgs/TwistWithCovarianceStamped", 42, {}}, is_of_velocity, put_twist_with_covariance},
      {{"geometry_msgs/PoseStamped", 7, {}}, has_attitude, put_pose},
      {{"geometry_msgs/TransformStamped", 7, {}, bag::Between::frame_name}, has_attitude, put_pose},
      {{"tf2_msgs/TFMessage", 7, {}, bag::Between::frame_name}, has_attitude, put_pose, true},
      {{"tf/tfMessage", 7, {}, bag::Between::frame_name}, has_attitude, put_pose, true},
      {{"geometry_msgs/PoseWithCovarianceStamped", 7 + 36, {}}, has_attitude, put_pose_with_covariance},
      {{"nav_msgs/Odometry", 7 + 36, {}, bag::Between::frame_name}, has_attitude, put_pose_with_covariance},
  };
  return messages;
}

const AidMessage* aid_message_of(const bag::Topic& topic, AidKind kind) {
  if (topic.name.ends_with("tf_static")) return nullptr;
  std::string name = topic.type;
  if (const auto msg = name.find("/msg/"); msg != std::string::npos) name.erase(msg, 4);
  if (topic.encoding != "ros1" && topic.encoding != "cdr") return nullptr;
  for (const AidMessage& message : aid_messages())
    if (message.type.name == name && message.is_of(kind)) return &message;
  return nullptr;
}

const bag::Topic& choose_aid_topic(const std::vector<bag::Topic>& topics, const AidRequest& request) {
  std::vector<const bag::Topic*> found;
  std::string names;
  for (const bag::Topic& topic : topics) {
    if (aid_message_of(topic, request.kind) == nullptr) continue;
    names += (names.empty() ? "" : ", ") + topic.name;
    if (request.topic.empty() || topic.name == request.topic.substr(0, request.topic.find(':'))) found.push_back(&topic);
  }
  if (found.size() == 1) return *found.front();
  if (!found.empty())
    throw Error(fmt::format("{}: has several topics of an aid; expected file = \"{}:TOPIC\" with one of {}", input_name(request.file),
                            request.file.filename().string(), names));
  std::vector<std::string_view> types;
  for (const AidMessage& message : aid_messages())
    if (message.is_of(request.kind)) types.push_back(message.type.name);
  throw Error(fmt::format("{}: has no {} of kind {}; expected {}{}", input_name(request.file),
                          request.topic.empty() ? "topic" : "topic " + request.topic, to_string(request.kind), text::listed(types),
                          names.empty() ? "" : ": " + names));
}

/// The rows of the frame that the request names after its topic, TOPIC:FRAME; without a name, of the only one.
std::vector<AidRow> rows_of_frame(std::map<std::string, std::vector<AidRow>> frames, const AidRequest& request, const bag::Topic& topic) {
  const std::size_t colon = request.topic.find(':');
  const auto found = colon != std::string::npos ? frames.find(request.topic.substr(colon + 1)) : frames.size() == 1 ? frames.begin() : frames.end();
  if (found != frames.end()) return std::move(found->second);
  if (frames.empty()) return {};
  std::vector<std::string_view> names;
  for (const auto& [name, rows] : frames) names.push_back(name);
  const std::string absent = colon == std::string::npos ? "" : fmt::format("no frame {}; ", excerpt(request.topic.substr(colon + 1)));
  throw Error(fmt::format("{}: {} has {}the transforms of {} frames; expected file = \"{}:{}:FRAME\" with one of {}", input_name(request.file),
                          topic.name, absent, frames.size(), request.file.filename().string(), topic.name, text::listed(names)));
}

AidRows read_bag_aid(const AidRequest& request) {
  AidRows out{.file = input_name(request.file), .row = "message", .scale = TimeScale::utc};
  const std::unique_ptr<bag::Bag> opened = bag::open_bag(request.file);
  const bag::Topic& topic = choose_aid_topic(opened->topics(), request);
  const AidMessage& message = *aid_message_of(topic, request.kind);
  if (!message.is_list && request.topic.find(':') != std::string::npos)
    throw Error(
        fmt::format("{}: {}: has no list of frames; expected file = \"{}:{}\"", out.file, topic.name, request.file.filename().string(), topic.name));
  std::size_t without_fix = 0, number = 0;
  std::vector<double> values(message.type.numbers);
  std::map<std::string, std::vector<AidRow>> frames;
  const bag::Encoding encoding = topic.message_encoding();
  opened->each_message(topic, [&](std::int64_t, std::string_view bytes) {
    ++number;
    try {
      for (const bag::MessagePlaces& places :
           message.is_list ? bag::places_of_list(encoding, message.type, bytes) : std::vector{bag::message_places(encoding, message.type, bytes)}) {
        if (message.type.between == bag::Between::fix_status && static_cast<signed char>(bytes[places.status]) < 0) return void(++without_fix);
        AidRow row;
        row.line = number, row.time = places.stamp_ns;
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = bag::load<double>(bytes.data() + places.of(i), places.big);
        message.put(request.kind, values, row);
        frames[message.is_list ? std::string(places.frame) : std::string()].push_back(row);
      }
    } catch (const bag::Damaged& e) {
      throw Error(fmt::format("{}: {}: message {}: {}", out.file, topic.name, number, e.what()));
    }
  });
  if (message.is_list)
    out.rows = rows_of_frame(std::move(frames), request, topic);
  else if (!frames.empty())
    out.rows = std::move(frames.begin()->second);
  out.warnings = opened->warnings();
  if (without_fix > 0) out.warnings.push_back(fmt::format("{}: {}: {} messages without a fix are left out", out.file, topic.name, without_fix));
  return out;
}

}  // namespace

AidFormat bag_aid_format() {
  return {"a ROS bag",
          [](std::string_view head) {
            const std::vector<RecordingFormat>& all = recording_formats();
            return std::any_of(all.begin(), all.end(), [&](const RecordingFormat& f) { return f.bag != nullptr && f.recognizes(head); });
          },
          read_bag_aid, true, [](const std::filesystem::path& path) { return bag::bag_format(path) != nullptr; }};
}

}  // namespace imulab::aid_io
