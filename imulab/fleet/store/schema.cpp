#include "imulab/fleet/store/schema.hpp"

#include "imulab/core/error.hpp"
#include "imulab/fleet/store/store.hpp"

#include <fmt/format.h>

namespace imulab::fleet {

namespace {

constexpr std::int64_t application = 0x494D4C46;  // "IMLF", in the header of the file

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

bool is_empty(Database& database) { return database.number("SELECT COUNT(*) FROM sqlite_schema") == 0; }

void create(Database& database) {
  Transaction transaction(database);
  if (is_empty(database)) {  // no other program has made it meanwhile
    database.run(schema);
    database.run(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", application, store_version));
  }
  transaction.commit();
}

}  // namespace

void expect_schema(Database& database, Access access) {
  if (access == Access::write && is_empty(database) && database.number("PRAGMA application_id") == 0) create(database);
  const std::string& file = database.file();
  if (database.number("PRAGMA application_id") != application) throw Error(file + ": is another SQLite file; expected a fleet store");
  const std::int64_t version = database.number("PRAGMA user_version");
  if (version > store_version)
    throw Error(
        fmt::format("{}: is a fleet store of version {}; expected version {} at most: a newer imulab wrote it", file, version, store_version));
  if (version < 1) throw Error(fmt::format("{}: is a fleet store of version {}; expected version 1", file, version));
  constexpr int tables = 9;
  if (database.number("SELECT COUNT(*) FROM sqlite_schema WHERE type = 'table' AND name IN ('units', 'sessions', 'files', 'calibrations', "
                      "'layouts', 'numbers', 'texts', 'noises', 'failures')") != tables)
    throw Error(file + ": has lost tables; expected a whole fleet store");
}

}  // namespace imulab::fleet
