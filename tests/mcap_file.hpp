// For tests: bags of ROS 2 made of rows, in MCAP without chunks.
#pragma once

#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/recording/bag/mcap.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {

/// A message of sensor_msgs/msg/Imu: its stamp, gyros, accelerometers.
struct ImuMessage {
  std::int64_t stamp_ns = 0;
  std::array<double, 6> readings{};
};

inline void append_counted(std::string& out, std::string_view text) {
  bag::append<std::uint32_t>(out, static_cast<std::uint32_t>(text.size()));
  out += text;
}

inline void append_mcap_record(std::string& out, int op, const std::string& content) {
  out += static_cast<char>(op);
  bag::append<std::uint64_t>(out, content.size());
  out += content;
}

inline std::string mcap_file(const std::vector<std::pair<std::string, std::vector<ImuMessage>>>& topics) {
  using bag::append;
  std::string file(bag::mcap_magic), schema;
  append_mcap_record(file, 1, std::string(8, '\0'));
  append<std::uint16_t>(schema, 1);
  for (const char* text : {"sensor_msgs/msg/Imu", "ros2msg", ""}) append_counted(schema, text);
  append_mcap_record(file, 3, schema);
  for (std::size_t t = 0; t < topics.size(); ++t) {
    std::string channel;
    append<std::uint16_t>(channel, static_cast<std::uint16_t>(t + 1));
    append<std::uint16_t>(channel, 1);
    for (const std::string& text : {topics[t].first, std::string("cdr"), std::string()}) append_counted(channel, text);
    append_mcap_record(file, 4, channel);
    for (const ImuMessage& m : topics[t].second) {
      std::string message;
      append<std::uint16_t>(message, static_cast<std::uint16_t>(t + 1));
      append<std::uint32_t>(message, 0);
      for (int k = 0; k < 2; ++k) append<std::int64_t>(message, m.stamp_ns);
      message.append("\0\1\0\0", 4);
      append<std::int32_t>(message, static_cast<std::int32_t>(m.stamp_ns / 1'000'000'000));
      append<std::uint32_t>(message, static_cast<std::uint32_t>(m.stamp_ns % 1'000'000'000));
      append_counted(message, std::string_view("imu\0", 4));
      for (std::size_t k = 0; k < 37; ++k)
        append<double>(message, k >= 13 && k < 16 ? m.readings[k - 13] : k >= 25 && k < 28 ? m.readings[k - 22] : 0);
      append_mcap_record(file, 5, message);
    }
  }
  append_mcap_record(file, 15, std::string(4, '\0'));
  append_mcap_record(file, 2, std::string(20, '\0'));
  return file += bag::mcap_magic;
}

}  // namespace imulab
