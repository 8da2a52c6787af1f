// Messages of ROS that are read: where their numbers are. Layouts: sensor_msgs of common_interfaces; ROS 1 serialization; CDR of DDS (OMG DDSI-RTPS
// 10).
#pragma once

#include "imulab/formats/recording/table.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::bag {

enum class Encoding { ros1, cdr };

/// What a message has between its header and its numbers: a sensor_msgs/NavSatStatus, or the name of a frame.
enum class Between { nothing, fix_status, frame_name };

/// A message of a header, then numbers of eight bytes.
struct MessageType {
  std::string_view name;  ///< as ROS 1 says it: "sensor_msgs/Imu"
  std::size_t numbers;    ///< after the header
  struct Field {
    std::string_view name, unit;
    std::size_t index;  ///< of the number
  };
  std::vector<Field> fields;
  Between between = Between::nothing;

  std::vector<recording_io::ColumnDescription> columns() const;
};

/// The type of that name, of ROS 1 ("sensor_msgs/Imu") or ROS 2 ("sensor_msgs/msg/Imu"); null where it is not read.
const MessageType* message_type(std::string_view name);
/// "sensor_msgs/Imu": also of a name of ROS 2.
bool is_imu(std::string_view name);

/// Where things are in a message.
struct MessagePlaces {
  std::int64_t stamp_ns = 0;  ///< of the header
  std::size_t numbers = 0;    ///< the first one's byte
  std::size_t status = 0;     ///< the byte behind the header
  bool big = false;           ///< numbers begin with the most significant byte
  std::string_view frame{};   ///< of Between::frame_name: the frame of what moves, in the message

  std::size_t of(std::size_t index) const { return numbers + sizeof(double) * index; }
};

/// Throws Damaged where the message is too short for its type, or in an encoding of CDR that is not read.
MessagePlaces message_places(Encoding encoding, const MessageType& type, std::string_view message);

/// Those of each message in a list of them, which is all that a message of `type` has: the transforms of a tf2_msgs/TFMessage.
std::vector<MessagePlaces> places_of_list(Encoding encoding, const MessageType& type, std::string_view message);

/// Columns of messages that come one after the other.
class MessageColumns {
 public:
  /// `columns`: indices into type.columns(). `expected` rows, to reserve.
  MessageColumns(Encoding encoding, const MessageType& type, std::vector<std::size_t> columns, std::size_t expected);
  void add(std::int64_t log_time_ns, std::string_view message);
  std::vector<recording_io::RawColumn> take() { return std::move(raw_); }
  std::size_t rows() const { return rows_; }

 private:
  Encoding encoding_;
  const MessageType& type_;
  std::vector<std::size_t> columns_;
  std::vector<recording_io::RawColumn> raw_;
  std::size_t rows_ = 0;
};

/// The six readings of a sensor_msgs/Imu, put in place of those of the message: rad/s and m/s^2.
void put_readings(Encoding encoding, std::span<char> message, std::span<const double, 6> gyro_and_accel);

}  // namespace imulab::bag
