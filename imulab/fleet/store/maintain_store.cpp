#include "imulab/error.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/fleet/store/numbers.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace imulab {

namespace {

using fleet::Statement;

/// Every calibration has its numbers and its text, and both are what was written.
void check_numbers(fleet::Database& db, std::vector<std::string>& damaged, const std::function<void(double)>& progress) {
  const double all = std::max<double>(1, static_cast<double>(db.number("SELECT COUNT(*) FROM calibrations")));
  double done = 0;
  Statement rows(db,
                 "SELECT c.id, n.data, n.crc32, l.coefficients, t.deflated, t.bytes, t.sha256 FROM calibrations c LEFT JOIN numbers n ON "
                 "n.calibration = c.id LEFT JOIN layouts l ON l.id = n.layout LEFT JOIN texts t ON t.calibration = c.id ORDER BY c.id");
  for (; rows.next(); ++done) {
    const std::int64_t id = rows.integer(0);
    try {
      const std::size_t n = fleet::parse_layout(rows.bytes(3)).size();
      if (!fleet::is_packed(rows.bytes(1), n) || fleet::crc32_of(rows.bytes(1)) != rows.integer(2)) throw Error("its numbers are damaged");
      const std::string text = fleet::inflated(rows.bytes(4), static_cast<std::size_t>(std::max<std::int64_t>(0, rows.integer(5))));
      if (sha256(text) != rows.bytes(6)) throw Error("its text is damaged");
    } catch (const Error& e) {
      damaged.push_back(fmt::format("calibration {}: {}", id, e.what()));
    }
    if (progress) progress(0.5 * done / all);
  }
}

enum class Found { same, changed, missing };

Found look_at(const std::filesystem::path& file, std::string_view sha) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none)) return Found::missing;
  return file_sum(file).sha256 == sha ? Found::same : Found::changed;
}

}  // namespace

FleetStore::Checked FleetStore::check(const std::function<void(double)>& progress) {
  Checked out;
  out.damaged = database_.engine().damages();
  check_numbers(database_, out.damaged, progress);
  const auto judge = [&](const std::filesystem::path& file, std::string_view sha) {
    const Found found = look_at(file, sha);
    out.files += 1;
    out.missing += found == Found::missing;
    if (found == Found::changed) out.changed.push_back(file.string());
  };
  const double all = std::max<double>(1, static_cast<double>(database_.number("SELECT COUNT(*) FROM sessions")));
  double done = 0;
  std::int64_t before = 0;
  Statement rows(database_,
                 "SELECT s.id, s.file, s.sha256, f.name, f.sha256 FROM sessions s LEFT JOIN files f ON f.session = s.id ORDER BY s.id, f.name");
  while (rows.next()) {
    const std::filesystem::path session = rows.text(1);
    if (rows.integer(0) != std::exchange(before, rows.integer(0))) {
      judge(session, rows.bytes(2));
      if (progress) progress(0.5 + 0.5 * done++ / all);
    }
    if (!rows.is_null(3)) judge(session.parent_path() / rows.text(3), rows.bytes(4));
  }
  return out;
}

