// A store of one's own, an SQLite file or a PostgreSQL database (engine.hpp): statements, values, transactions. Every failure is a DatabaseError with
// the store's name.
#pragma once

#include "imulab/fleet.hpp"
#include "imulab/fleet/store/engine.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace imulab::fleet {

class Database {
 public:
  /// A file, or the address of a server (server.hpp). A file in a folder that cannot be written is read as it is: nobody may write it meanwhile.
  /// Throws DatabaseError where it cannot be opened or is no database, where its last changes cannot be read, and in a build without SQLite or on a
  /// machine without libpq.
  Database(const std::filesystem::path& store, Access access);

  void run(const std::string& statements) { engine_->run(statements); }
  std::int64_t number(const std::string& query);  ///< the first value of the first row; 0 where there is none
  std::int64_t changes() const { return engine_->changes(); }
  const std::string& file() const { return file_; }  ///< the store's name, without a password
  Engine& engine() { return *engine_; }

 private:
  std::string file_;
  std::unique_ptr<Engine> engine_;
};

/// A statement, row by row. Texts and blobs that are bound are copied.
class Statement {
 public:
  Statement(Database& database, const std::string& text) : query_(database.engine().query(text)) {}

  bool next() { return query_->next(); }  ///< whether there is a row
  void run();                             ///< to its end; then it can be bound and run again
  std::int64_t run_for_id();              ///< the same of INSERT ... RETURNING id: the new row's number
  void reset() { query_->reset(); }       ///< to be bound and run again
  template <class... Values>
  Statement& with(const Values&... values) {
    reset();
    int parameter = 0;
    (query_->bind(++parameter, as_value(values)), ...);
    return *this;
  }

  std::int64_t integer(int column) const;
  double real(int column) const;
  bool is_null(int column) const { return query_->value(column).index() == 0; }
  std::string_view bytes(int column) const;  ///< until the next row
  std::string text(int column) const { return std::string(bytes(column)); }
  Query& query() { return *query_; }

 private:
  static Value as_value(std::int64_t value) { return value; }
  static Value as_value(double value) { return value; }
  static Value as_value(std::string_view text) { return text; }
  static Value as_value(const std::string& text) { return std::string_view(text); }
  static Value as_value(const char* text) { return std::string_view(text); }
  static Value as_value(const Blob& blob) { return blob; }
  template <class T>
  static Value as_value(const std::optional<T>& value) {
    return value ? as_value(*value) : Value{};
  }

  std::unique_ptr<Query> query_;
};

/// From here to commit() all or nothing. No other process writes meanwhile; the transaction waits for one that does.
class Transaction {
 public:
  explicit Transaction(Database& database) : engine_(database.engine()) { engine_.begin(Access::write); }
  ~Transaction() {
    if (open_) engine_.rollback();
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit() {
    engine_.commit();
    open_ = false;
  }

 private:
  Engine& engine_;
  bool open_ = true;
};

/// While it exists, all that is read is of one state of the store, whatever others write.
class Snapshot {
 public:
  explicit Snapshot(Database& database) : engine_(database.engine()) { engine_.begin(Access::read); }
  ~Snapshot() { engine_.rollback(); }
  Snapshot(const Snapshot&) = delete;
  Snapshot& operator=(const Snapshot&) = delete;

 private:
  Engine& engine_;
};

/// The tables of a fleet store.
inline constexpr std::array store_tables{"units", "sessions", "files", "calibrations", "layouts", "numbers", "texts", "noises", "failures"};

/// Makes the tables in a new store. Throws Error where it is something else, newer, or without its tables.
void expect_schema(Database& database, Access access);

}  // namespace imulab::fleet
