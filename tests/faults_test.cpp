// Every call by which a verb reads or writes a file fails once, and memory ends: the old file or the whole new one is there, nothing is left behind,
// and the error names a file.
// ctest: faults
#include <gmock/gmock.h>

#include "tests/old_or_new.hpp"
#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace imulab {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> calls{"open",  "read",   "pread", "mkstemp",   "mkdtemp", "mkdir",  "fopen", "fwrite",
                                     "write", "pwrite", "fsync", "ftruncate", "fchmod",  "rename", "link",  "mmap"};

struct Faults : testing::Test {
  TemporaryFolder inputs;
  int all_ = 0;
  void SetUp() override { write_inputs_of_all_verbs(inputs); }

  /// One command in a folder of its own, again and again.
  struct Trial {
    const fs::path& inputs;
    std::string command;
    std::vector<std::string> outputs;
    TemporaryFolder work = {}, marks = {};
    fs::path place = work / "w";

    std::string line() const { return "cd w && '" + command_path() + "' " + command; }
    CommandResult good() const {
      prepare_run(inputs, place, outputs);
      return run_shell(work, line());
    }
    /// The n-th such call fails; nothing where there are not so many.
    std::optional<CommandResult> with_fault(const std::string& call, long n) const {
      prepare_run(inputs, place, outputs);
      fs::remove(marks / "seen");
      CommandResult result = run_shell(work, "export LD_PRELOAD='" IMULAB_FAULTS "' IMULAB_FAULT='" + call + " " + std::to_string(n) +
                                                 "' IMULAB_FAULT_SEEN='" + (marks / "seen").string() + "'; " + line());
      return fs::exists(marks / "seen") ? std::optional(std::move(result)) : std::nullopt;
    }
    /// The first of all calls fails, the second, and so on: tells what came out, and of which. How many there were.
    int with_each_fault(const std::function<void(const CommandResult&, const std::string& what)>& expect) const {
      constexpr int most = 200;
      int faults = 0;
      for (const std::string& call : calls)
        for (int n = 1;; ++n, ++faults) {
          const std::string what = command + ": " + call + " " + std::to_string(n);
          const auto result = with_fault(call, n);
          if (!result) break;
          expect(*result, what);
          if (n < most) continue;
          ADD_FAILURE() << what;
          break;
        }
      return faults;
    }
    /// The number of such calls.
    long count(const std::string& call) const { return with_fault(call, 0) ? std::stol(read_text(marks / "seen")) : 0; }
  };

  /// `findings`: a recording that cannot be read is a finding, which the result states. SQLite says in its own words what has failed, and does
  /// without some of its calls: a bag in a database may be there whole in spite of a fault.
  void expect_old_or_new(const std::string& command, const std::vector<std::string>& outputs, bool findings = false) {
    const Trial trial{inputs.path(), command, outputs};
    prepare_run(inputs.path(), trial.place, outputs);
    const FolderContents before = folder_contents(trial.place);
    const CommandResult good = trial.good();
    ASSERT_LE(good.exit_code, 1) << command << good.errors;
    const FolderContents after = folder_contents(trial.place);
    const int faults = trial.with_each_fault([&](const CommandResult& result, const std::string& what) {
      if (findings && result.exit_code != 2) {
        EXPECT_THAT(result.errors + folder_contents(trial.place)["page"], testing::ContainsRegex("cannot be (opened|read|written)")) << what;
        return;
      }
      const FolderContents now = folder_contents(trial.place);
      expect_each_old_or_new(before, after, now, what);
      if (outputs.front().ends_with('/')) expect_whole_or_absent(before, after, now, outputs.front(), what);
      if (command.ends_with(".db3") && result.exit_code == 0) {
        EXPECT_EQ(now, after) << what;
        return;
      }
      EXPECT_EQ(result.exit_code, 2) << what << "\n" << result.errors;
      EXPECT_THAT(result.errors,
                  testing::ContainsRegex("imulab: [^ ]*[a-zA-Z_./-]+.*(Input/output error|No space left on device|disk I/O error|disk is "
                                         "full|image is malformed|unable to open|readonly database)"))
          << what;
      EXPECT_THAT(result.errors, testing::Not(testing::ContainsRegex("out\\.db3\\.[A-Za-z0-9]{6}:"))) << what;
    });
    EXPECT_GE(faults, 4) << command;
    RecordProperty("faults", all_ += faults);
  }

