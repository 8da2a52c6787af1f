#include "imulab/fleet.hpp"

#include "imulab/files.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/fleet/store/sample.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/fleet_draw.hpp"
#include "tests/run_command.hpp"
#include <cstdlib>
#include <filesystem>
#include <unistd.h>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Sessions of units 1 to N below week/, moved by hand.
struct FleetCommand : ::testing::Test {
  TemporaryFolder folder;

  CommandResult run(const std::string& arguments, int expected = 0) {
    CommandResult result = run_imulab(folder, arguments);
    EXPECT_EQ(result.exit_code, expected) << arguments << "\n" << result.errors;
    return result;
  }
  void simulate(int count) {
    run("procedure handheld -o hand.toml");
    std::filesystem::create_directories(folder / "week");
    for (int k = 1; k <= count; ++k) {
      const std::string n = std::to_string(k);
      run_shell(folder, "sed 's/^name = .*/name = \"unit " + n + "\"\\nserial = \"" + n + "\"/' hand.toml > hand" + n + ".toml");
      run("simulate hand" + n + ".toml --seed " + n + " -o week/unit" + n);
    }
  }
  /// fleet.db with drawn units, calibrated once a year; their x gyros drift by 0.2 deg/s a year.
  void draw(std::uint64_t units, std::uint64_t years) {
    FleetStore store(folder / "fleet.db", fleet::Access::write);
    for (std::uint64_t year = 0; year < years; ++year)
      for (std::uint64_t unit = 0; unit < units; ++unit) {
        Calibration c = drawn_calibration(1, unit, year);
        c.model.gyro.offset.x() += 0.2 * unit::deg * static_cast<double>(year);
        store.add_calibration(c, {"A", "", 1.7e9 + 365.25 * 86400 * static_cast<double>(year), "declared"});
      }
  }
  /// Every number of every unit.
  std::map<std::string, std::string> numbers(const std::string& file) {
    FleetStore store(folder / file);
    std::map<std::string, std::string> out;
    for (const FleetRecord& r : store.records()) out[r.serial] += fleet::packed(fleet::numbers_of(store, r.id));
    return out;
  }
};

TEST_F(FleetCommand, CalibratesEverySessionOnce) {
  simulate(3);
  EXPECT_THAT(run("fleet calibrate week --method handheld --station A").output,
              HasSubstr("3 sessions: 3 calibrated, 0 in the store before, 0 failed"));
  EXPECT_THAT(run("fleet calibrate week --method handheld --station A").output, HasSubstr("0 calibrated, 3 in the store before"));
  EXPECT_THAT(run("fleet stats").output, HasSubstr("gyro.cubic.x, gyro.cubic.y, gyro.cubic.z\n"));  // left out: nothing but their prior
  EXPECT_THAT(run("fleet calibrate week --method static").output, HasSubstr("3 calibrated, 0 in the store before"));
  const auto units = nlohmann::json::parse(run("fleet list --json").output)["units"];
  ASSERT_EQ(units.size(), 3u);
  EXPECT_EQ(units[0]["serial"], "1");
  EXPECT_EQ(units[0]["name"], "unit 1");
  EXPECT_EQ(units[0]["calibrations"], 2);
  const auto shown = nlohmann::json::parse(run("fleet show 2 --json").output)["calibrations"];
  ASSERT_EQ(shown.size(), 2u);
  EXPECT_EQ(shown[0]["method"], "handheld");
  EXPECT_EQ(shown[0]["station"], "A");
  // The store has the calibration that calibrate gives.
  run("calibrate week/unit2 --method handheld -o alone.json");
  run("fleet export --calibration " + std::to_string(shown[0]["calibration"].get<int>()) + " -o stored.json");
  const Calibration alone = read_calibration(folder / "alone.json"), stored = read_calibration(folder / "stored.json");
  EXPECT_EQ(alone.covariance, stored.covariance);
  EXPECT_EQ(alone.model.gyro.matrix, stored.model.gyro.matrix);
  EXPECT_EQ(alone.sources, stored.sources);
  const std::string csv = run("fleet export --csv").output;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7);
  EXPECT_THAT(csv, HasSubstr("accel.offset.x,u(accel.offset.x)"));
  EXPECT_THAT(on_one_line(run("fleet check").output), HasSubstr("fleet.db: whole; of 6 files of its sessions 6 are unchanged"));
  run_shell(folder, "echo '# more' >> week/unit2/recording.csv");
  EXPECT_THAT(run("fleet check", 1).errors, HasSubstr("unit2/recording.csv"));
}

