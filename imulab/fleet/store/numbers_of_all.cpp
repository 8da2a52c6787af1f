#include "imulab/fleet/store/numbers_of_all.hpp"

#include "imulab/core/error.hpp"
#include "imulab/formats/text/time.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>

namespace imulab::fleet {

namespace {

/// What the rows' layouts mean.
std::map<std::int64_t, std::vector<CoefficientIndex>> layouts_of(Database& db) {
  std::map<std::int64_t, std::vector<CoefficientIndex>> out;
  for (Statement rows(db, "SELECT id, coefficients FROM layouts"); rows.next();)
    out[rows.integer(0)] = errors_at(db.file() + ": layout", [&] { return parse_layout(rows.bytes(1)); });
  return out;
}

void each_row(Database& db, const std::string& condition,
              const std::function<void(std::int64_t, const std::vector<CoefficientIndex>&, std::string_view)>& sink) {
  const auto layouts = layouts_of(db);
  for (Statement rows(db, "SELECT n.calibration, n.layout, n.data FROM numbers n " + condition); rows.next();) {
    const auto layout = layouts.find(rows.integer(1));
    if (layout == layouts.end() || rows.bytes(2).size() != packed_size(layout->second.size()))
      throw Error(fmt::format("{}: the numbers of calibration {} are damaged; imulab fleet check names all that is", db.file(), rows.integer(0)));
    sink(rows.integer(0), layout->second, rows.bytes(2));
  }
}

/// In quotes where it has to be.
std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::vector<CoefficientIndex> estimated_by_any(Database& db) {
  std::array<bool, coefficient_count> any{};
  for (const auto& [id, layout] : layouts_of(db))
    for (const CoefficientIndex index : layout) any[static_cast<std::size_t>(index)] = true;
  std::vector<CoefficientIndex> out;
  for (const CoefficientIndex index : coefficient_indices())
    if (any[static_cast<std::size_t>(index)]) out.push_back(index);
  return out;
}

}  // namespace

void each_numbers(FleetStore& store, const std::function<void(std::int64_t, const std::vector<CoefficientIndex>&, std::string_view)>& sink) {
  each_row(store.database(), "WHERE n.calibration NOT IN (SELECT id FROM calibrations WHERE removed IS NOT NULL) ORDER BY n.calibration", sink);
}

Numbers numbers_of(FleetStore& store, std::int64_t calibration) {
  Numbers out;
  each_row(store.database(), fmt::format("WHERE n.calibration = {}", calibration),
           [&](std::int64_t, const std::vector<CoefficientIndex>& estimated, std::string_view data) { out = unpacked(data, estimated); });
  if (out.estimated.empty()) throw Error(fmt::format("{}: has no calibration {}", store.database().file(), calibration));
  return out;
}

std::string fleet_csv(FleetStore& store) {
  std::map<std::int64_t, FleetRecord> records;
  for (FleetRecord& r : store.records()) records[r.id] = std::move(r);
  const std::vector<CoefficientIndex> columns = estimated_by_any(store.database());
  std::string csv = "calibration,serial,name,time,time_from,station,operator,method,options,verdict";
  for (const CoefficientIndex index : columns) csv += fmt::format(",{0},u({0})", coefficient(index).name);
  csv += "\n";
  each_numbers(store, [&](std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) {
    const FleetRecord& r = records[id];
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{}", id, csv_text(r.serial), csv_text(r.name), time_text(r.occasion.time), r.occasion.time_from,
                       csv_text(r.occasion.station), csv_text(r.occasion.operated_by), csv_text(r.method), csv_text(r.options), csv_text(r.verdict));
    std::array<std::size_t, coefficient_count> place{};
    for (std::size_t i = 0; i < estimated.size(); ++i) place[static_cast<std::size_t>(estimated[i])] = i + 1;
    const std::size_t n = estimated.size();
    for (const CoefficientIndex index : columns) {
      const std::size_t i = place[static_cast<std::size_t>(index)];
      if (i == 0)
        csv += ",,";
      else
        csv += fmt::format(",{},{}", packed_number(data, i - 1), std::sqrt(packed_number(data, n + (i - 1) * i / 2 + i - 1)));
    }
    csv += "\n";
  });
  return csv;
}

}  // namespace imulab::fleet