  /// The command goes on from whatever a store or a folder of finished work holds after a fault: the same command then ends as if nothing had
  /// been, and `view` prints the same. `keeps_failures`: a session that cannot be read is a result, too (exit code 1).
  void expect_the_next_run_to_finish(const std::string& command, const std::string& view, bool keeps_failures = false) {
    const Trial trial{inputs.path(), command, {}};
    const CommandResult good = trial.good();
    ASSERT_EQ(good.exit_code, 0) << command << good.errors;
    const std::string shown = run_shell(trial.work, "cd w && '" + command_path() + "' " + view).output;
    ASSERT_NE(shown, "");
    const int faults = trial.with_each_fault([&](const CommandResult& result, const std::string& what) {
      EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 2 || (result.exit_code == 1 && keeps_failures)) << what << result.errors;
      if (result.exit_code != 0) {
        EXPECT_THAT(result.errors, testing::StartsWith("imulab: ")) << what;
        const CommandResult again = run_shell(trial.work, trial.line());
        EXPECT_EQ(again.exit_code, 0) << what << "\n" << again.errors;
      }
      EXPECT_EQ(run_shell(trial.work, "cd w && '" + command_path() + "' " + view).output, shown) << what;
    });
    EXPECT_GE(faults, 4) << command;
    RecordProperty("faults", all_ += faults);
  }

  /// The n-th allocation fails, for some n of all: the command ends with an error, or does without the memory.
  void expect_out_of_memory(const std::string& command, const std::vector<std::string>& outputs, bool store = false) {
    const Trial trial{inputs.path(), command, outputs};
    prepare_run(inputs.path(), trial.place, outputs);
    const FolderContents before = folder_contents(trial.place);
    const CommandResult good = trial.good();
    const FolderContents after = folder_contents(trial.place);
    const long all = trial.count("malloc");
    ASSERT_GT(all, 1000) << command;
    std::set<long> chosen;
    constexpr int most = 8;
    for (int k = 0; k < most; ++k) chosen.insert(std::lround(std::pow(static_cast<double>(all), (k + 0.5) / most)));
    int faults = 0;
    for (const long n : chosen) {
      const std::string what = command + ": malloc " + std::to_string(n);
      const auto result = trial.with_fault("malloc", n);
      if (!result) continue;  // threads share the work in another way each time
      ++faults;
      EXPECT_TRUE(result->exit_code == good.exit_code || result->exit_code == 2) << what << "\n" << result->exit_code << result->errors;
      if (result->exit_code == 2) {
        EXPECT_THAT(result->errors, testing::ContainsRegex("imulab: [^ ]+")) << what;
      }
      if (!store) expect_each_old_or_new(before, after, folder_contents(trial.place), what);
    }
    EXPECT_GE(faults, 4) << command;
    RecordProperty("faults", all_ += faults);
  }

  void write_session_of_bag(const std::string& kind) {
    const std::string vector = "output = \"rate\", unit = ";
    inputs.write("bag.toml", "format = \"imulab.session/1\"\n[imu]\nname = \"x\"\n[site]\ngravity_mps2 = 9.8\n[[recording]]\nfile = \"run" + kind +
                                 "\"\ntime = { column = \"header.stamp\", unit = \"ns\" }\n"
                                 "gyro = { columns = [\"angular_velocity.x\", \"angular_velocity.y\", \"angular_velocity.z\"], " +
                                 vector +
                                 "\"rad/s\" }\n"
                                 "accel = { columns = [\"linear_acceleration.x\", \"linear_acceleration.y\", \"linear_acceleration.z\"], " +
                                 vector + "\"m/s^2\" }\n");
  }
};

TEST_F(Faults, OldOrNewOfEveryVerbThatWrites) {
  expect_old_or_new("procedure zhang-24 -o out", {"out"});
  expect_old_or_new("inspect S/recording.csv -o out --force --report page", {"out", "page"}, true);
  expect_old_or_new("noise N -o out --force --report page", {"out", "page"});
  expect_old_or_new("calibrate S --method static -o out --force --report page", {"out", "page"});
  expect_old_or_new("compare c.json S/truth.json --report page", {"page"});
  expect_old_or_new("report c.json -o page", {"page"}, true);
  expect_old_or_new("predict p.toml --method handheld --report page", {"page"});
  expect_old_or_new("compensate c.json S --allow-undetermined -o out.csv --report page", {"out.csv", "page"});
  expect_old_or_new("compensate c.json S --allow-undetermined -o out.npz", {"out.npz"});
  expect_old_or_new("export c.json --allow-undetermined --to csv -o out --force", {"out"});
  expect_old_or_new("import matrix.json -o out --force", {"out"});
  expect_old_or_new("navigate none T -o out --report page", {"out", "page"});
  expect_old_or_new("budget m.toml --runs 0 --report page", {"page"});
  expect_old_or_new("predict zhang.toml --runs 200 --part 1/1 -o out", {"out"});
  expect_old_or_new("plan --require 'accel.offset <= 1000 ug' -o out --report page", {"out", "page"});
}

TEST_F(Faults, OldOrNewOfEveryBag) {
  for (const char* bag : {"imu_zstd.mcap", "imu_lz4.bag", "imu.db3"}) {
    const std::string kind = fs::path(bag).extension().string();
    fs::copy_file(fs::path(IMULAB_SOURCE) / "tests/recordings" / bag, inputs / ("run" + kind));
    write_session_of_bag(kind);
    expect_old_or_new("compensate c.json bag.toml --allow-undetermined -o out" + kind, {"out" + kind});
  }
}