TEST_F(FleetCommand, TheNumberOfThreadsChangesNothing) {
  simulate(5);
  run("--threads 1 fleet calibrate week --method handheld --store one.db");
  run("--threads 2 fleet calibrate week --method handheld --store two.db");
  EXPECT_THAT(numbers("one.db"), SizeIs(5));
  EXPECT_TRUE(numbers("one.db") == numbers("two.db"));
}

TEST_F(FleetCommand, AFailedSessionIsRecordedAndTheOthersGoOn) {
  simulate(3);
  folder.write("week/unit2/recording.csv", "t,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,9.8\n0.01,0,0,0,0,0,9.8\n");
  const CommandResult first = run("fleet calibrate week --method handheld", 1);
  EXPECT_THAT(first.output, HasSubstr("2 calibrated, 0 in the store before, 1 failed"));
  EXPECT_THAT(first.errors, HasSubstr("unit2"));
  EXPECT_THAT(first.errors, HasSubstr("1 of 3 sessions are not calibrated"));
  const auto failures = nlohmann::json::parse(run("fleet list --failures --json").output)["failures"];
  ASSERT_EQ(failures.size(), 1u);
  EXPECT_THAT(failures[0]["file"].get<std::string>(), HasSubstr("unit2/session.toml"));
  EXPECT_FALSE(failures[0]["message"].get<std::string>().empty());
  EXPECT_THAT(run("fleet calibrate week --method handheld", 1).output, HasSubstr("0 calibrated, 2 in the store before, 0 failed, 1 failed before"));
  run("simulate hand2.toml --seed 9 -o new");
  run_shell(folder, "rm -r week/unit2 && mv new week/unit2");
  EXPECT_THAT(run("fleet calibrate week --method handheld").output, HasSubstr("1 calibrated, 2 in the store before, 0 failed"));
  EXPECT_THAT(run("fleet list --failures").output, HasSubstr("no session has failed"));
}

TEST_F(FleetCommand, GoesOnWhereItWasKilled) {
  simulate(6);
  run("fleet calibrate week --method handheld --store whole.db");
  std::size_t before = 0;
  for (int k = 0; k < 10; ++k) {
    run_shell(folder, std::string("timeout -s KILL 0.0") + std::to_string(2 + 7 * k % 10) + " '" + command_path() +
                          "' --threads 1 fleet calibrate week --method handheld --store killed.db");
    if (!std::filesystem::exists(folder / "killed.db")) continue;
    FleetStore store(folder / "killed.db", fleet::Access::write);
    EXPECT_THAT(store.check().damaged, IsEmpty());
    EXPECT_GE(store.records().size(), before);
    before = store.records().size();
  }
  run("fleet calibrate week --method handheld --store killed.db");
  EXPECT_TRUE(numbers("killed.db") == numbers("whole.db"));
}

TEST_F(FleetCommand, AFullDiskIsAnErrorAndTheStoreIsAsBefore) {
  folder.write("a.json", calibration_text(drawn_calibration(1, 1)));
  run("fleet add a.json");
  const auto before = numbers("fleet.db");
  std::string files;
  for (std::uint64_t k = 2; k < 22; ++k) {
    folder.write("b" + std::to_string(k) + ".json", calibration_text(drawn_calibration(1, k)));
    files += " b" + std::to_string(k) + ".json";
  }
  // No file may grow beyond 40 kB: enough for the index of the log, which has 32, and for its first entries. Then writing fails as on a full disk.
  const CommandResult full = run_shell(folder, std::string("trap '' XFSZ; ulimit -f 80; '") + command_path() + "' fleet add" + files);
  EXPECT_EQ(full.exit_code, 2);
  EXPECT_THAT(full.errors, HasSubstr("expected room to write; the store is as it was before"));
  const auto after = numbers("fleet.db");
  EXPECT_LT(after.size(), 21u);
  EXPECT_TRUE(after.at("1001") == before.at("1001"));
  EXPECT_THAT(run("fleet check").output, HasSubstr("whole"));
  run("fleet add" + files);
  EXPECT_THAT(numbers("fleet.db"), SizeIs(21));
}

