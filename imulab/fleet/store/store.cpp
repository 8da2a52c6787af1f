#include "imulab/fleet/store/store.hpp"

#include "imulab/core/error.hpp"
#include "imulab/fleet/store/numbers.hpp"
#include "imulab/fleet/store/schema.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/format.h>

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

/// Of the diagonal: the geometric mean of its sizes.
double scale_of(const Matrix3d& matrix) { return std::cbrt(std::abs(matrix(0, 0) * matrix(1, 1) * matrix(2, 2))); }

/// The numbers of a calibration beside its row.
void add_numbers(fleet::Database& db, std::int64_t id, const fleet::Numbers& numbers, const std::string& text) {
  const std::string layout = fleet::layout_text(numbers.estimated), data = fleet::packed(numbers), small = fleet::deflated(text);
  Statement(db, "INSERT OR IGNORE INTO layouts (coefficients) VALUES (?)").with(layout).run();
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

FleetStore::FleetStore(const std::filesystem::path& file, fleet::Access access) : database_(file, access) { expect_schema(database_, access); }

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
    Statement(database_, "INSERT INTO units (serial, name, accel_unit, gyro_unit, accel_scale, gyro_scale, added) VALUES (?, ?, ?, ?, ?, ?, ?)")
        .with(c.serial, c.imu, c.model.accel.raw_unit, c.model.gyro.raw_unit, accel, gyro, fleet::now())
        .run();
    return database_.last_id();
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
  Statement(database_,
            "INSERT INTO sessions (unit, hash, file, sha256, operator, station, time, time_from, added) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .with(unit, session.hash, session.file, session.sha256, o.operated_by, o.station, o.time, o.time_from, fleet::now())
      .run();
  const std::int64_t id = database_.last_id();
  Statement file(database_, "INSERT OR IGNORE INTO files (session, name, sha256, bytes) VALUES (?, ?, ?, ?)");
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
  if (unit == 0) {
    Statement(database_, "INSERT INTO units (serial, name, accel_unit, gyro_unit, accel_scale, gyro_scale, added) VALUES (?, ?, '', '', 0, 0, ?)")
        .with(serial, name, fleet::now())
        .run();
    unit = database_.last_id();
  }
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
  Statement(database_,
            "INSERT INTO calibrations (key, unit, session, method, options, operator, station, time, time_from, created, software, verdict, "
            "added) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")
      .with(key, unit, of_session, c.method, request != nullptr ? request->options : options, o.operated_by, o.station, o.time, o.time_from,
            c.created, c.software, c.quality.verdict, fleet::now())
      .run();
  add_numbers(database_, database_.last_id(), numbers, text);
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
  Statement(database_, "INSERT OR IGNORE INTO noises (sha256, unit, operator, station, time, time_from, added, text) VALUES (?, ?, ?, ?, ?, ?, ?, ?)")
      .with(sha256(text), unit, o.operated_by, o.station, o.time, o.time_from, fleet::now(), text)
      .run();
  const bool added = database_.changes() > 0;
  transaction.commit();
  return added;
}

void FleetStore::add_failure(const FleetSession& session, const FleetRequest& request, const std::string& message) {
  Transaction transaction(database_);
  Statement(database_, "INSERT OR REPLACE INTO failures (key, file, hash, method, options, message, added) VALUES (?, ?, ?, ?, ?, ?, ?)")
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

}  // namespace imulab
