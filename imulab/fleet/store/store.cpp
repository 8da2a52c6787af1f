#include "imulab/fleet/store/store.hpp"

#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/fleet/store/numbers.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

namespace imulab {

namespace {

using fleet::Blob;
using fleet::Statement;
using fleet::Transaction;

std::string key_of(const FleetSession& session, const FleetRequest& request) {
  return sha256(fmt::format("{}\n{}\n{}", session.hash, request.method, request.options));
}
std::string failure_key(const FleetSession& session, const FleetRequest& request) {
  return sha256(fmt::format("{}\n{}\n{}", session.file, request.method, request.options));
}

/// The geometric mean of the diagonal's sizes.
double scale_of(const Matrix3d& matrix) { return std::cbrt(std::abs(matrix(0, 0) * matrix(1, 1) * matrix(2, 2))); }

/// The numbers of a calibration beside its row.
void add_numbers(fleet::Database& db, std::int64_t id, const fleet::Numbers& numbers, const std::string& text) {
  const std::string layout = fleet::layout_text(numbers.estimated), data = fleet::packed(numbers), small = fleet::deflated(text);
  Statement(db, "INSERT INTO layouts (coefficients) VALUES (?) ON CONFLICT DO NOTHING").with(layout).run();
  Statement(db, "INSERT INTO numbers (calibration, layout, data, crc32) VALUES (?, (SELECT id FROM layouts WHERE coefficients = ?), ?, ?)")
      .with(id, layout, Blob{data}, fleet::crc32_of(data))
      .run();
  Statement(db, "INSERT INTO texts (calibration, bytes, deflated, sha256) VALUES (?, ?, ?, ?)")
      .with(id, static_cast<std::int64_t>(text.size()), Blob{small}, sha256(text))
      .run();
}

}  // namespace

FleetSession hashed_session(const std::string& file, const std::string& sum,
                            const std::vector<std::pair<std::string, std::filesystem::path>>& files) {
  FleetSession session{file, sum, {}, ""};
  std::string all = sum;
  for (const auto& [name, place] : files) {
    const FileSum of_file = file_sum(place);
    session.files.push_back({.file = name, .sha256 = of_file.sha256, .bytes = of_file.bytes, .accel_temperature = {}, .gyro_temperature = {}});
    all += "\n" + of_file.sha256;
  }
  session.hash = sha256(all);
  return session;
}

FleetStore::FleetStore(const std::filesystem::path& file, fleet::Access access)
    : owned_(std::make_unique<fleet::Database>(file, access)), database_(*owned_) {
  expect_schema(database_, access);
}
FleetStore::~FleetStore() = default;

FleetStore::Known FleetStore::known(const FleetSession& session, const FleetRequest& request) {
  Statement done(database_, "SELECT 1 FROM calibrations WHERE key = ?");
  if (done.with(key_of(session, request)).next()) return Known::calibrated;
  Statement failed(database_, "SELECT 1 FROM failures WHERE key = ? AND hash = ?");
  return failed.with(failure_key(session, request), session.hash).next() ? Known::failed : Known::no;
}

std::int64_t FleetStore::unit_named(const std::string& serial, const std::string& name) {
  Statement find(database_,
                 serial.empty() ? "SELECT id, name FROM units WHERE serial = '' AND name = ?" : "SELECT id, name FROM units WHERE serial = ?");
  if (!find.with(serial.empty() ? name : serial).next()) return 0;
  if (find.bytes(1) != name)
    throw Error(fmt::format("serial number {} is {} in the store, and {} here: two units with one serial number; expected one name for one unit",
                            serial, find.text(1), name));
  return find.integer(0);
}

std::int64_t FleetStore::unit_of(const Calibration& c) {
  if (c.serial.empty() && c.imu.empty()) throw Error("names no unit; expected a serial number or a name");
  const double accel = scale_of(c.model.accel.matrix), gyro = scale_of(c.model.gyro.matrix);
  const std::int64_t id = unit_named(c.serial, c.imu);
  if (id == 0) {
    return Statement(database_,
                     "INSERT INTO units (serial, name, accel_unit, gyro_unit, accel_scale, gyro_scale, added) VALUES (?, ?, ?, ?, ?, ?, ?) "
                     "RETURNING id")
        .with(c.serial, c.imu, c.model.accel.raw_unit, c.model.gyro.raw_unit, accel, gyro, fleet::now())
        .run_for_id();
  }
  Statement sensors(database_, "SELECT accel_unit, gyro_unit, accel_scale, gyro_scale FROM units WHERE id = ?");
  sensors.with(id).next();
  const auto expect_same = [&](const char* triad, const std::string& unit, const std::string& had, double scale, double before) {
    if (before == 0) return;                // known by a session that was not calibrated
    const double farther = std::sqrt(2.0);  // ranges of a sensor differ by two at least
    if (unit == had && scale < farther * before && before < farther * scale) return;
    throw Error(
        fmt::format("{} {}: its {} gives {} with a scale of {:.4g}, in the store {} with {:.4g}: other sensors; expected one serial number for "
                    "one unit",
                    c.serial.empty() ? "unit" : "serial number", c.serial.empty() ? c.imu : c.serial, triad, unit, scale, had, before));
  };
  expect_same("accelerometer", c.model.accel.raw_unit, sensors.text(0), accel, sensors.real(2));
  expect_same("gyro", c.model.gyro.raw_unit, sensors.text(1), gyro, sensors.real(3));
  if (sensors.real(2) == 0)
    Statement(database_, "UPDATE units SET accel_unit = ?, gyro_unit = ?, accel_scale = ?, gyro_scale = ? WHERE id = ?")
        .with(c.model.accel.raw_unit, c.model.gyro.raw_unit, accel, gyro, id)
        .run();
  return id;
}

std::int64_t FleetStore::session_id(const FleetSession& session, std::int64_t unit, const FleetOccasion& o) {
  Statement find(database_, "SELECT id FROM sessions WHERE hash = ?");
  if (find.with(session.hash).next()) return find.integer(0);
  const std::int64_t id = Statement(database_,
                                    "INSERT INTO sessions (unit, hash, file, sha256, operator, station, time, time_from, added) VALUES (?, ?, ?, ?, "
                                    "?, ?, ?, ?, ?) RETURNING id")
                              .with(unit, session.hash, session.file, session.sha256, o.operated_by, o.station, o.time, o.time_from, fleet::now())
                              .run_for_id();
  Statement file(database_, "INSERT INTO files (session, name, sha256, bytes) VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING");
  for (const SourceFile& source : session.files) file.with(id, source.file, source.sha256, static_cast<std::int64_t>(source.bytes)).run();
  return id;
}

bool FleetStore::add_session(const FleetSession& session, const std::string& serial, const std::string& name, const FleetOccasion& occasion) {
  if (serial.empty() && name.empty()) throw Error("names no unit; expected a serial number or a name");
  Transaction transaction(database_);
  Statement find(database_, "SELECT 1 FROM sessions WHERE hash = ?");
  if (find.with(session.hash).next()) return false;
  find.reset();
  std::int64_t unit = unit_named(serial, name);
  if (unit == 0)
    unit = Statement(database_,
                     "INSERT INTO units (serial, name, accel_unit, gyro_unit, accel_scale, gyro_scale, added) VALUES (?, ?, '', '', 0, 0, ?) "
                     "RETURNING id")
               .with(serial, name, fleet::now())
               .run_for_id();
  session_id(session, unit, occasion);
  transaction.commit();
  return true;
}

bool FleetStore::add_calibration(const Calibration& c, const FleetOccasion& o, const FleetSession* session, const FleetRequest* request) {
  if (c.options.contains("prior")) throw Error("was calibrated with a fleet's prior, which would count twice; expected a calibration without");
  const fleet::Numbers numbers = fleet::numbers_of(c);
  const std::string text = calibration_text(c);
  const std::string key = session != nullptr && request != nullptr ? key_of(*session, *request) : sha256("file\n" + text);
  std::string options;
  for (const auto& [name, value] : c.options) options += fmt::format("{}{}={}", options.empty() ? "" : " ", name, value);
  Transaction transaction(database_);
  {
    Statement find(database_, "SELECT 1 FROM calibrations WHERE key = ?");
    if (find.with(key).next()) return false;  // another program was faster
  }
  const std::int64_t unit = unit_of(c);
  std::optional<std::int64_t> of_session;
  if (session != nullptr) of_session = session_id(*session, unit, o);
  Statement row(database_,
                "INSERT INTO calibrations (key, unit, session, method, options, operator, station, time, time_from, created, software, verdict, "
                "added) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING id");
  row.with(key, unit, of_session, c.method, request != nullptr ? request->options : options, o.operated_by, o.station, o.time, o.time_from, c.created,
           c.software, std::string(to_string(c.quality.verdict)), fleet::now());
  add_numbers(database_, row.run_for_id(), numbers, text);
  if (session != nullptr && request != nullptr)
    Statement(database_, "DELETE FROM failures WHERE key = ?").with(failure_key(*session, *request)).run();
  transaction.commit();
  return true;
}

bool FleetStore::add_noise(const std::string& text, const std::string& serial, const std::string& name, const FleetOccasion& o) {
  Transaction transaction(database_);
  const std::int64_t unit = unit_named(serial, name);
  if (unit == 0)
    throw Error(fmt::format("{} is not in the store; expected a calibration of the unit before its noise", serial.empty() ? name : serial));
  Statement(database_,
            "INSERT INTO noises (sha256, unit, operator, station, time, time_from, added, text) VALUES (?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO "
            "NOTHING")
      .with(sha256(text), unit, o.operated_by, o.station, o.time, o.time_from, fleet::now(), text)
      .run();
  const bool added = database_.changes() > 0;
  transaction.commit();
  return added;
}

void FleetStore::add_failure(const FleetSession& session, const FleetRequest& request, const std::string& message) {
  Transaction transaction(database_);
  Statement(database_,
            "INSERT INTO failures (key, file, hash, method, options, message, added) VALUES (?, ?, ?, ?, ?, ?, ?) ON CONFLICT (key) DO UPDATE SET "
            "file = excluded.file, hash = excluded.hash, method = excluded.method, options = excluded.options, message = excluded.message, "
            "added = excluded.added")
      .with(failure_key(session, request), session.file, session.hash, request.method, request.options, message, fleet::now())
      .run();
  transaction.commit();
}

std::int64_t FleetStore::remove(const std::vector<std::int64_t>& calibrations, const std::string& reason) {
  Transaction transaction(database_);
  Statement mark(database_, "UPDATE calibrations SET removed = ?, reason = ? WHERE id = ? AND removed IS NULL");
  std::int64_t removed = 0;
  for (const std::int64_t id : calibrations) {
    mark.with(fleet::now(), reason, id).run();
    removed += database_.changes();
  }
  transaction.commit();
  return removed;
}

namespace fleet {

double now() {
  return 1e-3 *
         static_cast<double>(std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::system_clock::now().time_since_epoch()).count());
}

}  // namespace fleet