TEST_F(FleetCommand, AddsShowsRemovesAndMerges) {
  for (int k = 1; k <= 3; ++k) folder.write("c" + std::to_string(k) + ".json", calibration_text(drawn_calibration(1, static_cast<std::uint64_t>(k))));
  EXPECT_THAT(run("fleet add c1.json c2.json --station 2 --measured 2026-03-31").output, HasSubstr("c2.json: calibration\n"));
  EXPECT_THAT(run("fleet add c1.json").output, HasSubstr("calibration (known)"));
  EXPECT_THAT(run("fleet show 1001").output, HasSubstr("2026-03-31T00:00:00Z (declared)  drawn"));
  run("fleet add c3.json --store other.db");
  EXPECT_THAT(run("fleet merge other.db").output, HasSubstr("1 calibration added"));
  EXPECT_THAT(run("fleet list").output, HasSubstr("3 units"));
  run("fleet remove 1002 --reason 'dropped on the floor'");
  EXPECT_THAT(run("fleet show 1002").output, HasSubstr("dropped on the floor"));
  EXPECT_THAT(numbers("fleet.db"), SizeIs(2));
  EXPECT_THAT(run("fleet remove 1002", 2).errors, HasSubstr("no such calibration"));
  EXPECT_THAT(run("fleet show 77", 2).errors, HasSubstr("fleet.db: has no unit 77"));
}

TEST_F(FleetCommand, TheStoreIsNotReplacedByAResult) {
  draw(3, 1);
  const std::string before = read_text(folder / "fleet.db");
  EXPECT_THAT(run("fleet export --csv -o fleet.db --force", 2).errors, HasSubstr("-o fleet.db: would overwrite fleet.db"));
  EXPECT_THAT(run("fleet stats --report fleet.db", 2).errors, HasSubstr("--report fleet.db: would overwrite fleet.db"));
  EXPECT_EQ(read_text(folder / "fleet.db"), before);
}

TEST_F(FleetCommand, SaysWhenUnitsAreDue) {
  draw(12, 3);
  const std::string stats = "fleet stats --due 'gyro.offset <= 0.8 deg/s' --report fleet.html --unit-pages 'unit pages'";
  EXPECT_THAT(run(stats).output, HasSubstr("due for calibration"));
  const auto due = nlohmann::json::parse(run("fleet stats --due 'gyro.offset <= 0.8 deg/s' --json").output)["due"];
  ASSERT_EQ(due.size(), 12u);
  // Calibrated last in November 2025. Measured to 0.09 deg/s, a drift of 0.2 deg/s a year leaves between one and four years to 0.8 deg/s.
  for (const auto& unit : due) {
    EXPECT_EQ(unit["coefficient"], "gyro.offset.x");
    EXPECT_THAT(unit["time"].get<std::string>(), ::testing::AllOf(::testing::Gt("2026-11"), ::testing::Lt("2029-12")));
  }
  const std::string page = read_text(folder / "fleet.html");
  EXPECT_NE(page.find("<section id=\"overview\">"), std::string::npos);
  EXPECT_THAT(page, HasSubstr("<a href=\"unit%20pages/calibration-25.html\">unit 0 1000</a>"));
  EXPECT_THAT(read_text(folder / "unit pages/calibration-25.html"), HasSubstr("unit 0"));
  // An error that the calibration itself has: due at once. Without a second calibration nothing is known.
  EXPECT_THAT(run("fleet stats --due 'accel.offset <= 10 ug'").output, HasSubstr("2025-11-14           unit 0 1000, for accel.offset.x"));
  EXPECT_THAT(run(stats, 2).errors, HasSubstr("--unit-pages unit pages: exists"));
  EXPECT_THAT(run("fleet stats --due 'accel.offset <= 10 apples'", 2).errors, HasSubstr("--due"));
  EXPECT_THAT(run("fleet stats --unit-pages pages", 2).errors, HasSubstr("--unit-pages: belongs to --report"));
  std::filesystem::remove(folder / "fleet.db");
  draw(3, 1);
  EXPECT_THAT(run("fleet stats --due 'accel.offset <= 10 mg'").errors, HasSubstr("no unit was calibrated twice"));
}

