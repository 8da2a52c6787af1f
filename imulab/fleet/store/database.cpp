#include "imulab/fleet/store/database.hpp"

#include "imulab/error.hpp"
#include "imulab/fleet/store/server.hpp"
#include "imulab/fleet/store/store.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace imulab::fleet {

Database::Database(const std::filesystem::path& store, Access access)
    : file_(shown_store(store)), engine_(is_server(store) ? open_postgres(store.string(), access) : open_sqlite(store, access)) {}

std::int64_t Database::number(const std::string& query) {
  Statement statement(*this, query);
  return statement.next() ? statement.integer(0) : 0;
}

void Statement::run() {
  while (next()) {
  }
  reset();
}

std::int64_t Statement::run_for_id() {
  const std::int64_t id = next() ? integer(0) : 0;
  run();
  return id;
}

std::int64_t Statement::integer(int column) const {
  const Value value = query_->value(column);
  const auto* const found = std::get_if<std::int64_t>(&value);
  return found != nullptr ? *found : 0;
}

double Statement::real(int column) const {
  const Value value = query_->value(column);
  const auto* const found = std::get_if<double>(&value);
  return found != nullptr ? *found : static_cast<double>(integer(column));
}

std::string_view Statement::bytes(int column) const {
  const Value value = query_->value(column);
  if (const auto* const blob = std::get_if<Blob>(&value)) return blob->bytes;
  const auto* const text = std::get_if<std::string_view>(&value);
  return text != nullptr ? *text : std::string_view();
}

namespace {

constexpr const char* schema = R"(
CREATE TABLE units (
  id INTEGER PRIMARY KEY, serial TEXT NOT NULL, name TEXT NOT NULL,
  accel_unit TEXT NOT NULL, gyro_unit TEXT NOT NULL, accel_scale REAL NOT NULL, gyro_scale REAL NOT NULL, added REAL NOT NULL);
CREATE UNIQUE INDEX unit_serial ON units (serial) WHERE serial <> '';
CREATE UNIQUE INDEX unit_name ON units (name) WHERE serial = '';
CREATE TABLE sessions (
  id INTEGER PRIMARY KEY, unit INTEGER NOT NULL REFERENCES units (id), hash TEXT NOT NULL UNIQUE, file TEXT NOT NULL, sha256 TEXT NOT NULL,
  operator TEXT NOT NULL, station TEXT NOT NULL, time REAL NOT NULL, time_from TEXT NOT NULL, added REAL NOT NULL);
CREATE TABLE files (
  session INTEGER NOT NULL REFERENCES sessions (id), name TEXT NOT NULL, sha256 TEXT NOT NULL, bytes INTEGER NOT NULL,
  PRIMARY KEY (session, name)) WITHOUT ROWID;
CREATE TABLE calibrations (
  id INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE, unit INTEGER NOT NULL REFERENCES units (id), session INTEGER REFERENCES sessions (id),
  method TEXT NOT NULL, options TEXT NOT NULL, operator TEXT NOT NULL, station TEXT NOT NULL, time REAL NOT NULL, time_from TEXT NOT NULL,
  created TEXT NOT NULL, software TEXT NOT NULL, verdict TEXT NOT NULL, added REAL NOT NULL, removed REAL, reason TEXT NOT NULL DEFAULT '');
CREATE INDEX calibration_unit ON calibrations (unit, time);
CREATE TABLE layouts (id INTEGER PRIMARY KEY, coefficients TEXT NOT NULL UNIQUE);
CREATE TABLE numbers (
  calibration INTEGER PRIMARY KEY REFERENCES calibrations (id), layout INTEGER NOT NULL REFERENCES layouts (id),
  data BLOB NOT NULL, crc32 INTEGER NOT NULL);
CREATE TABLE texts (
  calibration INTEGER PRIMARY KEY REFERENCES calibrations (id), bytes INTEGER NOT NULL, deflated BLOB NOT NULL, sha256 TEXT NOT NULL);
CREATE TABLE noises (
  id INTEGER PRIMARY KEY, sha256 TEXT NOT NULL, unit INTEGER NOT NULL REFERENCES units (id), operator TEXT NOT NULL, station TEXT NOT NULL,
  time REAL NOT NULL, time_from TEXT NOT NULL, added REAL NOT NULL, text TEXT NOT NULL, UNIQUE (unit, sha256));
CREATE TABLE failures (
  key TEXT PRIMARY KEY, file TEXT NOT NULL, hash TEXT NOT NULL, method TEXT NOT NULL, options TEXT NOT NULL, message TEXT NOT NULL,
  added REAL NOT NULL) WITHOUT ROWID;
)";

void create(Database& database) {
  Transaction transaction(database);
  if (database.engine().is_new()) {  // no other program has made it meanwhile
    database.run(schema);
    database.engine().mark(store_version);
  }
  transaction.commit();
}

}  // namespace

void expect_schema(Database& database, Access access) {
  Engine& engine = database.engine();
  if (access == Access::write && engine.is_new()) create(database);
  const std::string& file = database.file();
  const std::int64_t version = engine.version();
  if (version > store_version)
    throw Error(
        fmt::format("{}: is a fleet store of version {}; expected version {} at most: a newer imulab wrote it", file, version, store_version));
  if (version < 1) throw Error(fmt::format("{}: is a fleet store of version {}; expected version 1", file, version));
  const std::vector<std::string> names = engine.names();
  if (!std::ranges::all_of(store_tables, [&](const char* table) { return std::ranges::find(names, table) != names.end(); }))
    throw Error(file + ": has lost tables; expected a whole fleet store");
}

}  // namespace imulab::fleet
