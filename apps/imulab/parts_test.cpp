// Verbs whose work is done in parts, or resumed, as a user types them.
#include "imulab/core/part_file.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/store/sample.hpp"

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
  /// The output is the same alone, after ten kills, and joined from three parts, one of which was killed and made again.
  void expect_the_same_bits(const std::string& arguments) {
    const std::string alone = run(arguments + " --json");
    for (int k = 0; k < 10; ++k)
      run_shell(folder, "timeout -s KILL 0." + std::to_string(1 + k % 4) + " '" + command_path() + "' --threads 1 " + arguments +
                            " --checkpoint killed > /dev/null");
    EXPECT_EQ(run(arguments + " --json --checkpoint killed"), alone);
    run_shell(folder, "timeout -s KILL 0.1 '" + command_path() + "' " + arguments + " --part 2/3 -o part2 --checkpoint one");
    for (const std::string k : {"3", "1", "2"})
      EXPECT_THAT(run("--threads 1 " + arguments + " --part " + k + "/3 -o part" + k + " --checkpoint one"), HasSubstr("part " + k + " of 3: "));
    EXPECT_EQ(run("join part2 part3 part1 --json"), alone);
    EXPECT_EQ(run("join part1 part2 part3"), run(arguments));
  }
};

TEST_F(SharedRuns, OfAPrediction) {  // ctest: long
  run("procedure zhang-24 -o procedure.toml");
  expect_the_same_bits("predict procedure.toml --runs 8000 --require \"gyro.offset <= 1 deg/h\"");
}

TEST_F(SharedRuns, OfABudget) {
  folder.write("mission.toml",
               "format = \"imulab.mission/1\"\nrate_hz = 10\n[start]\nlatitude_deg = 45\nlongitude_deg = 8\nheight_m = 400\nspeed_mps = 100\n"
               "[[segment]]\nkind = \"straight\"\nduration_s = 300\n[errors]\ngrade = \"navigation\"\n");
  expect_the_same_bits("budget mission.toml --runs 300 --every 60");
  run("budget mission.toml --runs 300 --every 60 -o alone");
  run("join part1 part2 part3 -o joined --report joined.html");
  for (const char* file : {"total.csv", "monte_carlo.csv", "runs.csv"})
    EXPECT_EQ(read_text(folder / "joined" / file), read_text(folder / "alone" / file)) << file;
  EXPECT_THAT(read_text(folder / "joined.html"), HasSubstr("mission.toml"));
}

TEST_F(SharedRuns, OfAPlan) {  // ctest: long
  const std::string plan = "plan --require \"gyro.matrix.off_diagonal <= 1 arcsec, accel.matrix.diagonal <= 10 ppm\" --gravity 9.8 --effects none";
  expect_the_same_bits(plan);
  const auto error = [&](const std::string& more) { return run_imulab(folder, plan + more).errors; };
  EXPECT_THAT(error(" --within 3600 --checkpoint killed"), HasSubstr("is the checkpoint of another run"));
}