TEST_F(FleetCommand, IsThePriorOfAPlan) {  // ctest: once
  draw(60, 1);
  const std::string plan = "plan --require 'gyro.matrix.off_diagonal <= 200 arcsec' --grade mems --axes hand --effects none";
  const auto without = nlohmann::json::parse(run(plan + " --json").output);
  const auto with = nlohmann::json::parse(run(plan + " --prior fleet.db --report plan.html --json > plan.json; cat plan.json").output);
  EXPECT_LT(with["duration_s"], without["duration_s"]);
  EXPECT_EQ(with["prior"]["duration_without_s"], without["duration_s"]);
  EXPECT_EQ(with["prior"]["units"], 60);
  // Both together: at most what was required, and more than the session alone.
  for (const char* name : {"gyro.matrix.xy", "gyro.matrix.yx", "gyro.matrix.zx"})
    EXPECT_LE(with["coefficients"][name]["closed_form"], 200 * unit::arcsec * (1 + 1e-9));
  EXPECT_THAT(read_text(folder / "plan.html"), HasSubstr("with what 60 units of fleet.db say of it; without: "));
  run("report plan.json -o again.html");
  EXPECT_EQ(read_text(folder / "plan.html"), read_text(folder / "again.html"));
  run("procedure handheld --poses 12 -o short.toml");
  const auto sigma = [&](const std::string& prior) -> double {
    const auto predicted = nlohmann::json::parse(run("predict short.toml --method handheld --json" + prior).output);
    return predicted["coefficients"]["gyro.matrix.xx"]["closed_form"];
  };
  const double of_fleet = sigma(" --prior fleet.db"), alone = sigma("");
  // One unit more of a spread of 1000 ppm measured to 300: 1.09e-6 (1 + 1/60) 59/37; 60 units show a variance to 18 %.
  EXPECT_NEAR(1 / (of_fleet * of_fleet) - 1 / (alone * alone), 1 / 1.77e-6, 0.6 / 1.77e-6);
  EXPECT_THAT(run("plan --require 'gyro.matrix.diagonal <= 5000 ppm' --prior fleet.db", 2).errors,
              HasSubstr("fleet.db: its units meet the requirements uncalibrated"));
  std::filesystem::remove(folder / "fleet.db");
  draw(20, 1);
  EXPECT_THAT(run(plan + " --prior fleet.db", 2).errors,
              HasSubstr("--prior: fleet.db: 20 units that belong together are too few for a prior of 21 coefficients; expected at least 27"));
}

TEST_F(FleetCommand, IsThePriorOfACalibration) {  // ctest: once
  simulate(30);
  run("fleet calibrate week --method handheld");
  run("simulate hand1.toml --seed 31 -o next");
  // From rests alone: what they leave open is the fleet's.
  run("calibrate next --method static -o alone.json");
  run("calibrate next --method static --prior fleet.db -o next.json");
  const Calibration alone = read_calibration(folder / "alone.json"), next = read_calibration(folder / "next.json");
  const CoefficientIndex scale = coefficient_index("gyro.matrix.xx"), offset = coefficient_index("accel.offset.x");
  EXPECT_FALSE(standard_uncertainty(alone, scale));
  ASSERT_TRUE(standard_uncertainty(next, scale));
  EXPECT_LT(*standard_uncertainty(next, offset), *standard_uncertainty(alone, offset));
  EXPECT_THAT(next.quality.unobservable, IsEmpty());
  EXPECT_EQ(next.options.at("prior"), "fleet.db");
  const Calibration truth = read_calibration(folder / "next/truth.json");
  EXPECT_NEAR(coefficient_value(next.model, scale), coefficient_value(truth.model, scale), 5 * *standard_uncertainty(next, scale));
  EXPECT_THAT(run("fleet add next.json", 2).errors, HasSubstr("was calibrated with a fleet's prior"));
  // Units with readings of another kind.
  std::filesystem::remove(folder / "fleet.db");
  draw(40, 1);
  EXPECT_THAT(run("calibrate next --method handheld --prior fleet.db -o other.json", 2).errors, HasSubstr("expected one kind of unit"));
}

