// A SQLite file of one's own: statements, values, transactions. Every failure is a DatabaseError with the file.
#pragma once

#include "imulab/error.hpp"
#include "imulab/fleet.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace imulab::fleet {

/// The store itself is at fault: its disk, its file, another program that writes.
class DatabaseError : public Error {
 public:
  using Error::Error;
};

class Database {
 public:
  /// A file in a folder that cannot be written is read as it is: nobody may write it meanwhile. Throws DatabaseError where the file cannot be opened
  /// or is no database, where its last changes cannot be read, and in a build without SQLite.
  Database(const std::filesystem::path& path, Access access);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  void run(const std::string& statements);
  std::int64_t number(const std::string& query);  ///< the first value of the first row; 0 where there is none
  std::int64_t last_id() const;
  std::int64_t changes() const;  ///< rows that the last statement changed
  const std::string& file() const { return file_; }
  const std::string& uri() const { return uri_; }  ///< as it is opened, for another database that attaches it
  sqlite3* handle() const { return handle_; }
  [[noreturn]] void fail() const;

 private:
  std::string file_, uri_;
  sqlite3* handle_ = nullptr;
};

/// Bytes that are no text.
struct Blob {
  std::string_view bytes;
};

/// A statement, row by row. Texts and blobs that are bound are copied.
class Statement {
 public:
  Statement(Database& database, const std::string& text);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  bool next();   ///< whether there is a row
  void run();    ///< to its end; then it can be bound and run again
  void reset();  ///< to be bound and run again
  template <class... Values>
  Statement& with(const Values&... values) {
    reset();
    int parameter = 0;
    (bind(++parameter, values), ...);
    return *this;
  }

  std::int64_t integer(int column) const;
  double real(int column) const;
  bool is_null(int column) const;
  std::string_view bytes(int column) const;  ///< until the next row
  std::string text(int column) const { return std::string(bytes(column)); }

 private:
  void bind(int parameter, std::int64_t value);
  void bind(int parameter, double value);
  void bind(int parameter, std::string_view text);
  void bind(int parameter, const std::string& text) { bind(parameter, std::string_view(text)); }
  void bind(int parameter, const Blob& blob);
  void bind(int parameter, const char* text) { bind(parameter, std::string_view(text)); }
  struct Nothing {};
  void bind(int parameter, Nothing nothing);
  template <class Value>
  void bind(int parameter, const std::optional<Value>& value) {
    if (value)
      bind(parameter, *value);
    else
      bind(parameter, Nothing{});
  }

  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
};

/// From here to commit() all or nothing. No other process writes meanwhile; the transaction waits for one that does.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Database& database_;
  bool open_ = true;
};

/// While it exists, all that is read is of one state of the store, whatever others write.
class Snapshot {
 public:
  explicit Snapshot(Database& database);
  ~Snapshot();
  Snapshot(const Snapshot&) = delete;
  Snapshot& operator=(const Snapshot&) = delete;

 private:
  Database& database_;
};

// The tables of a fleet store.

/// Makes the tables in a new file. Throws Error where the file is something else, newer, or without its tables.
void expect_schema(Database& database, Access access);

}  // namespace imulab::fleet