TEST_F(Faults, AllOfAFolderOrNothing) {
  expect_old_or_new("simulate p.toml -o out", {"out/"});
  expect_old_or_new("trajectory m.toml -o out", {"out/"});
  expect_old_or_new("budget m.toml --runs 0 -o out", {"out/"});
  expect_old_or_new("compensate c.json S --allow-undetermined -o out", {"out/"});
  expect_old_or_new("export c.json --allow-undetermined --to all -o out", {"out/"}, true);
}

TEST_F(Faults, ADemoThatFailedIsMadeAgain) {
  const Trial trial{inputs.path(), "demo -o out", {}};
  const auto failed = trial.with_fault("rename", 2);
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->exit_code, 2) << failed->errors;
  FolderContents left = folder_contents(trial.place / "out");
  EXPECT_EQ(left.size(), 1u);
  EXPECT_TRUE(left.contains("report.html"));  // by which the next run knows the folder
  const CommandResult again = run_shell(trial.work, "cd w && timeout 1 '" + command_path() + "' demo -o out");
  EXPECT_NE(again.exit_code, 2) << again.errors;
}

TEST_F(Faults, AStoreGoesOn) {
  expect_the_next_run_to_finish("fleet add c.json --store new.db", "fleet export --csv --store new.db");
  expect_the_next_run_to_finish("fleet calibrate S --method static --store new.db --retry", "fleet check --store new.db", true);
  expect_the_next_run_to_finish("fleet merge have.db --store new.db", "fleet export --csv --store new.db");
}

TEST_F(Faults, SharedWorkGoesOn) {
  const std::string predict = "predict zhang.toml --runs 200 --checkpoint work --json", budget = "budget m.toml --runs 4 --checkpoint work --json";
  expect_the_next_run_to_finish(predict, predict);
  expect_the_next_run_to_finish(budget, budget);
}

TEST_F(Faults, AFullDiskIsNoFailureOfTheSession) {
  const Trial trial{inputs.path(), "fleet calibrate S --method static --store new.db", {}};
  const auto full = trial.with_fault("pwrite", 55);  // of some 70: the calibration on its way into the store
  ASSERT_TRUE(full);
  EXPECT_EQ(full->exit_code, 2) << full->errors;
  EXPECT_THAT(full->errors, testing::HasSubstr("expected room to write"));
  const CommandResult again = run_shell(trial.work, trial.line());  // without --retry
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_THAT(again.output, testing::HasSubstr("1 calibrated"));
}

TEST_F(Faults, RowsOfAStreamStayWritten) {
  for (const auto& [command, call] : {std::pair{"live S/recording.csv --session S --save log -o out --force >/dev/null", "fwrite"},
                                      {"live S/recording.csv --session S --save log -o out --force >/dev/null", "fopen"},
                                      {"live S/recording.csv --session S --save log -o out --force >/dev/null", "read"},
                                      {"compensate c.json - --session S --allow-undetermined -o rows.csv <S/recording.csv", "fwrite"},
                                      {"compensate c.json - --session S --allow-undetermined -o rows.csv <S/recording.csv", "fopen"}}) {
    const Trial trial{inputs.path(), command, {"out"}};
    const auto result = trial.with_fault(call, 1);
    ASSERT_TRUE(result) << command << call;
    EXPECT_EQ(result->exit_code, 2) << command << call;
    EXPECT_THAT(result->errors, testing::ContainsRegex("imulab: .*(log|rows.csv|recording.csv|c.json|session.toml).*cannot be")) << command << call;
    EXPECT_EQ(read_text(trial.place / "out"), "old");
  }
}

TEST_F(Faults, MemoryThatEnds) {
  expect_out_of_memory("procedure zhang-24 -o out", {"out"});
  expect_out_of_memory("inspect S/recording.csv -o out --force --report page", {"out", "page"});
  expect_out_of_memory("calibrate S --method static -o out --force --report page", {"out", "page"});
  expect_out_of_memory("compensate c.json S --allow-undetermined -o out.csv", {"out.csv"});
  expect_out_of_memory("compensate c.json S --allow-undetermined -o out.npz", {"out.npz"});
  expect_out_of_memory("export c.json --allow-undetermined --to csv -o out --force", {"out"});
  expect_out_of_memory("import matrix.json -o out --force", {"out"});
  expect_out_of_memory("navigate none T -o out --report page", {"out", "page"});
  expect_out_of_memory("simulate p.toml -o out", {"out/"});
  expect_out_of_memory("trajectory m.toml -o out", {"out/"});
  expect_out_of_memory("budget m.toml --runs 0 -o out", {"out/"});
  expect_out_of_memory("predict p.toml --method handheld --report page", {"page"});
  expect_out_of_memory("fleet add c.json --store new.db", {}, true);
  expect_out_of_memory("fleet calibrate S --method static --store new.db", {}, true);
}

}  // namespace
}  // namespace imulab
