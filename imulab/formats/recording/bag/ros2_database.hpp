// ROS 2 bags in SQLite (.db3), as rosbag2 writes them: the tables topics(id, name, type, serialization_format) and
// messages(id, topic_id, timestamp, data).
#pragma once

#include "imulab/formats/recording/bag/topics.hpp"
#include "imulab/formats/text/file.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

namespace imulab::bag {

/// A database that is open; every failure is an Error with the file.
class Database {
 public:
  explicit Database(const std::filesystem::path& path) : Database(path, path, false) {}
  /// To be written; `name` stands for the file in messages.
  Database(const std::filesystem::path& path, const std::filesystem::path& name) : Database(path, name, true) {}
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  sqlite3* handle() const { return handle_; }
  void run(const char* statement);
  [[noreturn]] void fail() const;

 private:
  Database(const std::filesystem::path& path, const std::filesystem::path& name, bool write);

  std::string file_;
  bool write_;
  sqlite3* handle_ = nullptr;
};

/// A query, row by row.
class Query {
 public:
  Query(Database& database, const char* text);
  ~Query();
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  bool next();
  std::int64_t integer(int column) const;
  std::string_view bytes(int column) const;  ///< valid until the next row

 private:
  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
};

class Ros2Database : public Bag {
 public:
  explicit Ros2Database(const std::filesystem::path& path);

  void each_message(const Topic& topic, const MessageSink& sink) override;
  void count_messages() override;  ///< looks at every row
  /// The messages with the numbers of their rows.
  void each_row(const Topic& topic, const std::function<void(std::int64_t id, std::int64_t log_time_ns, std::string_view message)>& sink);
  Database& database() { return database_; }

 private:
  void expect_all_pages(const std::filesystem::path& path);

  Database database_;
  std::string file_;
};

/// Throws Error in a build without SQLite.
std::unique_ptr<Bag> open_ros2_database(const std::filesystem::path& path);

void rewrite_ros2_database(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out);

}  // namespace imulab::bag
