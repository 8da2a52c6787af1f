// Verbs whose work several processes share, as a user types them.
#include "imulab/fleet/store/sample.hpp"
#include "imulab/fleet/store/store.hpp"

#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <filesystem>
#include <string>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct SharedRuns : ::testing::Test {
  TemporaryFolder folder;

  std::string run(const std::string& arguments) {
    const CommandResult result = run_imulab(folder, arguments);
    EXPECT_EQ(result.exit_code, 0) << arguments << "\n" << result.errors;
    return result.output;
  }
  /// The output is the same alone, after ten kills, from three processes at once, and merged from two folders.
  void expect_the_same_bits(const std::string& arguments) {
    const std::string alone = run(arguments);
    for (int k = 0; k < 10; ++k)
      run_shell(folder,
                "timeout -s KILL 0." + std::to_string(1 + k % 4) + " '" + command_path() + "' --threads 1 " + arguments + " --checkpoint killed");
    EXPECT_EQ(run(arguments + " --checkpoint killed"), alone);
    std::string together;
    for (const char* n : {"1", "2", "3"})
      together += "'" + command_path() + "' --threads 1 " + arguments + " --checkpoint shared > " + n + ".json & ";
    run_shell(folder, together + "wait");
    for (const char* n : {"1.json", "2.json", "3.json"}) EXPECT_EQ(read_text(folder / n), alone);
    EXPECT_EQ(run(arguments + " --checkpoint merged --merge killed shared"), alone);
  }
};

TEST_F(SharedRuns, OfAPrediction) {
  run("procedure zhang-24 -o procedure.toml");
  expect_the_same_bits("predict procedure.toml --runs 20000 --json");
}

TEST_F(SharedRuns, OfABudget) {
  folder.write("mission.toml",
               "format = \"imulab.mission/1\"\nrate_hz = 10\n[start]\nlatitude_deg = 45\nlongitude_deg = 8\nheight_m = 400\nspeed_mps = 100\n"
               "[[segment]]\nkind = \"straight\"\nduration_s = 300\n[errors]\ngrade = \"navigation\"\n");
  expect_the_same_bits("budget mission.toml --runs 300 --every 60 --json");
}

TEST_F(SharedRuns, OfAPlan) {
  const std::string plan =
      "plan --require \"gyro.matrix.off_diagonal <= 1 arcsec, accel.matrix.diagonal <= 10 ppm\" --gravity 9.8 --effects none --json";
  expect_the_same_bits(plan);
  EXPECT_EQ(run(plan + " --checkpoint shared"), run(plan));
  const auto error = [&](const std::string& more) { return run_imulab(folder, plan + more).errors; };
  EXPECT_THAT(error(" --time 3600 --checkpoint shared"), HasSubstr("shared: is the checkpoint of another run"));
  EXPECT_THAT(error(" --checkpoint ."), HasSubstr("is no checkpoint"));
  EXPECT_THAT(error(" --checkpoint new --merge ."), HasSubstr(".: is no checkpoint"));
  EXPECT_THAT(error(" --checkpoint new --merge nowhere"), HasSubstr("nowhere: is no checkpoint; expected the folder of an earlier run"));
  EXPECT_FALSE(std::filesystem::exists(folder / "new"));
}