namespace {

using fleet::Statement;

}  // namespace

std::vector<FleetUnit> FleetStore::units() { return units_where("", ""); }

std::vector<FleetUnit> FleetStore::units_where(const std::string& condition, const std::string& name) {
  Statement rows(database_,
                 "SELECT u.id, u.serial, u.name, (SELECT COUNT(*) FROM calibrations f WHERE f.unit = u.id AND f.removed IS NULL), "
                 "(SELECT MIN(f.time) FROM calibrations f WHERE f.unit = u.id AND f.removed IS NULL), l.time, l.verdict, l.method, l.station, "
                 "(SELECT COUNT(*) FROM noises n WHERE n.unit = u.id) FROM units u LEFT JOIN calibrations l ON l.id = (SELECT c.id FROM calibrations "
                 "c WHERE c.unit = u.id AND c.removed IS NULL ORDER BY c.time DESC, c.id DESC LIMIT 1) " +
                     condition + " ORDER BY u.serial, u.name");
  if (!condition.empty()) rows.with(name);
  std::vector<FleetUnit> out;
  while (rows.next())
    out.push_back({rows.integer(0), rows.text(1), rows.text(2), rows.integer(3), rows.integer(9), rows.real(4), rows.real(5), rows.text(6),
                   rows.text(7), rows.text(8)});
  return out;
}

