// A kind of database behind Database and Statement (database.hpp): SQLite in one file (sqlite.cpp), or a PostgreSQL server (postgres.cpp).
//
// The store writes its SQL once, in what both understand: the schema's types and parameters as SQLite has them ("INTEGER", "?"), which
// postgres_text.hpp translates; "main.", "other." and "temp." in front of tables; ON CONFLICT, RETURNING and NOT EXISTS.
#pragma once

#include "imulab/error.hpp"
#include "imulab/fleet.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace imulab::fleet {

/// The store itself is at fault: its disk, its file, its server, another program that writes.
class DatabaseError : public Error {
 public:
  using Error::Error;
};

/// Bytes that are no text.
struct Blob {
  std::string_view bytes;
};

/// What a row has in a column, or a statement as a parameter; the first is NULL. Texts and bytes in a row are there until the next one.
using Value = std::variant<std::monostate, std::int64_t, double, std::string_view, Blob>;

/// One statement with parameters.
class Query {
 public:
  Query() = default;
  virtual ~Query() = default;
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  virtual bool next() = 0;   ///< whether there is a row
  virtual void reset() = 0;  ///< to be bound and run again
  virtual void bind(int parameter, const Value& value) = 0;
  virtual int columns() const = 0;
  virtual Value value(int column) const = 0;
};

class Engine {
 public:
  Engine() = default;
  virtual ~Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  virtual void run(const std::string& statements) = 0;
  virtual std::unique_ptr<Query> query(const std::string& text) = 0;
  virtual std::int64_t changes() const = 0;  ///< rows that the last statement changed

  virtual void begin(Access access) = 0;  ///< write: alone, after waiting for another writer; read: of one state
  virtual void commit() = 0;
  virtual void rollback() noexcept = 0;

  virtual bool is_new() = 0;                        ///< has no table of anybody
  virtual std::vector<std::string> names() = 0;     ///< of its tables
  virtual std::int64_t version() = 0;               ///< of the store. Throws Error where this is something else
  virtual void mark(std::int64_t version) = 0;      ///< as a store of this version
  virtual std::vector<std::string> damages() = 0;   ///< by the engine's own check
  virtual std::string uri() const { return ""; }    ///< by which an SQLite file attaches this one; empty: it cannot
  virtual bool attach(const std::string& uri) = 0;  ///< makes room for tables "other."; true: they are those of `uri`
  virtual void detach() noexcept = 0;
  virtual void fill(const std::string& table, Query& rows) = 0;  ///< adds all rows to a table with the same columns
};

/// Each throws DatabaseError where the store cannot be opened, or this program or machine has not what it takes. `address` may have a password.
std::unique_ptr<Engine> open_sqlite(const std::filesystem::path& file, Access access);
std::unique_ptr<Engine> open_postgres(const std::string& address, Access access);

}  // namespace imulab::fleet
