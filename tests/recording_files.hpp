// For tests of recording formats: the files of tests/recordings/, which other software wrote, and the samples in them (tests/recordings/imu.py).
#pragma once

#include "imulab/error.hpp"
#include "imulab/formats/recording/table_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.hpp"
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace imulab {

inline std::filesystem::path recording_file(const std::string& name) { return std::filesystem::path(IMULAB_SOURCE "/tests/recordings") / name; }

inline std::string file_bytes(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// An array's file of NumPy: its head, a Python dictionary, and its data.
inline std::string npy_file(const std::string& head, const std::string& data) {
  std::string bytes("\x93NUMPY\1\0", 8);
  bytes += static_cast<char>(head.size() & 255);
  bytes += static_cast<char>(head.size() >> 8);
  return bytes + head + data;
}

/// Numbers of a column of either kind.
inline std::vector<double> numbers_of(const recording_io::RawColumn& column) {
  if (column.integers.empty()) return column.numbers;
  return {column.integers.begin(), column.integers.end()};
}

inline recording_io::TableRows columns_of(const TableRequest& request, const std::vector<Column>& columns) {
  return recording_io::read_columns(request, columns);
}

/// The samples of all files, exact in single precision.
inline constexpr std::size_t fixture_samples = 40;
inline double fixture_t(std::size_t i) { return 8.0 * static_cast<double>(i + 1) / 1000; }
inline std::int64_t fixture_ns(std::size_t i) { return 1'700'000'000'000'000'000 + 8'000'000 * static_cast<std::int64_t>(i + 1); }
inline double fixture_gyro(std::size_t i, std::size_t k) { return static_cast<double>(64 * (k + 1) + i) / 1024; }
inline double fixture_accel(std::size_t i, std::size_t k) {
  return (k == 2 ? 9.75 : 0) + (static_cast<double>(i) - 8 * static_cast<double>(k)) / 256;
}
inline double fixture_counts(std::size_t i, std::size_t k) { return 1000.0 * static_cast<double>(k + 1) - 7 * static_cast<double>(i); }

/// Expects `columns` of a file to be these values: value(row, which of the columns).
template <class Value>
void expect_columns(const TableRequest& request, const std::vector<Column>& columns, Value value, std::size_t rows = fixture_samples) {
  const recording_io::TableRows table = columns_of(request, columns);
  ASSERT_EQ(table.columns.size(), columns.size()) << request.file;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::vector<double> numbers = numbers_of(table.columns[c]);
    ASSERT_EQ(numbers.size(), rows) << request.file << " column " << c;
    for (std::size_t i = 0; i < rows; ++i) ASSERT_EQ(numbers[i], value(i, c)) << request.file << " column " << c << " row " << i;
  }
}

/// The message about a request that cannot be read.
inline std::string error_of(const TableRequest& request, const std::vector<Column>& columns) {
  try {
    columns_of(request, columns);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

inline bool built_without(const TableRequest& request) { return error_of(request, {1}).find("built without") != std::string::npos; }

/// Reads `bytes` as a file in every way: an Error or numbers, nothing else.
inline void expect_no_crash(const std::filesystem::path& file, const std::string& bytes, const TableRequest& like,
                            const std::vector<Column>& columns) {
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  TableRequest request = like;
  request.file = file;
  try {
    const RecordingFormat& format = format_of(request);
    format.describe(request);
    const recording_io::TableRows table = recording_io::read_columns(request, columns, format);
    for (const auto& column : table.columns) EXPECT_EQ(column.size(), table.columns.front().size());
  } catch (const Error&) {
  }
}

/// The file cut after every `step` bytes, and with every `step`th byte replaced.
inline void expect_damage_is_survived(const TableRequest& request, const std::vector<Column>& columns, std::size_t step) {
  const TemporaryFolder folder;
  const std::string bytes = file_bytes(request.file);
  ASSERT_FALSE(bytes.empty()) << request.file;
  for (std::size_t end = 0; end < bytes.size(); end += step) expect_no_crash(folder / "damaged", bytes.substr(0, end), request, columns);
  for (std::size_t at = 0; at < bytes.size(); at += step)
    for (const char damage : {'\xFF', '\x7F', '\0'}) {
      std::string damaged = bytes;
      damaged[at] = damage;
      expect_no_crash(folder / "damaged", damaged, request, columns);
    }
}

/// Names of the columns of a table, with units.
inline std::vector<std::string> column_texts(const recording_io::TableDescription& table) {
  std::vector<std::string> texts;
  for (const auto& column : table.columns) texts.push_back(column.name + (column.unit.empty() ? "" : " [" + column.unit + "]"));
  return texts;
}

}  // namespace imulab