TEST_F(SharedRuns, OfAFleet) {
  run("procedure handheld -o hand.toml");
  std::filesystem::create_directories(folder / "week");
  for (const std::string n : {"1", "2", "3", "4", "5", "6"}) {
    run_shell(folder, "sed 's/^name = .*/name = \"unit\"\\nserial = \"" + n + "\"/' hand.toml > one.toml");
    run("simulate one.toml --seed " + n + " -o week/unit" + n);
  }
  const auto numbers = [&](const char* file) {
    FleetStore store(folder / file);
    std::string out;
    for (const FleetRecord& r : store.records()) out += r.serial + fleet::packed(fleet::numbers_of(store, r.id));
    return out;
  };
  run("fleet calibrate week --method handheld --store alone.db");
  // Three ranks: the first one has the store, and one is killed.
  std::string ranks;
  for (const char* rank : {"1", "2"})
    ranks += "OMPI_COMM_WORLD_RANK=" + std::string(rank) + " timeout -s KILL " + (rank[0] == '2' ? "0.2" : "60") + " '" + command_path() +
             "' --threads 1 fleet calibrate week --method handheld --store shared.db --checkpoint ranks > " + rank + ".txt & ";
  const CommandResult first =
      run_shell(folder, ranks + "OMPI_COMM_WORLD_RANK=0 '" + command_path() +
                            "' --threads 1 fleet calibrate week --method handheld --store shared.db --checkpoint ranks; wait");
  EXPECT_THAT(first.output, HasSubstr("6 sessions: 6 calibrated, 0 in the store before, 0 failed"));
  EXPECT_THAT(read_text(folder / "1.txt"), IsEmpty());
  EXPECT_TRUE(numbers("alone.db") == numbers("shared.db"));
  // Again: nothing is left. Failures that are tried once more are another work, and so is a file that changes.
  EXPECT_THAT(run("fleet calibrate week --method handheld --store shared.db --checkpoint ranks"), HasSubstr("0 calibrated, 6 in the store before"));
  EXPECT_THAT(run_imulab(folder, "fleet calibrate week --method handheld --store shared.db --checkpoint ranks --retry").errors,
              HasSubstr("ranks: is the checkpoint of another run"));
  run_shell(folder, "echo '# more' >> week/unit2/recording.csv");
  EXPECT_THAT(run_imulab(folder, "fleet calibrate week --method handheld --store shared.db --checkpoint ranks").errors,
              HasSubstr("ranks: is the checkpoint of another run"));
}

TEST_F(SharedRuns, OfOtherNumbersOfRunsAreRefused) {
  run("procedure zhang-24 -o procedure.toml");
  run("predict procedure.toml --runs 129 --checkpoint here");
  const auto error = [&](const std::string& arguments) {
    const CommandResult result = run_imulab(folder, arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    return result.errors;
  };
  // 129 runs are two parts, and so are 256; the first one is the same.
  EXPECT_THAT(error("predict procedure.toml --runs 256 --checkpoint here"),
              HasSubstr("here: is the checkpoint of another run (its \"runs\" differs)"));
  EXPECT_THAT(error("predict procedure.toml --runs 256 --checkpoint new --merge here"), HasSubstr("here: is the checkpoint of another run"));
  EXPECT_THAT(error("predict procedure.toml --runs 129 --classical --checkpoint here"), HasSubstr("(its \"classical\" differs)"));
  run_shell(folder, "sed 's/^format/# a word\\nformat/' procedure.toml > more.toml && mv more.toml procedure.toml");
  EXPECT_THAT(error("predict procedure.toml --runs 129 --checkpoint here"), HasSubstr("(its \"session\" differs)"));
}

TEST_F(SharedRuns, OfABudgetDependOnAllItsInputs) {
  const std::string mission =
      "format = \"imulab.mission/1\"\nrate_hz = 10\n[start]\nlatitude_deg = 45\nlongitude_deg = 8\nheight_m = 400\nspeed_mps = 100\n"
      "[[segment]]\nkind = \"straight\"\nduration_s = 30\n[errors]\ngrade = \"navigation\"\n";
  folder.write("mission.toml", mission);
  run("procedure handheld -o hand.toml");
  run("simulate hand.toml -o one");
  run("calibrate one --method handheld -o c.json");
  const std::string budget = "budget mission.toml --calibration c.json --allow-undetermined --runs 20";
  run(budget + " --checkpoint here");
  run(budget + " --checkpoint here");
  const auto error = [&](const std::string& arguments) { return run_imulab(folder, arguments).errors; };
  EXPECT_THAT(error("budget mission.toml --calibration c.json --allow-undetermined --runs 21 --checkpoint here"),
              HasSubstr("(its \"runs\" differs)"));
  EXPECT_THAT(error("budget mission.toml --grade tactical --runs 20 --checkpoint here"), HasSubstr("(its \"grade\" differs)"));
  EXPECT_THAT(error(budget + " --every 9 --checkpoint here"), HasSubstr("(its \"every\" differs)"));
  run("calibrate one --method static -o c.json --force");
  EXPECT_THAT(error(budget + " --checkpoint here"), HasSubstr("(its \"calibration\" differs)"));
}

/// One session by hand below week/.
struct SharedFleet : SharedRuns {
  SharedFleet() {
    run("procedure handheld --poses 24 -o hand.toml");
    run("simulate hand.toml -o week/one");
  }
};

TEST_F(SharedFleet, NamesStayApart) {
  run("fleet calibrate week --method static --station \"A B\" --operator C --checkpoint here");
  const CommandResult other = run_imulab(folder, "fleet calibrate week --method static --station A --operator \"B C\" --checkpoint here");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.errors, HasSubstr("here: is the checkpoint of another run (its \"station\" differs)"));
  EXPECT_THAT(read_text(folder / "here/identity"), HasSubstr("\nversion="));
}

