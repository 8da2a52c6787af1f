// For tests: what the bags in tests/recordings hold (bag_data.py there), which other programs wrote.
#pragma once

#include "imulab/formats/recording/table_reader.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace imulab::bag {

constexpr std::size_t fixture_samples = 60;
constexpr std::int64_t fixture_first_ns = 1'700'000'000'123'456'789, fixture_interval_ns = 5'000'000;

inline std::int64_t fixture_stamp(std::size_t i) { return fixture_first_ns + static_cast<std::int64_t>(i) * fixture_interval_ns; }
inline std::array<double, 6> fixture_readings(std::size_t sample) {
  const auto i = static_cast<double>(sample);
  return {(i - 30) / 1024, std::fmod(7 * i, 16) / 512, -i / 256, i / 64, -std::fmod(i, 5) / 32, 9.8125};
}

inline std::filesystem::path fixture(const std::string& name) { return std::filesystem::path(IMULAB_SOURCE) / "tests" / "recordings" / name; }
inline const std::vector<std::string>& fixture_names() {
  static const std::vector<std::string> names{"imu_none.bag",       "imu_bz2.bag",
                                              "imu_lz4.bag",        "imu_none.mcap",
                                              "imu_lz4.mcap",       "imu_zstd.mcap",
                                              "imu_no_chunks.mcap", "imu_big_endian.mcap",
                                              "imu_ros1.mcap",      "imu_no_message_index.mcap",
                                              "imu_bare.mcap",      "imu.db3"};
  return names;
}

/// Four samples and a large picture in one chunk that is not compressed: their messages are read one by one.
constexpr std::size_t sparse_samples = 4;
inline const std::vector<std::string>& sparse_names() {
  static const std::vector<std::string> names{"sparse.bag", "sparse.mcap"};
  return names;
}

inline const std::vector<Column>& imu_columns() {
  static const std::vector<Column> columns{"header.stamp",         "log_time",           "orientation.w",         "angular_velocity.x",
                                           "angular_velocity.y",   "angular_velocity.z", "linear_acceleration.x", "linear_acceleration.y",
                                           "linear_acceleration.z"};
  return columns;
}

/// Columns of a topic, in whatever format the file is.
inline recording_io::TableRows read_columns(const std::filesystem::path& file, const std::string& topic, const std::vector<Column>& columns) {
  return recording_io::read_columns({file, topic, ""}, columns);
}

}  // namespace imulab::bag
