// imulab fleet add|calibrate|list|show|stats|check|merge|export|remove
#include "imulab/tasks/fleet.hpp"

#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/stated.hpp"
#include "imulab/fleet/statistics/statistics.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/fleet/store/server.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/report/calibration_page.hpp"
#include "imulab/report/html.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/tasks/calibrate.hpp"
#include "imulab/tasks/fleet_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>

namespace imulab::command {

using fleet::Access;
namespace fs = std::filesystem;

namespace {

struct Options {
  std::string store = "fleet.db", method, terms = "auto", unit;
  std::vector<std::string> files;
  FleetDeclaration declared;
  bool json = false, retry = false, failures = false;
  std::string part;
};

void add_declared(Verb& verb, FleetDeclaration& declared) {
  verb.option("--station NAME", declared.station, "where it was measured; takes precedence over the session's station");
  verb.option("--operator NAME", declared.operated_by, "who measured; the session's operator takes precedence");
  verb.option("--measured TIME", declared.time, "when it was measured (UTC, 2026-03-31T12:00:00Z), instead of the session's time or the stamps");
}

void add(const Options& o) {
  FleetStore store(o.store, Access::write);
  std::vector<std::string> wrong;
  std::vector<JsonFields> added;
  for (const std::string& file : o.files) try {
      const std::string what = add_to_fleet(file, o.unit, o.declared, store);
      added.push_back({{{"file", file}, {"added", what}}});
      if (!o.json) print(fmt::format("{}: {}\n", one_line(file), what));
    } catch (const Error& e) {
      wrong.emplace_back(e.what());
    }
  if (o.json)
    print_json({{{"files", added}, {"errors", wrong}}},
               {Verdict::none, fmt::format("{} added, {} refused", text::plural(added.size(), "file"), wrong.size())});
  warn_each(store.clock_problems());
  if (!wrong.empty()) throw Error(fmt::format("{}", fmt::join(wrong, "\n")));
}

void add_add(Verb& fleet) {
  const auto o = std::make_shared<Options>();
  Verb& verb = fleet.verb("add", "Add calibrations, sessions or noise");
  verb.option("FILE", o->files, "calibration.json, a session's folder, or noise.json").required().takes_several(1);
  store_option(verb, o->store);
  add_declared(verb, o->declared);
  verb.option("--unit SERIAL", o->unit, "the IMU of a noise.json: its serial number, or its name");
  verb.option("--json", o->json, "print what was added as JSON");
  verb.example("imulab fleet add calibration.json --store fleet.db --station 2");
  verb.does = [o] { add(*o); };
}

/// Its further lines are no rows of a list.
std::string indented(const std::string& message) {
  std::string out;
  for (const char c : message) out += c == '\n' ? std::string("\n  ") : std::string(1, c);
  return out;
}

std::vector<JsonFields> failures_json(const std::vector<FleetFailure>& failures) {
  std::vector<JsonFields> out;
  for (const FleetFailure& f : failures)
    out.push_back({{{"file", f.file}, {"method", f.method}, {"options", f.options}, {"message", f.message}, {"added", time_text(f.added)}}});
  return out;
}

void calibrate_all(const Options& o) {
  parse_terms(o.terms);
  const std::vector<std::filesystem::path> sessions = sessions_below({o.files.begin(), o.files.end()});
  std::optional<PartNumber> part;
  if (!o.part.empty()) part = errors_of_option("part", [&] { return part_named(o.part); });
  fs::path place = o.store;
  if (part && o.part.starts_with("auto")) {
    will_fill("--store", place);
    fs::create_directories(place);
    place /= PartWriter(*part, "").name() + ".db";
  }
  FleetStore store(place, Access::write);
  FleetCalibrationTask task{.method = o.method, .terms = o.terms, .declared = o.declared, .retry = o.retry};
  task.part = part;
  FleetCalibrationCounts n;
  {
    Progress progress("calibrating", static_cast<double>(sessions.size()));
    task.progress = [&](double done, double) { progress.report(done); };
    n = calibrate_fleet(sessions, task, store);
  }
  for (const FleetFailure& f : n.failures) warn(fmt::format("{}: {}: the store has no calibration of it", one_line(f.file), indented(f.message)));
  warn_each(store.clock_problems());
  const auto counted = [](std::int64_t k) { return static_cast<std::uint64_t>(k); };
  if (o.json)
    print_json({{{"sessions", counted(n.sessions)},
                 {"calibrated", counted(n.calibrated)},
                 {"skipped", counted(n.skipped)},
                 {"failed", counted(n.failed)},
                 {"failed_before", counted(n.failed_before)},
                 {"failures", failures_json(n.failures)}}},
               {Verdict::none, fmt::format("{}: {} calibrated, {} in the store before, {} failed", text::plural(n.sessions, "session"), n.calibrated,
                                           n.skipped, n.failed)});
  else
    print(fmt::format("{}: {} calibrated, {} in the store before, {} failed{}\n", text::plural(n.sessions, "session"), n.calibrated, n.skipped,
                      n.failed, n.failed_before > 0 ? fmt::format(", {} failed before (--retry tries them again)", n.failed_before) : ""));
  if (n.failed + n.failed_before > 0)
    throw Unsupported(
        fmt::format("{} of {} sessions are not calibrated: imulab fleet list --failures names them", n.failed + n.failed_before, n.sessions));
}

void add_calibrate_all(Verb& fleet) {
  const auto o = std::make_shared<Options>();
  Verb& verb = fleet.verb("calibrate", "Calibrate all sessions below folders, each once");
  verb.option("DIR", o->files, "folders with sessions in them or below them").required().takes_several(1);
  verb.option("--method METHOD", o->method, "as for imulab calibrate").required().one_of(offered_methods([](const Method& m) {
    return !m.takes_reference;
  }));
  verb.option("--terms TERMS", o->terms, "as for imulab calibrate").show_default();
  store_option(verb, o->store);
  add_declared(verb, o->declared);
  verb.option("--part K/N", o->part,
              "do only the K-th of N parts of the sessions, into a store of its own for imulab fleet merge; auto: K and N from Slurm, mpirun or "
              "Kubernetes; --store is then a folder");
  verb.option("--retry", o->retry, "also calibrate sessions that failed before");
  verb.option("--json", o->json, "print the counts as JSON");
  verb.example("imulab fleet calibrate week-12 --method handheld --store fleet.db --station 2");
  verb.does = [o, &verb] {
    if (!o->part.empty() && (!verb.at("--store").given || fleet::is_server(o->store)))
      throw OptionError("part", o->part + "; expected --store with a file of its own, which imulab fleet merge adds to any store");
    calibrate_all(*o);
  };
}

void list_failures(const Options& o, FleetStore& store) {
  const std::vector<FleetFailure> failures = store.failures();
  if (o.json)
    return print_json({{{"failures", failures_json(failures)}}}, {Verdict::none, fmt::format("{} failed", text::plural(failures.size(), "session"))});
  std::string text;
  for (const FleetFailure& f : failures)
    text += fmt::format("{} ({} {}): {}\n", one_line(f.file), one_line(f.method), one_line(f.options), indented(f.message));
  print(text.empty() ? "no session has failed\n" : text);
}

void list(const Options& o) {
  FleetStore store(o.store);
  if (o.failures) return list_failures(o, store);
  const std::vector<FleetUnit> units = store.units();
  if (o.json) {
    std::vector<JsonFields> rows;
    rows.reserve(units.size());
    for (const FleetUnit& u : units)
      rows.push_back({{{"serial", u.serial},
                       {"name", u.name},
                       {"calibrations", static_cast<std::uint64_t>(u.calibrations)},
                       {"noises", static_cast<std::uint64_t>(u.noises)},
                       {"first", u.calibrations > 0 ? time_text(u.first) : ""},
                       {"last", u.calibrations > 0 ? time_text(u.last) : ""},
                       {"method", u.method},
                       {"verdict", u.verdict},
                       {"station", u.station}}});
    return print_json({{{"units", rows}}}, {Verdict::none, text::plural(rows.size(), "unit")});
  }
  std::size_t serial = 6, name = 4;
  std::vector<std::pair<std::string, std::string>> shown;
  for (const FleetUnit& u : units) {
    shown.emplace_back(one_line(u.serial), one_line(u.name));
    serial = std::max(serial, shown.back().first.size()), name = std::max(name, std::min<std::size_t>(shown.back().second.size(), 30));
  }
  std::string text = fmt::format("{:<{}}  {:<{}}  calibrations  last                  verdict   station\n", "serial", serial, "name", name);
  for (std::size_t k = 0; k < units.size(); ++k)
    text += fmt::format("{:<{}}  {:<{}}  {:>12}  {:<20}  {:<8}  {}\n", shown[k].first, serial, shown[k].second, name, units[k].calibrations,
                        units[k].calibrations > 0 ? time_text(units[k].last) : "-", one_line(units[k].verdict), one_line(units[k].station));
  const std::size_t failed = store.failures().size();
  print(text + fmt::format("{}{}\n", text::plural(units.size(), "unit"),
                           failed > 0 ? fmt::format("; {} failed (--failures)", text::plural(failed, "session")) : ""));
}

void add_list(Verb& fleet) {
  const auto o = std::make_shared<Options>();
  Verb& verb = fleet.verb("list", "List the units, or the sessions that failed");
  store_option(verb, o->store);
  verb.option("--failures", o->failures, "list the sessions that failed, with their messages");
  verb.option("--json", o->json, "print the list as JSON");
  verb.example("imulab fleet list --store fleet.db");
  verb.does = [o] { list(*o); };
}

void show(const Options& o) {
  FleetStore store(o.store);
  const FleetUnit unit = store.unit(o.unit);
  const std::vector<FleetRecord> records = store.records(unit.id, true);
  std::vector<JsonFields> rows;
  std::string text = fmt::format("{} {}: {}\n", one_line(unit.name), one_line(unit.serial), text::plural(unit.calibrations, "calibration"));
  for (const FleetRecord& r : records) {
    rows.push_back({{{"calibration", static_cast<std::uint64_t>(r.id)},
                     {"time", time_text(r.occasion.time)},
                     {"time_from", r.occasion.time_from},
                     {"station", r.occasion.station},
                     {"operator", r.occasion.operated_by},
                     {"method", r.method},
                     {"options", r.options},
                     {"verdict", r.verdict},
                     {"created", r.created},
                     {"software", r.software},
                     {"session", r.session_file},
                     {"added", time_text(r.added)},
                     {"removed", r.removed ? time_text(*r.removed) : ""},
                     {"reason", r.reason}}});
    text += one_line(fmt::format("  {:>6}  {} ({})  {} {}  {}{}{}{}", r.id, time_text(r.occasion.time), r.occasion.time_from, r.method, r.options,
                                 r.verdict, r.occasion.station.empty() ? "" : "  station " + r.occasion.station,
                                 r.occasion.operated_by.empty() ? "" : "  by " + r.occasion.operated_by,
                                 r.removed ? fmt::format("  removed {}{}", time_text(*r.removed), r.reason.empty() ? "" : ": " + r.reason) : "")) +
            "\n";
  }
  if (!o.json) return print(text);
  print_json({{{"serial", unit.serial}, {"name", unit.name}, {"calibrations", rows}}}, {Verdict::none, text::plural(rows.size(), "calibration")});
}

void add_show(Verb& fleet) {
  const auto o = std::make_shared<Options>();
  Verb& verb = fleet.verb("show", "Show a unit's calibrations, the removed ones too");
  verb.option("UNIT", o->unit, "the IMU's serial number, or its name").required();
  store_option(verb, o->store);
  verb.option("--json", o->json, "print them as JSON");
  verb.example("imulab fleet show 012 --store fleet.db");
  verb.does = [o] { show(*o); };
}

// ---- stats

struct StatsOptions {
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

UnitPages unit_pages(FleetStore& store, const FleetStatistics& f, const StatsOptions& o) {
  const fs::path folder = o.pages, base = fs::absolute(o.report).parent_path();
  std::map<Eigen::Index, std::int64_t> last;
  for (const Eigen::Index row : f.sample.last)
    last[f.sample.unit[static_cast<std::size_t>(row)]] = f.sample.calibration[static_cast<std::size_t>(row)];
  UnitPages pages{{}, std::vector<std::string>(f.sample.units.size())};
  for (const Eigen::Index unit : units_on_page(f)) {
    const std::int64_t id = last.at(unit);
    const std::string file = fmt::format("calibration-{}.html", id);
    CalibrationReport report;
    report.result.calibration = parse_calibration(store.calibration_file(id), fmt::format("{}: calibration {}", store.database().file(), id));
    report.missing.emplace_back("The recording, gravity and rotations: a store keeps the calibration alone.");
    pages.files.emplace_back(file, calibration_page(report));
    pages.links[static_cast<std::size_t>(unit)] = report::relative_url(fs::absolute(folder / file).lexically_proximate(base).generic_string());
  }
  return pages;
}

void stats(const StatsOptions& o) {
  FleetOptions options{.false_alarm = o.false_alarm};
  if (o.require) options.requirements = errors_at("--require", [&] { return parse_requirements(*o.require); });
  if (o.due) options.errors = errors_at("--due", [&] { return parse_requirements(*o.due); });
  if (!o.pages.empty() && o.report.empty()) throw Error("--unit-pages: belongs to --report, whose page links them");
  if (!o.pages.empty()) will_create("--unit-pages", o.pages);
  will_read(o.store);
  FleetStore store(o.store);
  const FleetStatistics statistics = fleet_statistics(store, options, o.method);
  warn_each(store.clock_problems());
  if (o.due && statistics.due.empty()) warn("--due: no unit was calibrated twice: how units drift is not known");
  const UnitPages pages = o.pages.empty() ? UnitPages{} : unit_pages(store, statistics, o);
  if (!pages.files.empty()) {
    NewFolder folder(o.pages);
    for (const auto& [file, text] : pages.files) write_whole(folder.path() / file, text);
    folder.commit();
  }
  if (!o.report.empty()) write_whole(o.report, fleet_page(statistics, store.database().file(), pages.links));
  if (o.json)
    print_json(Answer{.json = [&] { return fleet_statistics_json(statistics); }, .table = [&](bool) { return fleet_statistics_text(statistics); }}
                   .document());
  else
    print(fleet_statistics_text(statistics));
}

void add_stats(Verb& fleet) {
  const auto o = std::make_shared<StatsOptions>();
  Verb& verb = fleet.verb("stats", "Spread, outliers, drift and stations of the units");
  store_option(verb, o->store);
  verb.option("--method METHOD", o->method, "use only calibrations by this method").one_of(offered_methods());
  verb.option("--require LIMITS", o->require, "limits for the values, as in \"accel.bias <= 5 mg\": capability Cp and Cpk");
  verb.option("--due LIMITS", o->due, "largest accepted errors, as in \"accel.bias <= 2 mg\": recalibration due date of each IMU");
  verb.option("--false-alarm P", o->false_alarm, "probability of a false outlier in the fleet").in_range(1e-9, 0.5).show_default();
  report_option(verb, o->report);
  verb.option("--unit-pages DIR", o->pages, "a folder for pages of the IMUs that the report names, with links to them");
  verb.option("--json", o->json, "print the statistics as JSON");
  verb.example("imulab fleet stats --store fleet.db --require \"accel.bias <= 50 mg\"");
  verb.does = [o] { stats(*o); };
}

}  // namespace

void add_fleet(Verb& app) {
  Verb& fleet = app.verb("fleet", "Keep the calibrations of many units in one store, and see how they spread, drift and differ");
  fleet.example("imulab fleet calibrate week-12 --method handheld --store fleet.db");
  add_add(fleet);
  add_calibrate_all(fleet);
  add_list(fleet);
  add_show(fleet);
  add_stats(fleet);
  add_fleet_upkeep(fleet);
}

}  // namespace imulab::command
