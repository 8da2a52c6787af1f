#include "imulab/error.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/fleet/store/sample.hpp"
#include "imulab/formats/text/csv_field.hpp"
#include "imulab/formats/text/decimal.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace imulab::fleet {

namespace {

void each_row(FleetStore& store, const std::string& condition,
              const std::function<void(std::int64_t, const std::vector<CoefficientIndex>&, std::string_view)>& sink) {
  const Layouts layouts = layouts_of(store);
  for (Statement rows(store.database(), "SELECT n.calibration, n.layout, n.data FROM numbers n " + condition); rows.next();)
    sink(rows.integer(0), expect_numbers(store, layouts, rows.integer(0), rows.integer(1), rows.bytes(2)), rows.bytes(2));
}

}  // namespace

Layouts layouts_of(FleetStore& store) {
  Layouts out;
  for (Statement rows(store.database(), "SELECT id, coefficients FROM layouts"); rows.next();)
    out[rows.integer(0)] = errors_at(store.database().file() + ": layout", [&] { return parse_layout(rows.bytes(1)); });
  return out;
}

const std::vector<CoefficientIndex>& expect_numbers(FleetStore& store, const Layouts& layouts, std::int64_t calibration, std::int64_t layout,
                                                    std::string_view data) {
  const auto found = layouts.find(layout);
  if (found == layouts.end() || !is_packed(data, found->second.size()))
    throw Error(
        fmt::format("{}: the numbers of calibration {} are damaged; imulab fleet check names all that is", store.database().file(), calibration));
  return found->second;
}

std::vector<CoefficientIndex> estimated_by_any(FleetStore& store) {
  std::array<bool, coefficient_count> any{};
  for (const auto& [id, layout] : layouts_of(store))
    for (const CoefficientIndex index : layout) any[static_cast<std::size_t>(index)] = true;
  std::vector<CoefficientIndex> out;
  for (const CoefficientIndex index : coefficient_indices())
    if (any[static_cast<std::size_t>(index)]) out.push_back(index);
  return out;
}

void each_numbers(FleetStore& store, const std::function<void(std::int64_t, const std::vector<CoefficientIndex>&, std::string_view)>& sink) {
  each_row(store, "WHERE n.calibration NOT IN (SELECT id FROM calibrations WHERE removed IS NOT NULL) ORDER BY n.calibration", sink);
}

Numbers numbers_of(FleetStore& store, std::int64_t calibration) {
  Numbers out;
  each_row(store, fmt::format("WHERE n.calibration = {}", calibration),
           [&](std::int64_t, const std::vector<CoefficientIndex>& estimated, std::string_view data) { out = unpacked(data, estimated); });
  if (out.estimated.empty()) throw Error(fmt::format("{}: has no calibration {}", store.database().file(), calibration));
  return out;
}

std::string fleet_csv(FleetStore& store) {
  const Snapshot one_state(store.database());
  std::map<std::int64_t, FleetRecord> records;
  for (FleetRecord& r : store.records()) records[r.id] = std::move(r);
  const std::vector<CoefficientIndex> columns = estimated_by_any(store);
  std::string csv = "calibration,serial,name,time,time_from,station,operator,method,options,verdict";
  for (const CoefficientIndex index : columns) csv += fmt::format(",{0},u({0})", coefficient(index).name);
  csv += "\n";
  each_numbers(store, [&](std::int64_t id, const std::vector<CoefficientIndex>& estimated, std::string_view data) {
    const FleetRecord& r = records[id];
    csv += fmt::format("{},{},{}", id, text::csv_field(r.serial), text::csv_field(r.name));
    for (const std::string& field :
         {time_text(r.occasion.time), r.occasion.time_from, r.occasion.station, r.occasion.operated_by, r.method, r.options, r.verdict})
      csv += "," + text::csv_field(field);
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
