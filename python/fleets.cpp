// Fleets: each call opens the store, and closes it again.
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/stated.hpp"
#include "imulab/fleet/store/part.hpp"
#include "imulab/fleet/store/sample.hpp"
#include "imulab/fleet/store/server.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/tasks/fleet.hpp"
#include "imulab/tasks/fleet_page.hpp"

#include "python/module.hpp"
#include <pybind11/stl.h>
#include <utility>

namespace imulab::python {
namespace {

std::vector<std::string> added(const std::string& file, const std::vector<std::string>& files, const std::string& unit, const std::string& station,
                               const std::string& operated_by, const std::string& time) {
  FleetStore store(file, fleet::Access::write);
  std::vector<std::string> what;
  for (const std::string& one : files) what.push_back(add_to_fleet(one, unit, {station, operated_by, time}, store));
  return what;
}

py::dict calibrated_all(const std::string& file, const std::vector<std::string>& places, const std::string& method, const std::string& terms,
                        const std::string& station, const std::string& operated_by, const std::string& time, bool retry, const py::object& progress,
                        const std::string& part) {
  FleetCalibrationTask task{.method = method, .terms = terms, .declared = {station, operated_by, time}, .retry = retry};
  parse_terms(terms);
  if (!part.empty()) task.part = part_named(part);
  const FleetCalibrationCounts n = run(progress, [=](const std::function<void(double)>& report) mutable {
    task.progress = [&](double done, double all) { report(done / all); };
    FleetStore store(file, fleet::Access::write);
    std::optional<ThreadLimit> one;  // there are as many such parts at once as an executor has workers
    if (task.part) one.emplace(1);
    return calibrate_fleet(sessions_below({places.begin(), places.end()}), task, store);
  });
  py::dict out;
  out["sessions"] = n.sessions, out["calibrated"] = n.calibrated, out["skipped"] = n.skipped, out["failed"] = n.failed;
  out["failed_before"] = n.failed_before;
  py::list failures;
  for (const FleetFailure& f : n.failures) failures.append(py::make_tuple(f.file, f.message));
  out["failures"] = failures;
  return out;
}

py::list units_of(const std::string& file) {
  FleetStore store(file);
  py::list out;
  for (const FleetUnit& u : store.units()) {
    py::dict unit;
    unit["serial"] = u.serial, unit["name"] = u.name, unit["calibrations"] = u.calibrations, unit["noises"] = u.noises;
    unit["first"] = u.calibrations > 0 ? time_text(u.first) : "", unit["last"] = u.calibrations > 0 ? time_text(u.last) : "";
    unit["method"] = u.method, unit["verdict"] = u.verdict, unit["station"] = u.station;
    out.append(unit);
  }
  return out;
}

Outcome statistics_of(const std::string& file, const std::string& method, const std::string& require, const std::string& due, double false_alarm) {
  FleetOptions options{.false_alarm = false_alarm};
  if (!require.empty()) options.requirements = parse_requirements(require);
  if (!due.empty()) options.errors = parse_requirements(due);
  return {run(py::none(), [=](const auto&) {
    FleetStore store(file);
    const auto f = std::make_shared<FleetStatistics>(fleet_statistics(store, options, method));
    Answer out{.json = [f] { return fleet_statistics_json(*f); },
               .table = [f](bool) { return fleet_statistics_text(*f); },
               .page = [f, file] { return fleet_page(*f, fleet::shown_store(file)); },
               .warnings = store.clock_problems()};
    if (!due.empty() && f->due.empty()) out.warnings.emplace_back("due: no unit was calibrated twice: how units drift is not known");
    return out;
  })};
}

std::pair<std::vector<std::string>, std::vector<std::string>> checked(const std::string& file) {
  return run(py::none(), [=](const auto&) {
    FleetStore store(file);
    FleetStore::Checked found = store.check();
    return std::pair(std::move(found.damaged), std::move(found.changed));
  });
}

}  // namespace

void bind_fleets(py::module_& module) {
  module.def("fleet_add", &added);
  module.def("fleet_calibrate", &calibrated_all);
  module.def("fleet_units", &units_of);
  module.def("fleet_statistics", &statistics_of);
  module.def("fleet_csv", [](const std::string& file) {
    return run(py::none(), [=](const auto&) {
      FleetStore store(file);
      return fleet::fleet_csv(store);
    });
  });
  module.def("fleet_merge", [](const std::string& file, const std::vector<std::string>& parts) {
    return run(py::none(), [=](const auto&) {
      FleetStore store(file, fleet::Access::write);
      std::int64_t added = 0;
      for (const std::filesystem::path& part : fleet::all_parts({parts.begin(), parts.end()})) added += store.merge(part);
      return added;
    });
  });
  module.def("fleet_check", &checked);
  module.def("shown_store", [](const std::string& store) { return fleet::shown_store(store); });
}

}  // namespace imulab::python