TEST_F(SharedRuns, OfAFleet) {
  run("procedure handheld -o hand.toml");
  std::filesystem::create_directories(folder / "week");
  for (const std::string n : {"1", "2", "3", "4", "5", "6", "7"}) {
    run_shell(folder, "sed 's/^name = .*/name = \"unit\"\\nserial = \"" + n + "\"/' hand.toml > one.toml");
    run("simulate one.toml --seed " + n + " -o week/unit" + n);
  }
  const auto numbers = [&](const char* file) {
    FleetStore store(folder / file);
    std::string out;
    for (const FleetRecord& r : store.records()) out += r.serial + fleet::packed(fleet::numbers_of(store, r.id));
    return out;
  };
  const std::string calibrate = "fleet calibrate week --method handheld";
  run(calibrate + " --store alone.db");
  const auto error = [&](const std::string& arguments) {
    const CommandResult result = run_imulab(folder, arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    return result.errors;
  };
  run_shell(folder, "timeout -s KILL 0.2 '" + command_path() + "' " + calibrate + " --part 2/3 --store 2.db");
  EXPECT_THAT(run(calibrate + " --part 1/3 --store 1.db"), HasSubstr("2 sessions: 2 calibrated"));
  EXPECT_THAT(run(calibrate + " --part 3/3 --store 3.db"), HasSubstr("3 sessions: 3 calibrated"));
  EXPECT_THAT(error("fleet merge 3.db 1.db --store all.db"), HasSubstr("of 3 parts these are missing: 2"));
  run(calibrate + " --part 2/3 --store 2.db");
  EXPECT_THAT(run("fleet merge 3.db 1.db 2.db --store all.db"), HasSubstr("7 calibrations added from 3 stores"));
  EXPECT_TRUE(numbers("alone.db") == numbers("all.db"));
  // Wrong combinations.
  EXPECT_THAT(error("fleet merge 3.db 1.db 2.db 2.db --store more.db"), HasSubstr("2.db: part 2 is also 2.db"));
  EXPECT_THAT(error("fleet merge 3.db 1.db alone.db --store more.db"), HasSubstr("alone.db: of these stores some are parts"));
  EXPECT_THAT(error(calibrate + " --part 2/3 --store 1.db"), HasSubstr("1.db: is part 1 of 3"));
  EXPECT_THAT(error(calibrate + " --part 2/3 --store alone.db"), HasSubstr("alone.db: is a store already"));
  EXPECT_THAT(error("fleet merge alone.db --store 1.db"), HasSubstr("1.db: is part 1 of 3 of a fleet's sessions"));
  EXPECT_THAT(error(calibrate + " --store 1.db"), HasSubstr("1.db: is part 1 of 3 of a fleet's sessions"));
  EXPECT_THAT(error(calibrate + " --part 2/3"), HasSubstr("expected --store"));
  EXPECT_FALSE(std::filesystem::exists(folder / "more.db"));
  EXPECT_THAT(error(calibrate + " --terms accel.offset --part 1/3 --store 1.db"), HasSubstr("(its \"terms\" differs)"));
  run_shell(folder, "echo '# more' >> week/unit2/session.toml");
  EXPECT_THAT(error(calibrate + " --part 1/3 --store 1.db"), HasSubstr("(its \"list\" differs)"));
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

TEST_F(SharedRuns, NothingElseIsOverwritten) {
  run("procedure zhang-24 -o procedure.toml");
  const auto error = [&](const std::string& arguments) {
    const CommandResult result = run_imulab(folder, arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    return result.errors;
  };
  const std::string predict = "predict procedure.toml --runs 200 ";
  EXPECT_THAT(error(predict + "--part 1/1 -o procedure.toml"), HasSubstr("procedure.toml"));
  EXPECT_THAT(error(predict + "--part 1/1 -o nowhere/part"), HasSubstr("nowhere is no folder"));
  EXPECT_THAT(error(predict + "--part 1/1 -o -"), HasSubstr("expected -o"));
  EXPECT_THAT(error(predict + "--part 1/1 -o part --json"), HasSubstr("--json and --report are of imulab join"));
  EXPECT_THAT(read_text(folder / "procedure.toml"), HasSubstr("format"));
  std::filesystem::create_directories(folder / "mine");
  folder.write("mine/results", "mine");
  EXPECT_THAT(error(predict + "--checkpoint mine"), HasSubstr("mine: is no checkpoint"));
  EXPECT_EQ(read_text(folder / "mine/results"), "mine");
  const std::string plan = "plan --require \"gyro.offset <= 10 deg/h\" ";
  for (const char* index : {"0", "1"})
    EXPECT_EQ(
        run_shell(folder, "JOB_COMPLETION_INDEX=" + std::string(index) + " '" + command_path() + "' " + plan + "--part auto/2 -o plans").exit_code,
        0);
  const std::string part = read_text(folder / "plans/part-1-of-2");
  EXPECT_THAT(error("join plans/part-1-of-2 plans/part-2-of-2 -o plans/part-1-of-2"), HasSubstr("part-1-of-2"));
  EXPECT_EQ(read_text(folder / "plans/part-1-of-2"), part);
  PartWriter hostile({1, 1}, std::string("predict\0procedure.toml\0--report\0victim\0", 39));
  hostile.begin_work("x", 0), hostile.end_work();
  folder.write("hostile", hostile.bytes());
  EXPECT_THAT(error("join hostile"), HasSubstr("hostile: its command has --report, which no part has"));
  EXPECT_FALSE(std::filesystem::exists(folder / "victim"));
}

TEST_F(SharedRuns, NumbersOfPartsComeFromTheEnvironment) {
  run("procedure zhang-24 -o procedure.toml");
  const std::string predict = "' predict procedure.toml --runs 1000";
  for (const char* rank : {"0", "1"}) {
    const CommandResult result = run_shell(
        folder, "OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=" + std::string(rank) + " '" + command_path() + predict + " --part auto -o parts");
    EXPECT_THAT(result.output, HasSubstr("written: parts/part-" + std::to_string(1 + rank[0] - '0') + "-of-2")) << result.errors;
  }
  EXPECT_EQ(run_shell(folder, "'" + command_path() + "' join parts/part-* --json").output, run("predict procedure.toml --runs 1000 --json"));
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
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --checkpoint ."), HasSubstr("is no checkpoint"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --checkpoint procedure.toml"), HasSubstr("procedure.toml"));
  EXPECT_FALSE(std::filesystem::exists(folder / "new"));
  EXPECT_THAT(error("predict procedure.toml --method hybrid --checkpoint new"), HasSubstr("--checkpoint: belongs to --method turntable"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --checkpoint /proc/none"), HasSubstr("/proc/none"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --part 1/2"), HasSubstr("expected -o"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 -o part"), HasSubstr("--output: is the file of a --part"));
  EXPECT_THAT(error("predict procedure.toml --runs 0 --part 1/2 -o part"), HasSubstr("--part: divides a Monte Carlo"));
  EXPECT_THAT(error("predict procedure.toml --method hybrid --part 1/2 -o part"), HasSubstr("--part: belongs to --method turntable"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --part 3/2 -o part"), HasSubstr("--part: 3/2; expected K/N"));
  EXPECT_THAT(error("predict procedure.toml --runs 1000 --part auto -o part"), HasSubstr("--part: auto: no Slurm array"));
  EXPECT_THAT(error("join procedure.toml"), HasSubstr("procedure.toml: is no part of a work"));
  run("predict procedure.toml --runs 1000 --part 1/2 -o first");
  run("predict procedure.toml --runs 1000 --part 2/2 -o second");
  EXPECT_THAT(error("join first"), HasSubstr("of 2 parts these are missing: 2"));
  run_shell(folder, "sed 's/^format/# a word\\nformat/' procedure.toml > more.toml && mv more.toml procedure.toml");
  EXPECT_THAT(error("join first second"), HasSubstr("first: is a part of another run (its \"session\" differs)"));
}

}  // namespace
}  // namespace imulab