FleetUnit FleetStore::unit(const std::string& name) {
  const std::vector<FleetUnit> found = units_where("WHERE ?1 IN (u.serial, u.name)", name);
  if (found.empty()) throw Error(fmt::format("{}: has no unit {}; expected a serial number or a name of imulab fleet list", database_.file(), name));
  for (const FleetUnit& u : found)
    if (u.serial == name) return u;
  if (found.size() > 1) throw Error(fmt::format("{}: {} units are named {}; expected a serial number", database_.file(), found.size(), name));
  return found.front();
}

std::vector<FleetRecord> FleetStore::records(std::int64_t unit, bool with_removed) {
  Statement rows(database_,
                 fmt::format("SELECT c.id, u.id, u.serial, u.name, c.method, c.options, c.created, c.software, c.verdict, s.file, c.station, "
                             "c.operator, c.time, c.time_from, c.added, c.removed, c.reason FROM calibrations c JOIN units u ON u.id = c.unit "
                             "LEFT JOIN sessions s ON s.id = c.session WHERE {} {} ORDER BY c.time, c.id",
                             unit != 0 ? fmt::format("c.unit = {}", unit) : "TRUE", with_removed ? "" : "AND c.removed IS NULL"));
  std::vector<FleetRecord> out;
  while (rows.next()) {
    FleetRecord r{rows.integer(0),
                  rows.integer(1),
                  rows.text(2),
                  rows.text(3),
                  rows.text(4),
                  rows.text(5),
                  rows.text(6),
                  rows.text(7),
                  rows.text(8),
                  rows.text(9),
                  {},
                  0,
                  {},
                  ""};
    r.occasion = {rows.text(10), rows.text(11), rows.real(12), rows.text(13)};
    r.added = rows.real(14);
    if (!rows.is_null(15)) r.removed = rows.real(15);
    r.reason = rows.text(16);
    out.push_back(std::move(r));
  }
  return out;
}