TEST_F(FleetCommand, BadInput) {
  EXPECT_THAT(run("fleet list", 2).errors, HasSubstr("fleet.db: SQLite: unable to open database file; expected a fleet store that is there"));
  EXPECT_THAT(run("fleet calibrate nowhere --method static", 2).errors, HasSubstr("nowhere: no session"));
  folder.write("c.json", calibration_text(drawn_calibration(1, 1)));
  Calibration other = drawn_calibration(1, 2);
  other.serial = "1001";
  folder.write("same.json", calibration_text(other));
  folder.write("broken.json", "{");
  const CommandResult result = run("fleet add c.json same.json broken.json", 2);
  EXPECT_THAT(result.output, HasSubstr("c.json: calibration"));
  EXPECT_THAT(result.errors, HasSubstr("two units with one serial number"));
  EXPECT_THAT(result.errors, HasSubstr("broken.json:1: not JSON"));
  EXPECT_THAT(run("fleet add c.json --measured yesterday", 2).errors, HasSubstr("yesterday: is no time"));
  folder.write("d.json", calibration_text(drawn_calibration(1, 5)));
  EXPECT_THAT(run("fleet add d.json --measured 2099-01-01").errors, HasSubstr("after they were added: a clock was wrong"));
  { FleetStore(folder / "fleet.db", fleet::Access::write).database().run("UPDATE calibrations SET added = added + 7200 WHERE id = 1"); }
  EXPECT_THAT(run("fleet check").errors, HasSubstr("before the one ahead of them: a clock was set back"));
  { FleetStore(folder / "fleet.db", fleet::Access::write).database().run("PRAGMA user_version = 2"); }
  EXPECT_THAT(run("fleet list", 2).errors, HasSubstr("a newer imulab wrote it"));
}

TEST_F(FleetCommand, ReadsAStoreInAFolderThatCannotBeWritten) {
  draw(2, 1);
  namespace fs = std::filesystem;
  // Root without its privilege to write where nobody may: the folder may be read, and no more.
  const std::string reader =
      (geteuid() == 0 ? "setpriv --inh-caps=-all --bounding-set=-dac_override,-dac_read_search '" : "'") + command_path() + "' ";
  const auto shut = [&](const std::string& name, bool log) {
    fs::create_directories(folder / name);
    fs::copy(folder / "fleet.db", folder / (name + "/fleet.db"));
    if (log) fs::copy(folder / "fleet.db-wal", folder / (name + "/fleet.db-wal"));
    fs::permissions(folder / name, fs::perms::owner_read | fs::perms::owner_exec);
  };
  shut("whole", false);
  const CommandResult read = run_shell(folder, reader + "fleet list --store whole/fleet.db");
  EXPECT_EQ(read.exit_code, 0) << read.errors;
  EXPECT_THAT(read.output, HasSubstr("2 units"));
  fs::permissions(folder / "whole/fleet.db", fs::perms::owner_read);
  EXPECT_THAT(run_shell(folder, reader + "fleet remove 1001 --store whole/fleet.db").errors,
              HasSubstr("whole/fleet.db: SQLite: attempt to write a readonly database; expected a store that can be written"));
  EXPECT_THAT(run_shell(folder, reader + "fleet remove 1001 --store whole/new.db").errors, HasSubstr("in a folder that can be written"));
  const FleetStore open(folder / "fleet.db", fleet::Access::write);  // while it is open its changes are in the log
  run("fleet remove 1001");
  shut("behind", true);
  const CommandResult behind = run_shell(folder, reader + "fleet list --store behind/fleet.db");
  EXPECT_EQ(behind.exit_code, 2);
  EXPECT_THAT(behind.errors, HasSubstr("behind/fleet.db: its last changes are in fleet.db-wal"));
  for (const char* name : {"whole", "behind"}) fs::permissions(folder / name, fs::perms::owner_all);
}

}  // namespace
}  // namespace imulab
