#include "imulab/formats/recording/bag/ros_message.hpp"

#include "imulab/formats/recording/bag/bytes.hpp"

#include <algorithm>
#include <utility>

namespace imulab::bag {
namespace {

constexpr std::size_t stamp_column = 0, log_time_column = 1, first_field = 2;
constexpr std::size_t angular_velocity = 4 + 9,
                      linear_acceleration = angular_velocity + 3 + 9;  // after the orientation and its covariance, and so on

const std::vector<MessageType>& message_types() {
  static const std::vector<MessageType> types{
      {"sensor_msgs/Imu",
       linear_acceleration + 3 + 9,
       {{"orientation.x", "", 0},
        {"orientation.y", "", 1},
        {"orientation.z", "", 2},
        {"orientation.w", "", 3},
        {"angular_velocity.x", "rad/s", angular_velocity},
        {"angular_velocity.y", "rad/s", angular_velocity + 1},
        {"angular_velocity.z", "rad/s", angular_velocity + 2},
        {"linear_acceleration.x", "m/s^2", linear_acceleration},
        {"linear_acceleration.y", "m/s^2", linear_acceleration + 1},
        {"linear_acceleration.z", "m/s^2", linear_acceleration + 2}}},
      {"sensor_msgs/Temperature", 2, {{"temperature", "degC", 0}}},  // then its variance
  };
  return types;
}

[[noreturn]] void too_short(const MessageType& type) { throw Damaged("it is too short for " + std::string(type.name)); }

/// sec and nsec, the count of the frame's name at `at`, then the name, then the numbers aligned to eight bytes of what follows `origin`.
MessagePlaces places_after(std::size_t origin, std::size_t at, bool aligned, bool big, const MessageType& type, std::string_view message) {
  const auto after = [&](std::size_t from, std::size_t count) {
    if (from > message.size() || count > message.size() - from) too_short(type);
    return from + count;
  };
  after(at, 12);
  const auto nanoseconds = load<std::uint32_t>(message.data() + at + 4, big), name = load<std::uint32_t>(message.data() + at + 8, big);
  const std::int64_t seconds = aligned ? std::int64_t{load<std::int32_t>(message.data() + at, big)}  // of ROS 2; ROS 1 has no sign
                                       : std::int64_t{load<std::uint32_t>(message.data() + at, big)};
  const std::size_t status = after(at + 12, name);
  std::size_t numbers = status;
  std::string_view frame;
  if (type.between == Between::fix_status) numbers += aligned ? 3 + (numbers - origin + 1) % 2 : 3;  // int8, then uint16 on an even place
  if (type.between == Between::frame_name) {
    if (aligned) numbers = origin + (numbers - origin + 3) / 4 * 4;
    after(numbers, 4);
    const auto length = load<std::uint32_t>(message.data() + numbers, big);
    frame = message.substr(numbers + 4, length);
    numbers = after(numbers + 4, length);
    frame = frame.substr(0, frame.find('\0'));  // ROS 2 counts it, too
  }
  if (aligned) numbers = origin + (numbers - origin + 7) / 8 * 8;
  after(numbers, sizeof(double) * type.numbers);
  return {seconds * 1'000'000'000 + nanoseconds, numbers, status, big, frame};
}

/// Whether numbers begin with the most significant byte. The encapsulation: 0, then 0 for that or 1 for the least, then options.
bool is_big(const MessageType& type, std::string_view message) {
  if (message.size() < 4) too_short(type);
  if (message[0] != 0 || (message[1] != 0 && message[1] != 1)) throw Damaged("it is in an unknown encoding of CDR; expected CDR_BE or CDR_LE");
  return message[1] == 0;
}

}  // namespace

std::vector<recording_io::ColumnDescription> MessageType::columns() const {
  std::vector<recording_io::ColumnDescription> columns{{"header.stamp", "ns"}, {"log_time", "ns"}};
  for (const Field& field : fields) columns.push_back({std::string(field.name), std::string(field.unit)});
  return columns;
}

const MessageType* message_type(std::string_view name) {
  std::string ros1(name);
  if (const auto msg = ros1.find("/msg/"); msg != std::string::npos) ros1.erase(msg, 4);
  const auto found = std::find_if(message_types().begin(), message_types().end(), [&](const MessageType& t) { return t.name == ros1; });
  return found != message_types().end() ? &*found : nullptr;
}

bool is_imu(std::string_view name) {
  const MessageType* type = message_type(name);
  return type != nullptr && type->name == "sensor_msgs/Imu";
}

MessagePlaces message_places(Encoding encoding, const MessageType& type, std::string_view message) {
  if (encoding == Encoding::ros1) return places_after(0, 4, false, false, type, message);  // after the sequence number
  return places_after(4, 4, true, is_big(type, message), type, message);
}

std::vector<MessagePlaces> places_of_list(Encoding encoding, const MessageType& type, std::string_view message) {
  const bool aligned = encoding == Encoding::cdr, big = aligned && is_big(type, message);
  const std::size_t origin = aligned ? 4 : 0, sequence = aligned ? 0 : 4;  // ROS 1 has a number before the stamp
  std::size_t at = origin + 4;
  if (at > message.size()) too_short(type);
  std::vector<MessagePlaces> out;
  for (auto left = load<std::uint32_t>(message.data() + origin, big); left > 0; --left) {
    if (sequence > message.size() - at) too_short(type);
    out.push_back(places_after(origin, at + sequence, aligned, big, type, message));
    at = out.back().of(type.numbers);  // a multiple of eight after the origin
  }
  return out;
}

MessageColumns::MessageColumns(Encoding encoding, const MessageType& type, std::vector<std::size_t> columns, std::size_t expected)
    : encoding_(encoding), type_(type), columns_(std::move(columns)), raw_(columns_.size()) {
  for (std::size_t k = 0; k < columns_.size(); ++k)
    columns_[k] < first_field ? raw_[k].integers.reserve(expected) : raw_[k].numbers.reserve(expected);
}

void MessageColumns::add(std::int64_t log_time_ns, std::string_view message) {
  const MessagePlaces places = message_places(encoding_, type_, message);
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const std::size_t column = columns_[k];
    if (column == stamp_column)
      raw_[k].integers.push_back(places.stamp_ns);
    else if (column == log_time_column)
      raw_[k].integers.push_back(log_time_ns);
    else
      raw_[k].numbers.push_back(load<double>(message.data() + places.of(type_.fields[column - first_field].index), places.big));
  }
  ++rows_;
}

void put_readings(Encoding encoding, std::span<char> message, std::span<const double, 6> gyro_and_accel) {
  const MessagePlaces places = message_places(encoding, message_types().front(), {message.data(), message.size()});
  for (std::size_t k = 0; k < 6; ++k)
    store<double>(message.data() + places.of(k < 3 ? angular_velocity + k : linear_acceleration + k - 3), gyro_and_accel[k], places.big);
}

}  // namespace imulab::bag