std::vector<FleetFailure> FleetStore::failures() {
  Statement rows(database_, "SELECT file, method, options, message, added FROM failures ORDER BY file, method, options");
  std::vector<FleetFailure> out;
  while (rows.next()) out.push_back({rows.text(0), rows.text(1), rows.text(2), rows.text(3), rows.real(4)});
  return out;
}

std::vector<std::string> FleetStore::clock_problems() {
  constexpr double tolerance = 60;  // s, between the clocks of two machines that are set by a network
  const auto found = [&](const std::string& what, const std::string& query) -> std::vector<std::string> {
    Statement rows(database_, fmt::format("SELECT COUNT(*), MIN(id), MAX(late) FROM ({}) AS each_one WHERE late > {}", query, tolerance));
    if (!rows.next() || rows.integer(0) == 0) return {};
    return {fmt::format(fmt::runtime(what), rows.integer(0), rows.integer(1), rows.real(2))};
  };
  std::vector<std::string> out = found(
      "{} calibrations, the first of them number {}, were added up to {:.0f} s before the one ahead of them: a clock was set back, and their times "
      "may be wrong",
      "SELECT id, LAG(added) OVER (ORDER BY id) - added AS late FROM calibrations");
  for (std::string& text :
       found("{} calibrations, the first of them number {}, were measured up to {:.0f} s after they were added: a clock was wrong, and so are "
             "drifts of their units",
             "SELECT id, time - added AS late FROM calibrations WHERE removed IS NULL"))
    out.push_back(std::move(text));
  return out;
}

std::string FleetStore::calibration_file(std::int64_t calibration) {
  Statement row(database_, "SELECT deflated, bytes FROM texts WHERE calibration = ?");
  if (!row.with(calibration).next()) throw Error(fmt::format("{}: has no calibration {}", database_.file(), calibration));
  return errors_at(fmt::format("{}: calibration {}", database_.file(), calibration),
                   [&] { return fleet::inflated(row.bytes(0), static_cast<std::size_t>(std::max<std::int64_t>(0, row.integer(1)))); });
}

}  // namespace imulab
