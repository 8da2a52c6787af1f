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
  if (type.between == Between::fix_status) numbers += aligned ? 3 + (numbers - origin + 1) % 2 : 3;  // int8, then uint16 on an even place
  if (type.between == Between::frame_name) {
    if (aligned) numbers = origin + (numbers - origin + 3) / 4 * 4;
    after(numbers, 4);
    numbers = after(numbers + 4, load<std::uint32_t>(message.data() + numbers, big));
  }
  if (aligned) numbers = origin + (numbers - origin + 7) / 8 * 8;
  after(numbers, sizeof(double) * type.numbers);
  return {seconds * 1'000'000'000 + nanoseconds, numbers, status, big};
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
  if (message.size() < 4) too_short(type);
  // The encapsulation: 0, then 0 for the most significant byte first or 1 for the least, then options.
  if (message[0] != 0 || (message[1] != 0 && message[1] != 1)) throw Damaged("it is in an unknown encoding of CDR; expected CDR_BE or CDR_LE");
  return places_after(4, 4, true, message[1] == 0, type, message);
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
