// kill -9 at moments all over a command's run: every file is the old one or the whole new one, besides files under temporary names nothing is new,
// and the next run ends as if nothing had been.
// ctest: faults
#include <gmock/gmock.h>

#include "tests/old_or_new.hpp"
#include <chrono>
#include <random>
#include <string>
#include <vector>

namespace imulab {
namespace {

namespace fs = std::filesystem;

/// Names that WholeFile and NewFolder make: "out.4fGh2x", "out.part-4fGh2x/...", "out/new.part-4fGh2x/...". Those that a killed command leaves take
/// room and block nothing.
bool is_temporary(const std::string& name) {
  if (name.find(".part-") != std::string::npos) return true;
  const std::string last = fs::path(name).extension().string();
  return last.size() == 7 && last.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789", 1) == std::string::npos;
}

struct Killed : testing::Test {
  static constexpr int times = 20;
  TemporaryFolder inputs;
  int all_ = 0;
  void SetUp() override { write_inputs_of_all_verbs(inputs); }

  static std::string command(const std::string& arguments) { return "cd w && '" + command_path() + "' " + arguments; }

  /// Runs it and kills it after a time of `whole_s` at most; whether it was still running.
  static bool killed(const TemporaryFolder& work, const std::string& arguments, double whole_s, std::mt19937_64& draw) {
    const double after_s = whole_s * static_cast<double>(draw() % 1000) / 1000 + 1e-3;
    return run_shell(work, "cd w && timeout -s KILL " + std::to_string(after_s) + " '" + command_path() + "' " + arguments).exit_code == 137;
  }

  void expect_old_or_new(const std::string& arguments, const std::vector<std::string>& outputs) {
    const TemporaryFolder work;
    const fs::path place = work / "w";
    prepare_run(inputs.path(), place, outputs);
    const FolderContents before = folder_contents(place);
    const auto begin = std::chrono::steady_clock::now();
    const CommandResult good = run_shell(work, command(arguments));
    const double whole_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const FolderContents after = folder_contents(place);
    std::mt19937_64 draw(1);
    for (int k = 0; k < times; ++k) {
      prepare_run(inputs.path(), place, outputs);
      all_ += killed(work, arguments, whole_s, draw);
      FolderContents now = folder_contents(place);
      std::erase_if(now, [&](const auto& file) { return !after.contains(file.first) && !before.contains(file.first) && is_temporary(file.first); });
      expect_each_old_or_new(before, after, now, arguments);
      if (outputs.front().ends_with('/')) expect_whole_or_absent(before, after, now, outputs.front(), arguments);
      const bool made = outputs.front().find('/') != std::string::npos && fs::exists(place / outputs.front());
      if (made) continue;  // a folder that is there whole is not made again
      const CommandResult next = run_shell(work, command(arguments));
      EXPECT_EQ(next.exit_code, good.exit_code) << arguments << "\n" << next.errors;
    }
    RecordProperty("killed", all_);
  }

  /// The content of a store, or of a folder of finished work.
  void expect_the_next_run_to_finish(const std::string& arguments, const std::string& view) {
    const TemporaryFolder work;
    const fs::path place = work / "w";
    prepare_run(inputs.path(), place, {});
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(run_shell(work, command(arguments)).exit_code, 0) << arguments;
    const double whole_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const std::string shown = run_shell(work, command(view)).output;
    std::mt19937_64 draw(2);
    for (int k = 0; k < times; ++k) {
      prepare_run(inputs.path(), place, {});
      all_ += killed(work, arguments, whole_s, draw);
      const CommandResult next = run_shell(work, command(arguments));
      EXPECT_EQ(next.exit_code, 0) << arguments << "\n" << next.errors;
      EXPECT_EQ(run_shell(work, command(view)).output, shown) << arguments;
    }
    RecordProperty("killed", all_);
  }
};

TEST_F(Killed, OldOrNew) {
  expect_old_or_new("procedure zhang-24 -o out", {"out"});
  expect_old_or_new("inspect S/recording.csv -o out --force --report page", {"out", "page"});
  expect_old_or_new("noise N -o out --force --report page", {"out", "page"});
  expect_old_or_new("calibrate S --method static -o out --force --report page", {"out", "page"});
  expect_old_or_new("compensate c.json S --allow-undetermined -o out.csv", {"out.csv"});
  expect_old_or_new("export c.json --allow-undetermined --to csv -o out --force", {"out"});
  expect_old_or_new("import matrix.json -o out --force", {"out"});
  expect_old_or_new("navigate none T -o out", {"out"});
  expect_old_or_new("report c.json -o page", {"page"});
  expect_old_or_new("predict zhang.toml --runs 1000 --part 1/1 -o out", {"out"});
}

TEST_F(Killed, AllOfAFolderOrNothing) {
  expect_old_or_new("simulate p.toml -o out", {"out/"});
  expect_old_or_new("trajectory m.toml -o out", {"out/"});
  expect_old_or_new("budget m.toml --runs 0 -o out", {"out/"});
  expect_old_or_new("compensate c.json S --allow-undetermined -o out", {"out/"});
  expect_old_or_new("export c.json --allow-undetermined --to all -o out", {"out/"});
}

TEST_F(Killed, TheNextRunGoesOn) {
  expect_the_next_run_to_finish("fleet add c.json --store new.db", "fleet export --csv --store new.db");
  expect_the_next_run_to_finish("fleet calibrate S --method static --store new.db --part 1/1", "fleet check --store new.db");
  const std::string predict = "predict zhang.toml --runs 1000 --checkpoint work --json";
  expect_the_next_run_to_finish(predict, predict);
}

}  // namespace
}  // namespace imulab
