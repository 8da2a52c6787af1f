// imulab fleet stats
#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "apps/imulab/fleet.hpp"
#include "apps/imulab/report.hpp"
#include "imulab/core/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/fleet/store/sample.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/report/calibration_page.hpp"
#include "imulab/report/fleet_page.hpp"
#include "imulab/report/html.hpp"
#include "imulab/results/fleet.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace imulab::command {

namespace fs = std::filesystem;

namespace {

struct Options {
  std::string store = "fleet.db", method, report, pages;
  std::optional<std::string> require, due;
  double false_alarm = 0.01;
  bool json = false;
};

/// The pages of the units that the fleet's page names, each of its last calibration.
struct UnitPages {
  std::vector<std::pair<std::string, std::string>> files;  ///< name and text
  std::vector<std::string> links;                          ///< by unit, from the fleet's page
};

UnitPages unit_pages(FleetStore& store, const FleetStatistics& f, const Options& o) {
  const fs::path folder = o.pages, base = fs::absolute(o.report).parent_path();
  std::map<Eigen::Index, std::int64_t> last;
  for (const Eigen::Index row : f.sample.last)
    last[f.sample.unit[static_cast<std::size_t>(row)]] = f.sample.calibration[static_cast<std::size_t>(row)];
  UnitPages pages{{}, std::vector<std::string>(f.sample.units.size())};
  for (const Eigen::Index unit : units_on_page(f)) {
    const std::int64_t id = last.at(unit);
    const std::string file = fmt::format("calibration-{}.html", id);
    CalibrationReport report;
    report.result.calibration = parse_calibration(store.calibration_file(id), fmt::format("{}: calibration {}", o.store, id));
    report.missing.emplace_back("The recording, gravity and rotations: a store keeps the calibration alone.");
    pages.files.emplace_back(file, calibration_page(report));
    pages.links[static_cast<std::size_t>(unit)] = report::relative_url(fs::absolute(folder / file).lexically_proximate(base).generic_string());
  }
  return pages;
}

void stats(const Options& o) {
  FleetOptions options{.false_alarm = o.false_alarm};
  if (o.require) options.requirements = errors_at("--require", [&] { return parse_requirements(*o.require); });
  if (o.due) options.errors = errors_at("--due", [&] { return parse_requirements(*o.due); });
  if (!o.pages.empty() && o.report.empty()) throw Error("--unit-pages: belongs to --report, whose page links them");
  if (!o.pages.empty()) will_create("--unit-pages", o.pages);
  will_read(o.store);
  FleetStore store(o.store);
  const FleetStatistics statistics = fleet_statistics(store, options, o.method);
  warn_of_clocks(store);
  if (o.due && statistics.due.empty()) warn("--due: no unit was calibrated twice: how units drift is not known");
  const UnitPages pages = o.pages.empty() ? UnitPages{} : unit_pages(store, statistics, o);
  if (!pages.files.empty()) {
    NewFolder folder(o.pages);
    for (const auto& [file, text] : pages.files) write_whole(folder.path() / file, text);
    folder.commit();
  }
  if (!o.report.empty()) write_whole(o.report, fleet_page(statistics, o.store, pages.links));
  if (o.json)
    print_json(fleet_statistics_json(statistics));
  else
    print(fleet_statistics_text(statistics));
}

}  // namespace

void add_fleet_stats(Verb& fleet) {
  const auto o = std::make_shared<Options>();
  Verb verb = fleet.verb("stats", "Spread, outliers, drift and stations of the units");
  add_store_option(verb, o->store);
  std::vector<std::string> names;
  for (const Method& m : methods()) names.emplace_back(m.name);
  verb.option("--method METHOD", o->method, "calibrations by this method alone").one_of(names);
  verb.option("--require LIMITS", o->require, "what the values have to be within, as in \"accel.offset <= 5 mg\": capability Cp and Cpk");
  verb.option("--due LIMITS", o->due, "how far a calibration may be off, as in \"accel.offset <= 2 mg\": when each unit is to be calibrated again");
  verb.option("--false-alarm P", o->false_alarm, "probability of any outlier in a fleet without").in_range(1e-9, 0.5).show_default();
  add_report_option(verb, o->report);
  verb.option("--unit-pages DIR", o->pages, "a folder for the pages of the units that the report names, which it links");
  verb.flag("--json", o->json, "print the statistics as JSON");
  verb.example("imulab fleet stats --store fleet.db --require \"accel.offset <= 50 mg\"");
  verb.does([o] { stats(*o); });
}

}  // namespace imulab::command
