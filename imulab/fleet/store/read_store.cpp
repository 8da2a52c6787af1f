#include "imulab/core/error.hpp"
#include "imulab/fleet/store/numbers.hpp"
#include "imulab/fleet/store/store.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/format.h>

#include <chrono>

namespace imulab {

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
                 "SELECT u.id, u.serial, u.name, COUNT(c.id), (SELECT MIN(time) FROM calibrations f WHERE f.unit = u.id AND f.removed IS NULL), "
                 "MAX(c.time), c.verdict, c.method, c.station, "  // c: of the maximum
                 "(SELECT COUNT(*) FROM noises n WHERE n.unit = u.id) FROM units u LEFT JOIN calibrations c ON c.unit = u.id AND c.removed IS NULL " +
                     condition + " GROUP BY u.id ORDER BY u.serial, u.name");
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
                             unit != 0 ? fmt::format("c.unit = {}", unit) : "1", with_removed ? "" : "AND c.removed IS NULL"));
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
    Statement rows(database_, fmt::format("SELECT COUNT(*), MIN(id), MAX(by) FROM ({}) WHERE by > {}", query, tolerance));
    if (!rows.next() || rows.integer(0) == 0) return {};
    return {fmt::format(fmt::runtime(what), rows.integer(0), rows.integer(1), rows.real(2))};
  };
  std::vector<std::string> out = found(
      "{} calibrations, the first of them number {}, were added up to {:.0f} s before the one ahead of them: a clock was set back, and their times "
      "may be wrong",
      "SELECT id, LAG(added) OVER (ORDER BY id) - added AS by FROM calibrations");
  for (std::string& text :
       found("{} calibrations, the first of them number {}, were measured up to {:.0f} s after they were added: a clock was wrong, and so are "
             "drifts of their units",
             "SELECT id, time - added AS by FROM calibrations WHERE removed IS NULL"))
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
