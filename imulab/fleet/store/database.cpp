#include "imulab/fleet/store/database.hpp"

#include "imulab/error.hpp"
#include "imulab/fleet/store/store.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/format.h>

#ifdef IMULAB_WITH_SQLITE

#include <chrono>
#include <sqlite3.h>
#include <thread>
#include <unistd.h>

namespace imulab::fleet {

namespace {

constexpr int wait_ms = 60'000;  // for another process that writes: longer than any one transaction but a merge's

/// Two processes that open a new file at once: one of them changes its journal, the other is refused without waiting.
void write_ahead(sqlite3* handle) {
  constexpr int tries = 200;
  for (int k = 0; k < tries; ++k) {
    if (sqlite3_exec(handle, "PRAGMA journal_mode = WAL", nullptr, nullptr, nullptr) != SQLITE_BUSY) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
}

/// "file:/data/fleet.db": no character of a name means anything else there.
std::string uri_of(const std::filesystem::path& path) {
  std::string name = std::filesystem::absolute(path).lexically_normal().string(), uri = "file:/";
  name.erase(0, name.find_first_not_of('/'));
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' || c == '.' || c == '_' || c == '-';
    uri += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri;
}

/// Opens it and reads its first page.
int open(const std::string& uri, int flags, sqlite3** handle) {
  int opened = sqlite3_open_v2(uri.c_str(), handle, flags | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
  if (opened != SQLITE_OK) return opened;
  sqlite3_busy_timeout(*handle, wait_ms);
  return sqlite3_exec(*handle, "PRAGMA schema_version", nullptr, nullptr, nullptr);
}

/// A store in a folder where no index of its write-ahead log can be made is read as it is; not so where a log has changes that the store has not.
bool can_be_read_as_it_is(const std::filesystem::path& path) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  std::error_code none;
  if (::access(folder.c_str(), W_OK) == 0 || !std::filesystem::is_regular_file(path, none)) return false;
  for (const char* end : {"-wal", "-journal"}) {  // changes to be added, or to be undone
    const std::filesystem::path log = path.string() + end;
    if (const auto size = std::filesystem::file_size(log, none); !none && size > 0)
      throw DatabaseError(
          fmt::format("{}: its last changes are in {}, which only a program that may write in the folder can read; expected a folder "
                      "that can be written, or a copy of both files in one",
                      path.string(), log.filename().string()));
  }
  return true;
}

}  // namespace

Database::Database(const std::filesystem::path& path, Access access) : file_(path.string()) {
  if (is_stream(path)) throw DatabaseError(file_ + ": is a pipe or a device; expected a fleet store");  // SQLite would wait for its writer
  uri_ = uri_of(path);
  // Readers of a write-ahead log write its index, so reading opens for writing where the folder allows it.
  int opened = open(uri_, SQLITE_OPEN_READWRITE | (access == Access::write ? SQLITE_OPEN_CREATE : 0), &handle_);
  try {
    if (opened != SQLITE_OK && access == Access::read && can_be_read_as_it_is(path)) {
      sqlite3_close(handle_);
      uri_ += "?immutable=1";
      opened = open(uri_, SQLITE_OPEN_READONLY, &handle_);
    }
    if (opened != SQLITE_OK) throw DatabaseError(fmt::format("{}: {}; expected a fleet store", file_, sqlite3_errmsg(handle_)));
  } catch (...) {
    sqlite3_close(handle_);
    throw;
  }
  // The file may be somebody else's: its schema may do nothing but hold tables, and its pages are checked.
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_exec(handle_, "PRAGMA cell_size_check = ON; PRAGMA foreign_keys = ON; PRAGMA synchronous = FULL; PRAGMA mmap_size = 0", nullptr, nullptr,
               nullptr);  // pages that are mapped would count as memory of the program, all of them
  if (access == Access::write) write_ahead(handle_);
}

Database::~Database() { sqlite3_close(handle_); }

void Database::fail() const {
  const int code = sqlite3_errcode(handle_) & 255;
  const char* const expected = code == SQLITE_FULL || code == SQLITE_IOERR ? "expected room to write; the store is as it was before"
                               : code == SQLITE_BUSY                       ? "expected it within a minute from the other program that writes"
                               : code == SQLITE_READONLY                   ? "expected a store that can be written"
                                                                           : "expected a whole fleet store";
  throw DatabaseError(fmt::format("{}: SQLite: {}; {}", file_, sqlite3_errmsg(handle_), expected));
}

void Database::run(const std::string& statements) {
  if (sqlite3_exec(handle_, statements.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

std::int64_t Database::number(const std::string& query) {
  Statement statement(*this, query);
  return statement.next() ? statement.integer(0) : 0;
}

std::int64_t Database::last_id() const { return sqlite3_last_insert_rowid(handle_); }
std::int64_t Database::changes() const { return sqlite3_changes(handle_); }

Statement::Statement(Database& database, const std::string& text) : database_(database) {
  if (sqlite3_prepare_v2(database.handle(), text.c_str(), static_cast<int>(text.size()) + 1, &statement_, nullptr) != SQLITE_OK) database.fail();
}
Statement::~Statement() { sqlite3_finalize(statement_); }

bool Statement::next() {
  const int result = sqlite3_step(statement_);
  if (result != SQLITE_ROW && result != SQLITE_DONE) database_.fail();
  return result == SQLITE_ROW;
}
void Statement::run() {
  while (next()) {
  }
  reset();
}
void Statement::reset() { sqlite3_reset(statement_); }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_, column); }
double Statement::real(int column) const { return sqlite3_column_double(statement_, column); }
bool Statement::is_null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
std::string_view Statement::bytes(int column) const {
  const void* data = sqlite3_column_blob(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  return data != nullptr ? std::string_view(static_cast<const char*>(data), static_cast<std::size_t>(size)) : std::string_view();
}

void Statement::bind(int parameter, std::int64_t value) {
  if (sqlite3_bind_int64(statement_, parameter, value) != SQLITE_OK) database_.fail();
}
void Statement::bind(int parameter, double value) {
  if (sqlite3_bind_double(statement_, parameter, value) != SQLITE_OK) database_.fail();
}
void Statement::bind(int parameter, std::string_view text) {
  const char* const data = text.empty() ? "" : text.data();
  if (sqlite3_bind_text64(statement_, parameter, data, text.size(), SQLITE_TRANSIENT, SQLITE_UTF8) != SQLITE_OK) database_.fail();
}
void Statement::bind(int parameter, const Blob& blob) {
  if (sqlite3_bind_blob64(statement_, parameter, blob.bytes.data(), blob.bytes.size(), SQLITE_TRANSIENT) != SQLITE_OK) database_.fail();
}
void Statement::bind(int parameter, Nothing) {
  if (sqlite3_bind_null(statement_, parameter) != SQLITE_OK) database_.fail();
}

Transaction::Transaction(Database& database) : database_(database) { database.run("BEGIN IMMEDIATE"); }
Transaction::~Transaction() {
  if (open_ && sqlite3_get_autocommit(database_.handle()) == 0) sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}
void Transaction::commit() {
  database_.run("COMMIT");
  open_ = false;
}

Snapshot::Snapshot(Database& database) : database_(database) { database.run("BEGIN"); }
Snapshot::~Snapshot() { sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr); }

}  // namespace imulab::fleet

#else

namespace imulab::fleet {

Database::Database(const std::filesystem::path& path, Access) : file_(path.string()) {
  throw DatabaseError(file_ + ": this imulab was built without SQLite; expected a build with libsqlite3");
}
// Nothing else is called without a database.
Database::~Database() = default;
void Database::fail() const { throw DatabaseError(file_ + ": no SQLite"); }
void Database::run(const std::string&) { fail(); }
std::int64_t Database::number(const std::string&) { fail(); }
std::int64_t Database::last_id() const { fail(); }
std::int64_t Database::changes() const { fail(); }
Statement::Statement(Database& database, const std::string&) : database_(database) { database.fail(); }
Statement::~Statement() = default;
bool Statement::next() { database_.fail(); }
void Statement::run() { database_.fail(); }
void Statement::reset() { database_.fail(); }
std::int64_t Statement::integer(int) const { database_.fail(); }
double Statement::real(int) const { database_.fail(); }
bool Statement::is_null(int) const { database_.fail(); }
std::string_view Statement::bytes(int) const { database_.fail(); }
void Statement::bind(int, std::int64_t) { database_.fail(); }
void Statement::bind(int, double) { database_.fail(); }
void Statement::bind(int, std::string_view) { database_.fail(); }
void Statement::bind(int, const Blob&) { database_.fail(); }
void Statement::bind(int, Nothing) { database_.fail(); }
Transaction::Transaction(Database& database) : database_(database) { database.fail(); }
Transaction::~Transaction() = default;
void Transaction::commit() { database_.fail(); }
Snapshot::Snapshot(Database& database) : database_(database) { database.fail(); }
Snapshot::~Snapshot() = default;

}  // namespace imulab::fleet

#endif

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
