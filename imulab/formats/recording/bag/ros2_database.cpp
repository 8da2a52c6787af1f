#include "imulab/formats/recording/bag/ros2_database.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <limits>
#include <string>

#ifdef IMULAB_WITH_SQLITE

#include <sqlite3.h>

namespace imulab::bag {

namespace {

/// The file as SQLite names one that nobody changes: it is read without locks and files beside it.
std::string unchanging(const std::string& file) {
  std::string name = "file:";
  for (const char c : file) name += c == '%' || c == '?' || c == '#' ? fmt::format("%{:02X}", static_cast<unsigned>(c)) : std::string(1, c);
  return name + "?immutable=1";
}

}  // namespace

Database::Database(const std::filesystem::path& path, const std::filesystem::path& as, bool write) : file_(as.string()), write_(write) {
  const auto open = [&](const std::string& name, int flags) {
    const int opened = sqlite3_open_v2(name.c_str(), &handle_, flags, nullptr);
    return opened == SQLITE_OK ? sqlite3_exec(handle_, "PRAGMA schema_version", nullptr, nullptr, nullptr) : opened;
  };
  int opened = open(path.string(), write ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY);
  if (const int kind = opened & 255;
      !write && (kind == SQLITE_CANTOPEN || kind == SQLITE_READONLY)) {  // a bag with a write-ahead log, in a folder that cannot be written
    sqlite3_close(handle_);
    opened = open(unchanging(file_), SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
  }
  if (opened != SQLITE_OK) {
    const std::string why = sqlite3_errmsg(handle_);
    sqlite3_close(handle_);
    throw Error(fmt::format("{}: {}; expected {}", file_, why, write ? "room to write" : "a bag of ROS 2 in SQLite"));
  }
  // The file is somebody else's: its schema may do nothing but hold tables, and its pages are checked.
  if (!write) sqlite3_db_config(handle_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);  // which would insist on a journal
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(handle_, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_exec(handle_, "PRAGMA cell_size_check = ON", nullptr, nullptr, nullptr);
}

Database::~Database() { sqlite3_close(handle_); }

void Database::fail() const {
  throw Error(fmt::format("{}: SQLite: {}; expected {}", file_, sqlite3_errmsg(handle_),
                          write_ ? "room to write" : "a bag of ROS 2 with the tables topics and messages"));
}

void Database::run(const char* statement) {
  if (sqlite3_exec(handle_, statement, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

Query::Query(Database& database, const char* text) : database_(database) {
  if (sqlite3_prepare_v2(database.handle(), text, -1, &statement_, nullptr) != SQLITE_OK) database.fail();
}

Query::~Query() { sqlite3_finalize(statement_); }

bool Query::next() {
  const int result = sqlite3_step(statement_);
  if (result != SQLITE_ROW && result != SQLITE_DONE) database_.fail();
  return result == SQLITE_ROW;
}

std::int64_t Query::integer(int column) const { return sqlite3_column_int64(statement_, column); }

std::string_view Query::bytes(int column) const {
  const void* data = sqlite3_column_blob(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  return data != nullptr ? std::string_view(static_cast<const char*>(data), static_cast<std::size_t>(size)) : std::string_view();
}

Ros2Database::Ros2Database(const std::filesystem::path& path) : database_(path), file_(path.string()) {
  expect_all_pages(path);
  try {
    for (Query topics(database_, "SELECT id, name, type, serialization_format FROM topics ORDER BY id"); topics.next();) {
      const std::int64_t id = topics.integer(0);
      if (id < 0 || id > std::numeric_limits<std::uint32_t>::max()) throw Damaged("a topic's id out of range");
      add_channel(topics_, static_cast<std::uint32_t>(id), topics.bytes(1), topics.bytes(2), topics.bytes(3));
    }
  } catch (const Damaged& e) {
    throw Error(fmt::format("{}: {}; expected a bag of ROS 2", file_, e.what()));
  }
}

/// SQLite takes a last page that is cut off for zeros.
void Ros2Database::expect_all_pages(const std::filesystem::path& path) {
  Query pages(database_, "SELECT page_count * page_size FROM pragma_page_count, pragma_page_size");
  const std::uintmax_t bytes = pages.next() ? static_cast<std::uintmax_t>(pages.integer(0)) : 0;
  Query mode(database_, "PRAGMA journal_mode");
  if (mode.next() && mode.bytes(0) != "wal" && std::filesystem::file_size(path) < bytes)  // the rest of a wal is in another file
    throw Error(fmt::format("{}: is cut off at byte {} of {}; expected a whole bag", file_, std::filesystem::file_size(path), bytes));
}

void Ros2Database::count_messages() {
  for (Query counts(database_, "SELECT topic_id, COUNT(*) FROM messages GROUP BY topic_id"); counts.next();)
    if (Topic* topic = topic_of(topics_, static_cast<std::uint32_t>(counts.integer(0))); topic != nullptr)
      topic->messages += static_cast<std::uint64_t>(counts.integer(1));
}

void Ros2Database::each_row(const Topic& topic, const std::function<void(std::int64_t, std::int64_t, std::string_view)>& sink) {
  // A row's data are read only where the topic is the one: cameras stay on the disk.
  Query rows(
      database_,
      fmt::format("SELECT rowid, timestamp, data FROM messages WHERE topic_id IN ({}) ORDER BY rowid", fmt::join(topic.channels, ",")).c_str());
  while (rows.next()) {
    const std::string_view message = rows.bytes(2);
    if (message.starts_with("\x28\xB5\x2F\xFD"))  // the first bytes of Zstandard
      throw Error(fmt::format("{}: its messages are compressed one by one; expected them plain: convert the bag with ros2 bag convert", file_));
    sink(rows.integer(0), rows.integer(1), message);
  }
}

void Ros2Database::each_message(const Topic& topic, const MessageSink& sink) {
  each_row(topic, [&](std::int64_t, std::int64_t log_time_ns, std::string_view message) { sink(log_time_ns, message); });
}

namespace {

/// Page for page.
void copy_database(Database& from, Database& to) {
  constexpr int pages = 1024;
  sqlite3_backup* backup = sqlite3_backup_init(to.handle(), "main", from.handle(), "main");
  if (backup == nullptr) to.fail();
  while (sqlite3_backup_step(backup, pages) == SQLITE_OK) {
  }
  if (sqlite3_backup_finish(backup) != SQLITE_OK) to.fail();
}

/// In a damaged tree two rows may be one: both would be written.
void expect_whole(Database& database, const std::filesystem::path& file) {
  Query check(database, "PRAGMA quick_check(1)");
  if (check.next() && check.bytes(0) != "ok")
    throw Error(fmt::format("{}: is damaged: {}; expected a bag without damage (sqlite3 BAG .recover)", file.string(), excerpt(check.bytes(0), 120)));
}

/// The data of a row, written in place: nothing else of the database changes.
class Blob {
 public:
  explicit Blob(Database& database) : database_(database) {}
  ~Blob() { close(); }
  Blob(const Blob&) = delete;
  Blob& operator=(const Blob&) = delete;

  void write(std::int64_t id, std::string_view bytes) {
    const int opened =
        blob_ == nullptr ? sqlite3_blob_open(database_.handle(), "main", "messages", "data", id, 1, &blob_) : sqlite3_blob_reopen(blob_, id);
    if (opened != SQLITE_OK || sqlite3_blob_write(blob_, bytes.data(), static_cast<int>(bytes.size()), 0) != SQLITE_OK) database_.fail();
  }
  void close() {
    sqlite3_blob_close(blob_);
    blob_ = nullptr;
  }

 private:
  Database& database_;
  sqlite3_blob* blob_ = nullptr;
};

}  // namespace

std::unique_ptr<Bag> open_ros2_database(const std::filesystem::path& path) { return std::make_unique<Ros2Database>(path); }

void rewrite_ros2_database(const std::filesystem::path& in, const Topic& topic, const MessageChange& change, WholeFile& out) {
  Ros2Database bag(in);
  Database copy(out.temporary(), out.path());
  copy.run("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF");  // a copy that fails is thrown away
  copy_database(bag.database(), copy);
  expect_whole(copy, in);
  copy.run("PRAGMA journal_mode = OFF; BEGIN");
  Blob blob(copy);
  bag.each_row(topic, [&](std::int64_t id, std::int64_t, std::string_view message) {
    std::string bytes(message);
    change({bytes.data(), bytes.size()});
    blob.write(id, bytes);
  });
  blob.close();
  copy.run("COMMIT");
}

}  // namespace imulab::bag

#else

namespace imulab::bag {
namespace {

[[noreturn]] void fail_without_sqlite(const std::filesystem::path& path) {
  throw Error(path.string() + ": this imulab was built without SQLite; expected a build with libsqlite3, or the bag as MCAP");
}

}  // namespace

std::unique_ptr<Bag> open_ros2_database(const std::filesystem::path& path) { fail_without_sqlite(path); }
void rewrite_ros2_database(const std::filesystem::path& in, const Topic&, const MessageChange&, WholeFile&) { fail_without_sqlite(in); }

}  // namespace imulab::bag

#endif

imulab::RecordingFormat imulab::recording_io::ros2_database_format() {
  static constexpr bag::BagFormat format{".db3", bag::open_ros2_database, bag::rewrite_ros2_database};
  return bag::bag_row(
      "ROS 2 bag in SQLite", [](std::string_view head) { return head.starts_with(std::string_view("SQLite format 3\0", 16)); }, format);
}