TEST_F(SharedFleet, WhatOneStoreHasAnotherGets) {
  run("fleet calibrate week --method static --store a.db");
  EXPECT_THAT(run("fleet calibrate week --method static --store a.db --checkpoint here"), HasSubstr("0 calibrated, 1 in the store before"));
  EXPECT_THAT(run("fleet calibrate week --method static --store b.db --checkpoint here"), HasSubstr("1 calibrated, 0 in the store before"));
  EXPECT_EQ(FleetStore(folder / "b.db").records().size(), 1u);
}

TEST_F(SharedFleet, TasksOfAnArrayAreRefused) {
  for (const char* variable : {"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_JOB_ID"}) {
    const std::string task = std::string(variable) + "=2 '" + command_path() + "' fleet calibrate week --method static --store fleet.db";
    const CommandResult refused = run_shell(folder, task + " --checkpoint here");
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.errors, HasSubstr("--checkpoint: this is a task of a Slurm array"));
    EXPECT_FALSE(std::filesystem::exists(folder / "fleet.db"));
    EXPECT_FALSE(std::filesystem::exists(folder / "here"));
  }
  const CommandResult alone = run_shell(folder, "SLURM_ARRAY_TASK_ID=2 '" + command_path() + "' fleet calibrate week --method static --store 2.db");
  EXPECT_EQ(alone.exit_code, 0) << alone.errors;
}

TEST_F(SharedRuns, WithoutAFolderEveryRankIsForItself) {
  run("procedure zhang-24 -o procedure.toml");
  const std::string alone = run("predict procedure.toml --runs 1000 --json");
  const auto as_rank_1 = [&](const std::string& more) {
    return run_shell(folder, "SLURM_PROCID=1 '" + command_path() + "' predict procedure.toml --runs 1000 --json" + more);
  };
  EXPECT_EQ(as_rank_1("").output, alone);
  EXPECT_THAT(as_rank_1(" --checkpoint shared").output, IsEmpty());
}

TEST_F(SharedRuns, TheStoreMayLieBesideASession) {
  run("procedure handheld -o hand.toml");
  run("simulate hand.toml -o one");
  run_shell(folder, "cp one/* .");
  for (const char* counts : {"1 calibrated, 0 in the store before", "0 calibrated, 1 in the store before"})
    EXPECT_THAT(run("fleet calibrate session.toml --method handheld --checkpoint ranks"), HasSubstr(counts));
}

TEST_F(SharedRuns, BadInput) {
  run("procedure zhang-24 -o procedure.toml");
  run("predict procedure.toml --runs 1000 --checkpoint here");
  const auto error = [&](const std::string& arguments) {
    const CommandResult result = run_imulab(folder, arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_THAT(result.output, IsEmpty()) << arguments;
    return result.errors;
  };
  EXPECT_THAT(error("predict procedure.toml --runs 2000 --checkpoint here"), HasSubstr("here: is the checkpoint of another run"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --seed 2 --checkpoint here"), HasSubstr("here: is the checkpoint of another run"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --merge here"), HasSubstr("--merge: belongs to --checkpoint"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --checkpoint ."), HasSubstr("is no checkpoint"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --checkpoint procedure.toml"), HasSubstr("procedure.toml"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --checkpoint new --merge nowhere"), HasSubstr("nowhere: is no checkpoint"));
  EXPECT_FALSE(std::filesystem::exists(folder / "new"));
  EXPECT_THAT(error("predict procedure.toml --method hybrid --checkpoint new"), HasSubstr("--checkpoint: belongs to --method turntable"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --checkpoint /proc/none"), HasSubstr("/proc/none"));
}

}  // namespace
}  // namespace imulab
