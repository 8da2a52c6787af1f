// imulab fleet stats
#include "apps/imulab/command.hpp"
#include "apps/imulab/fleet.hpp"
#include "apps/imulab/report.hpp"
#include "imulab/core/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/fleet/sample.hpp"
#include "imulab/io/result/fleet.hpp"
#include "imulab/io/text/file.hpp"
#include "imulab/report/fleet_page.hpp"

#include <fmt/format.h>

#include <memory>

namespace imulab::command {

namespace {

struct Options {
  std::string store = "fleet.db", method, report;
  std::optional<std::string> require;
  double false_alarm = 0.01;
  bool json = false;
};

void stats(const Options& o) {
  FleetOptions options{.false_alarm = o.false_alarm};
  if (o.require) options.requirements = errors_at("--require", [&] { return parse_requirements(*o.require); });
  FleetStore store(o.store);
  const FleetStatistics statistics = fleet_statistics(store, options, o.method);
  warn_of_clocks(store);
  if (!o.report.empty()) write_whole(o.report, fleet_page(statistics, o.store));
  if (o.json)
    print_json(fleet_statistics_json(statistics));
  else
    print(fleet_statistics_text(statistics));
}

}  // namespace

void add_fleet_stats(Verb& fleet) {
  const auto o = std::make_shared<Options>();
  Verb verb = fleet.verb("stats", "How the units spread, which do not belong, how they drift, and how stations differ");
  add_store_option(verb, o->store);
  std::vector<std::string> names;
  for (const Method& m : methods()) names.emplace_back(m.name);
  verb.option("--method METHOD", o->method, "calibrations by this method alone").one_of(names);
  verb.option("--require LIMITS", o->require, "what the values have to be within, as in \"accel.offset <= 5 mg\": capability Cp and Cpk");
  verb.option("--false-alarm P", o->false_alarm, "probability of any outlier in a fleet without").in_range(1e-9, 0.5).show_default();
  add_report_option(verb, o->report);
  verb.flag("--json", o->json, "print the statistics as JSON");
  verb.example("imulab fleet stats --store fleet.db --require \"accel.offset <= 50 mg\"");
  verb.does([o] { stats(*o); });
}

}  // namespace imulab::command