namespace {

/// Rows of the other store under the numbers they get in this one; a unit is the same if serial number and name are.
constexpr const char* merge_statements = R"(
INSERT INTO main.units (serial, name, accel_unit, gyro_unit, accel_scale, gyro_scale, added)
  SELECT serial, name, accel_unit, gyro_unit, accel_scale, gyro_scale, added FROM other.units o WHERE NOT EXISTS
    (SELECT 1 FROM main.units u WHERE u.serial = o.serial AND u.name = o.name) ORDER BY id;
CREATE TABLE temp.same_unit (theirs INTEGER PRIMARY KEY, ours INTEGER NOT NULL);
INSERT INTO temp.same_unit SELECT o.id, u.id FROM other.units o JOIN main.units u ON u.serial = o.serial AND u.name = o.name;
UPDATE main.units SET (accel_unit, gyro_unit, accel_scale, gyro_scale) = (SELECT accel_unit, gyro_unit, accel_scale, gyro_scale FROM other.units o
  JOIN temp.same_unit s ON s.theirs = o.id WHERE s.ours = main.units.id) WHERE accel_scale = 0 AND id IN (SELECT ours FROM temp.same_unit);
INSERT INTO main.sessions (unit, hash, file, sha256, operator, station, time, time_from, added)
  SELECT s.ours, hash, file, sha256, operator, station, time, time_from, added FROM other.sessions o JOIN temp.same_unit s ON s.theirs = o.unit
    WHERE NOT EXISTS (SELECT 1 FROM main.sessions m WHERE m.hash = o.hash) ORDER BY o.id;
CREATE TABLE temp.same_session (theirs INTEGER PRIMARY KEY, ours INTEGER NOT NULL);
INSERT INTO temp.same_session SELECT o.id, m.id FROM other.sessions o JOIN main.sessions m USING (hash);
INSERT INTO main.files (session, name, sha256, bytes)
  SELECT s.ours, name, sha256, bytes FROM other.files o JOIN temp.same_session s ON s.theirs = o.session WHERE TRUE ON CONFLICT DO NOTHING;
CREATE TABLE temp.new_calibration (id INTEGER PRIMARY KEY);
INSERT INTO temp.new_calibration SELECT id FROM other.calibrations o WHERE NOT EXISTS (SELECT 1 FROM main.calibrations m WHERE m.key = o.key);
INSERT INTO main.calibrations (key, unit, session, method, options, operator, station, time, time_from, created, software, verdict, added, removed, reason)
  SELECT key, u.ours, s.ours, method, options, operator, station, time, time_from, created, software, verdict, added, removed, reason
    FROM other.calibrations o JOIN temp.same_unit u ON u.theirs = o.unit LEFT JOIN temp.same_session s ON s.theirs = o.session
    WHERE o.id IN (SELECT id FROM temp.new_calibration) ORDER BY o.id;
INSERT INTO main.layouts (coefficients) SELECT coefficients FROM other.layouts WHERE TRUE ORDER BY id ON CONFLICT DO NOTHING;
INSERT INTO main.numbers (calibration, layout, data, crc32)
  SELECT m.id, l.id, n.data, n.crc32 FROM other.numbers n JOIN other.calibrations o ON o.id = n.calibration JOIN main.calibrations m USING (key)
    JOIN other.layouts k ON k.id = n.layout JOIN main.layouts l USING (coefficients) WHERE o.id IN (SELECT id FROM temp.new_calibration) ORDER BY m.id;
INSERT INTO main.texts (calibration, bytes, deflated, sha256)
  SELECT m.id, t.bytes, t.deflated, t.sha256 FROM other.texts t JOIN other.calibrations o ON o.id = t.calibration JOIN main.calibrations m USING (key)
    WHERE o.id IN (SELECT id FROM temp.new_calibration) ORDER BY m.id;
INSERT INTO main.noises (sha256, unit, operator, station, time, time_from, added, text)
  SELECT sha256, u.ours, operator, station, time, time_from, added, text FROM other.noises o JOIN temp.same_unit u ON u.theirs = o.unit WHERE TRUE
    ORDER BY o.id ON CONFLICT DO NOTHING;
INSERT INTO main.failures SELECT * FROM other.failures WHERE TRUE ON CONFLICT DO NOTHING;
DROP TABLE temp.same_unit; DROP TABLE temp.same_session; DROP TABLE temp.new_calibration;
)";

/// The tables of another store as "other.": those of an SQLite file where they are, for another one, else copies.
class OtherTables {
 public:
  OtherTables(fleet::Database& db, fleet::Database& other) : db_(db), other_(other), copied_(!db.engine().attach(other.engine().uri())) {}
  ~OtherTables() { db_.engine().detach(); }
  OtherTables(const OtherTables&) = delete;
  OtherTables& operator=(const OtherTables&) = delete;

  void copy() const {
    if (!copied_) return;
    const fleet::Snapshot one_state(other_);
    for (const char* const table : fleet::store_tables) {
      db_.run(fmt::format("CREATE TABLE other.{0} AS SELECT * FROM main.{0} WHERE FALSE", table));
      Statement rows(other_, fmt::format("SELECT * FROM {}", table));
      db_.engine().fill(fmt::format("other.{}", table), rows.query());
    }
  }
  void drop() const {
    for (const char* const table : fleet::store_tables)
      if (copied_) db_.run(fmt::format("DROP TABLE other.{}", table));
  }

 private:
  fleet::Database& db_;
  fleet::Database& other_;
  bool copied_;
};

/// One serial number with two names, or with two sets of sensors, in the two stores.
void expect_same_units(fleet::Database& db, const std::string& other) {
  Statement rows(
      db,
      "SELECT o.serial, u.name, o.name FROM other.units o JOIN main.units u ON u.serial = o.serial AND (u.serial <> '' OR u.name = o.name) "
      "WHERE u.name <> o.name OR (u.accel_scale > 0 AND o.accel_scale > 0 AND (u.accel_unit <> o.accel_unit OR u.gyro_unit <> "
      "o.gyro_unit OR u.accel_scale > 1.4142 * o.accel_scale OR o.accel_scale > 1.4142 * u.accel_scale OR u.gyro_scale > 1.4142 * "
      "o.gyro_scale OR o.gyro_scale > 1.4142 * u.gyro_scale))");
  if (rows.next())
    throw Error(fmt::format("{}: serial number {} is {} here and {} there, or their sensors differ: two units with one serial number; expected one",
                            other, rows.text(0), rows.text(1), rows.text(2)));
}

}  // namespace

std::int64_t FleetStore::merge(const std::filesystem::path& other) {
  std::error_code none;
  if (std::filesystem::equivalent(other, database_.file(), none)) throw Error(other.string() + ": is the store itself; expected another one");
  FleetStore whole(other, fleet::Access::read);  // a whole store of a known version
  const OtherTables tables(database_, whole.database());
  fleet::Transaction transaction(database_);
  tables.copy();
  expect_same_units(database_, whole.database().file());
  const std::int64_t before = database_.number("SELECT COUNT(*) FROM main.calibrations");
  database_.run(merge_statements);
  const std::int64_t added = database_.number("SELECT COUNT(*) FROM main.calibrations") - before;
  tables.drop();
  transaction.commit();
  return added;
}

}  // namespace imulab
