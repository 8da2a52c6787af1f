#include "imulab/error.hpp"
#include "imulab/fleet/store/engine.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/format.h>

#ifdef IMULAB_WITH_SQLITE

#include <chrono>
#include <sqlite3.h>
#include <thread>
#include <unistd.h>

namespace imulab::fleet {

namespace {

constexpr std::int64_t application = 0x494D4C46;  // "IMLF", in the header of the file
constexpr int wait_ms = 60'000;                   // for another process that writes: longer than any one transaction but a merge's

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
int open_uri(const std::string& uri, int flags, sqlite3** handle) {
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

class Sqlite : public Engine {
 public:
  Sqlite(const std::filesystem::path& path, Access access);
  ~Sqlite() override { sqlite3_close(handle_); }

  void run(const std::string& statements) override {
    if (sqlite3_exec(handle_, statements.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
  }
  std::unique_ptr<Query> query(const std::string& text) override;
  std::int64_t changes() const override { return sqlite3_changes(handle_); }

  void begin(Access access) override { run(access == Access::write ? "BEGIN IMMEDIATE" : "BEGIN"); }
  void commit() override { run("COMMIT"); }
  void rollback() noexcept override {
    if (sqlite3_get_autocommit(handle_) == 0) sqlite3_exec(handle_, "ROLLBACK", nullptr, nullptr, nullptr);
  }

  bool is_new() override { return number("SELECT COUNT(*) FROM sqlite_schema") == 0 && number("PRAGMA application_id") == 0; }
  std::vector<std::string> names() override { return texts("SELECT name FROM sqlite_schema WHERE type = 'table'"); }
  std::int64_t version() override {
    if (number("PRAGMA application_id") != application) throw Error(file_ + ": is another SQLite file; expected a fleet store");
    return number("PRAGMA user_version");
  }
  void mark(std::int64_t version) override { run(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", application, version)); }
  std::vector<std::string> damages() override;
  std::string uri() const override { return uri_; }
  bool attach(const std::string& uri) override;
  void detach() noexcept override { sqlite3_exec(handle_, "DETACH DATABASE other", nullptr, nullptr, nullptr); }
  void fill(const std::string& table, Query& rows) override;

  sqlite3* handle() const { return handle_; }
  [[noreturn]] void fail() const;

 private:
  std::int64_t number(const std::string& text);
  std::vector<std::string> texts(const std::string& text);  // of the first column

  std::string file_, uri_;
  sqlite3* handle_ = nullptr;
};

class SqliteQuery : public Query {
 public:
  SqliteQuery(Sqlite& engine, const std::string& text) : engine_(engine) {
    if (sqlite3_prepare_v2(engine.handle(), text.c_str(), static_cast<int>(text.size()) + 1, &statement_, nullptr) != SQLITE_OK) engine.fail();
  }
  ~SqliteQuery() override { sqlite3_finalize(statement_); }

  bool next() override {
    const int result = sqlite3_step(statement_);
    if (result != SQLITE_ROW && result != SQLITE_DONE) engine_.fail();
    return result == SQLITE_ROW;
  }
  void reset() override { sqlite3_reset(statement_); }
  void bind(int parameter, const Value& value) override;
  int columns() const override { return sqlite3_column_count(statement_); }
  Value value(int column) const override;

 private:
  Sqlite& engine_;
  sqlite3_stmt* statement_ = nullptr;
};

void SqliteQuery::bind(int parameter, const Value& value) {
  struct Binder {
    sqlite3_stmt* statement;
    int parameter;
    int operator()(std::monostate) const { return sqlite3_bind_null(statement, parameter); }
    int operator()(std::int64_t number) const { return sqlite3_bind_int64(statement, parameter, number); }
    int operator()(double number) const { return sqlite3_bind_double(statement, parameter, number); }
    int operator()(std::string_view text) const {
      return sqlite3_bind_text64(statement, parameter, text.empty() ? "" : text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
    }
    int operator()(const Blob& blob) const {
      return sqlite3_bind_blob64(statement, parameter, blob.bytes.data(), blob.bytes.size(), SQLITE_TRANSIENT);
    }
  };
  if (std::visit(Binder{statement_, parameter}, value) != SQLITE_OK) engine_.fail();
}

Value SqliteQuery::value(int column) const {
  const auto bytes = [&](const void* data) {
    const int size = sqlite3_column_bytes(statement_, column);
    return data != nullptr ? std::string_view(static_cast<const char*>(data), static_cast<std::size_t>(size)) : std::string_view();
  };
  switch (sqlite3_column_type(statement_, column)) {
    case SQLITE_INTEGER:
      return std::int64_t{sqlite3_column_int64(statement_, column)};
    case SQLITE_FLOAT:
      return sqlite3_column_double(statement_, column);
    case SQLITE_TEXT:
      return bytes(sqlite3_column_text(statement_, column));
    case SQLITE_BLOB:
      return Blob{bytes(sqlite3_column_blob(statement_, column))};
    default:
      return {};
  }
}

Sqlite::Sqlite(const std::filesystem::path& path, Access access) : file_(path.string()) {
  if (is_stream(path)) throw DatabaseError(file_ + ": is a pipe or a device; expected a fleet store");  // SQLite would wait for its writer
  uri_ = uri_of(path);
  // Readers of a write-ahead log write its index, so reading opens for writing where the folder allows it.
  int opened = open_uri(uri_, SQLITE_OPEN_READWRITE | (access == Access::write ? SQLITE_OPEN_CREATE : 0), &handle_);
  try {
    if (opened != SQLITE_OK && access == Access::read && can_be_read_as_it_is(path)) {
      sqlite3_close(handle_);
      uri_ += "?immutable=1";
      opened = open_uri(uri_, SQLITE_OPEN_READONLY, &handle_);
    }
    if (opened != SQLITE_OK) fail();
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

void Sqlite::fail() const {
  const int code = sqlite3_errcode(handle_) & 255;
  const char* const expected = code == SQLITE_NOTADB                         ? "expected a fleet store"
                               : code == SQLITE_CANTOPEN                     ? "expected a fleet store that is there, in a folder that can be written"
                               : code == SQLITE_FULL || code == SQLITE_IOERR ? "expected room to write; the store is as it was before"
                               : code == SQLITE_BUSY                         ? "expected it within a minute from the other program that writes"
                               : code == SQLITE_READONLY                     ? "expected a store that can be written"
                                                                             : "expected a whole fleet store";
  throw DatabaseError(fmt::format("{}: SQLite: {}; {}", file_, sqlite3_errmsg(handle_), expected));
}

std::unique_ptr<Query> Sqlite::query(const std::string& text) { return std::make_unique<SqliteQuery>(*this, text); }

std::int64_t Sqlite::number(const std::string& text) {
  SqliteQuery row(*this, text);
  row.next();
  const Value value = row.value(0);
  const auto* const found = std::get_if<std::int64_t>(&value);
  return found != nullptr ? *found : 0;
}

std::vector<std::string> Sqlite::texts(const std::string& text) {
  std::vector<std::string> out;
  for (SqliteQuery rows(*this, text); rows.next();) {
    const Value value = rows.value(0);
    if (const auto* const found = std::get_if<std::string_view>(&value)) out.emplace_back(*found);
  }
  return out;
}

std::vector<std::string> Sqlite::damages() {
  std::vector<std::string> out = texts("PRAGMA integrity_check(20)");
  std::erase(out, "ok");
  for (std::string& text : texts("SELECT 'row ' || COALESCE(rowid, 0) || ' of ' || \"table\" || ' refers to a row of ' || parent || "
                                 "' that is not there' FROM pragma_foreign_key_check"))
    out.push_back(std::move(text));
  return out;
}

bool Sqlite::attach(const std::string& uri) {
  SqliteQuery statement(*this, "ATTACH DATABASE ? AS other");  // "": a temporary one
  statement.bind(1, std::string_view(uri));
  statement.next();
  return !uri.empty();
}

void Sqlite::fill(const std::string& table, Query& rows) {
  if (!rows.next()) return;
  std::string parameters = "?";
  for (int k = 1; k < rows.columns(); ++k) parameters += ", ?";
  SqliteQuery insert(*this, fmt::format("INSERT INTO {} VALUES ({})", table, parameters));
  do {
    for (int k = 0; k < rows.columns(); ++k) insert.bind(k + 1, rows.value(k));
    insert.next();
    insert.reset();
  } while (rows.next());
}

}  // namespace

std::unique_ptr<Engine> open_sqlite(const std::filesystem::path& file, Access access) { return std::make_unique<Sqlite>(file, access); }

}  // namespace imulab::fleet

#else

namespace imulab::fleet {

std::unique_ptr<Engine> open_sqlite(const std::filesystem::path& file, Access) {
  throw DatabaseError(file.string() + ": this imulab was built without SQLite; expected a build with libsqlite3");
}

}  // namespace imulab::fleet

#endif
