#include "imulab/core/error.hpp"
#include "imulab/formats/recording/bag/ros2_database.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/core.h>

#ifdef IMULAB_WITH_SQLITE

#include <sqlite3.h>
#include <string>

namespace imulab::bag {
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

void rewrite_ros2_database(const std::filesystem::path& in, const Topic&, const MessageChange&, WholeFile&) {
  throw Error(in.string() + ": this imulab was built without SQLite; expected a build with libsqlite3, or the bag as MCAP");
}

}  // namespace imulab::bag

#endif
