// imulab fleet check|merge|export|remove
#include "apps/imulab/command.hpp"
#include "apps/imulab/files.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/fleet/store/part.hpp"
#include "imulab/fleet/store/sample.hpp"
#include "imulab/fleet/store/server.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/terminal.hpp"

#include <fmt/format.h>

#include <charconv>
#include <memory>

namespace imulab::command {

namespace {

using fleet::Access;

struct Options {
  std::string store = "fleet.db", output, unit, reason;
  std::string calibration;
  std::vector<std::string> others;
  bool json = false, csv = false;
};

void check(const Options& o) {
  FleetStore store(o.store);
  FleetStore::Checked c;
  {
    Progress progress("checking");
    c = store.check([&](double part) { progress.report(part); });
  }
  const std::vector<std::string> clocks = store.clock_problems();
  warn_each(clocks);
  if (o.json)
    print_json(
        {{{"damaged", c.damaged},
          {"changed", c.changed},
          {"files", static_cast<std::uint64_t>(c.files)},
          {"missing", static_cast<std::uint64_t>(c.missing)},
          {"clocks", clocks}}},
        {c.damaged.empty() && c.changed.empty() ? Verdict::good : Verdict::doubtful,
         fmt::format("{}; {} changed, {} missing", text::plural(c.damaged.size(), "damage"), text::plural(c.changed.size(), "file"), c.missing)});
  else
    print(text::wrapped("", fmt::format("{}: {}; of {} files of its sessions {} are unchanged, {} changed and {} are missing",
                                        store.database().file(), c.damaged.empty() ? "whole" : text::plural(c.damaged.size(), "damage"), c.files,
                                        c.files - c.missing - static_cast<std::int64_t>(c.changed.size()), c.changed.size(), c.missing)));
  if (!c.damaged.empty()) throw Error(fmt::format("{}: {}; expected a whole fleet store", store.database().file(), fmt::join(c.damaged, "; ")));
  if (!c.changed.empty()) throw Unsupported(fmt::format("{}: not what was calibrated: {}", store.database().file(), fmt::join(c.changed, ", ")));
}

void merge(const Options& o) {
  const std::vector<std::filesystem::path> others = fleet::all_parts({o.others.begin(), o.others.end()});
  FleetStore store(o.store, Access::write);
  fleet::expect_no_part(store);
  std::int64_t added = 0;
  for (const std::filesystem::path& other : others) added += store.merge(other);
  if (o.json)
    return print_json({{{"calibrations", static_cast<std::uint64_t>(added)}}},
                      {Verdict::none, fmt::format("{} added", text::plural(static_cast<std::size_t>(added), "calibration"))});
  print(fmt::format("{}: {} added from {}\n", one_line(store.database().file()), text::plural(static_cast<std::size_t>(added), "calibration"),
                    o.others.size() == 1 ? one_line(fleet::shown_store(o.others.front())) : text::plural(o.others.size(), "store")));
  if (const std::size_t failed = store.failures().size(); failed > 0)
    note(fmt::format("{} of the store without a calibration: imulab fleet list --failures names them", text::plural(failed, "session")));
}

std::int64_t calibration_number(const std::string& text) {
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size() || id < 1)
    throw Error(fmt::format("--calibration {}: is no number; expected one of imulab fleet show", text));
  return id;
}

void export_it(const Options& o) {
  if (o.csv == !o.calibration.empty()) throw Error("expected --csv, for all calibrations, or --calibration N, for the file of one");
  will_read(o.store);
  FleetStore store(o.store);
  const std::string text = o.csv ? fleet::fleet_csv(store) : store.calibration_file(calibration_number(o.calibration));
  if (o.output.empty() || o.output == "-") return print_json(text);
  write_whole(o.output, text);
}

void remove(const Options& o) {
  if (o.unit.empty() == o.calibration.empty()) throw Error("expected a unit, or --calibration N");
  FleetStore store(o.store, Access::write);
  std::vector<std::int64_t> ids;
  if (!o.calibration.empty())
    ids.push_back(calibration_number(o.calibration));
  else
    for (const FleetRecord& r : store.records(store.unit(o.unit).id)) ids.push_back(r.id);
  const std::int64_t removed = store.remove(ids, o.reason);
  if (removed == 0) throw Error(fmt::format("{}: has no such calibration that is not removed yet", store.database().file()));
  if (o.json)
    return print_json({{{"removed", static_cast<std::uint64_t>(removed)}}},
                      {Verdict::none, fmt::format("{} removed", text::plural(static_cast<std::size_t>(removed), "calibration"))});
  print(fmt::format("{}: {} removed, kept in the store as history\n", store.database().file(),
                    text::plural(static_cast<std::size_t>(removed), "calibration")));
}

/// A verb that does `work` with the store of these options.
Verb& upkeep(Verb& fleet, const char* name, const char* summary, const std::shared_ptr<Options>& o, void (*work)(const Options&)) {
  Verb& verb = fleet.verb(name, summary);
  store_option(verb, o->store);
  verb.does = [o, work] { work(*o); };
  return verb;
}

}  // namespace

void add_fleet_upkeep(Verb& fleet) {
  const auto checked = std::make_shared<Options>(), merged = std::make_shared<Options>(), exported = std::make_shared<Options>(),
             removed = std::make_shared<Options>();
  Verb& checking = upkeep(fleet, "check", "Check store integrity, and that the files of its sessions are unchanged", checked, check);
  json_option(checking, checked->json);
  checking.example("imulab fleet check --store fleet.db");

  Verb& merging = upkeep(fleet, "merge", "Add what other stores have: of other stations, or of all parts of a fleet", merged, merge);
  merging.option("OTHER", merged->others, "the other stores, which stay as they are").required().takes_several(1);
  json_option(merging, merged->json, "print the count as JSON");
  merging.example("imulab fleet merge station-2.db --store fleet.db");

  Verb& exporting = upkeep(fleet, "export", "Write all calibrations as a table, or the file of one", exported, export_it);
  exporting.option("--csv", exported->csv, "a row for each calibration: coefficients and standard uncertainties in SI");
  exporting.option("--calibration N", exported->calibration, "the file of this calibration");
  exporting.option("-o,--output FILE", exported->output, "the file to write; absent: standard output").writes().keeps_existing();
  exporting.example("imulab fleet export --csv --store fleet.db -o fleet.csv");

  Verb& removing = upkeep(fleet, "remove", "Remove calibrations from lists and statistics; they remain as history", removed, remove);
  removing.option("UNIT", removed->unit, "all calibrations of this IMU: its serial number, or its name");
  removing.option("--calibration N", removed->calibration, "only this calibration");
  removing.option("--reason TEXT", removed->reason, "the reason, which stays in the store");
  json_option(removing, removed->json, "print the count as JSON");
  removing.example("imulab fleet remove --calibration 17 --reason dropped --store fleet.db");
}

}  // namespace imulab::command
