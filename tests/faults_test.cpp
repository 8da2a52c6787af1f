// Every call by which a verb reads or writes a file fails once: the old file or the whole new one is there, nothing is left behind, and the error
// names a file.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <map>
#include <string>
#include <vector>

namespace imulab {
namespace {

namespace fs = std::filesystem;
using Contents = std::map<std::string, std::string>;

/// All files of the folder by their names; a folder counts by a "/".
Contents contents(const fs::path& folder) {
  Contents all;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    all[fs::relative(entry.path(), folder).string()] = entry.is_directory() ? "/" : read_text(entry.path());
  return all;
}

struct Faults : testing::Test {
  TemporaryFolder inputs;
  int all_ = 0;
  void SetUp() override {
    inputs.write("m.toml",
                 "format = \"imulab.mission/1\"\nrate_hz = 10\n[start]\nlatitude_deg = 45\nlongitude_deg = 10\nheight_m = 100\n[[segment]]\nkind = "
                 "\"rest\"\nduration_s = 20\n[errors]\ngrade = \"navigation\"\n");
    for (const char* command : {"procedure hand-held --poses 12 -o p.toml", "simulate p.toml -o S", "calibrate S --method static -o c.json || true",
                                "export c.json --to json-matrix -o matrix.json", "trajectory m.toml -o T"}) {
      ASSERT_EQ(run_imulab(inputs, command).exit_code, 0) << command;
    }
  }

  /// The folder of a run: the inputs, and old files where the new ones go.
  static void prepare(const fs::path& from, const fs::path& to, const std::vector<std::string>& outputs) {
    fs::remove_all(to);
    fs::copy(from, to, fs::copy_options::recursive);
    for (const std::string& name : outputs)
      if (name.find('/') == std::string::npos) std::ofstream(to / name) << "old";
  }

  /// `findings`: a recording that cannot be read is a finding, which the result states.
  void expect_old_or_new(const std::string& command, const std::vector<std::string>& outputs, bool findings = false) {
    const TemporaryFolder work, marks;
    const fs::path place = work / "w";
    const std::string run = "cd w && '" + command_path() + "' " + command;
    prepare(inputs.path(), place, outputs);
    const Contents before = contents(place);
    const CommandResult good = run_shell(work, run);
    ASSERT_LE(good.exit_code, 1) << command << good.errors;
    const Contents after = contents(place);
    int faults = 0;
    for (const char* call : {"open", "read", "mkstemp", "mkdtemp", "mkdir", "fopen", "write", "pwrite", "fchmod", "rename", "mmap"})
      for (int n = 1;; ++n) {
        prepare(inputs.path(), place, outputs);
        fs::remove(marks / "seen");
        const std::string what = command + ": " + call + " " + std::to_string(n);
        const CommandResult result = run_shell(work, "export LD_PRELOAD='" IMULAB_FAULTS "' IMULAB_FAULT='" + std::string(call) + " " +
                                                         std::to_string(n) + "' IMULAB_FAULT_SEEN='" + (marks / "seen").string() + "'; " + run);
        if (!fs::exists(marks / "seen")) {
          EXPECT_EQ(result.exit_code, good.exit_code) << what;
          break;
        }
        ++faults;
        ASSERT_LT(n, 200) << what;
        if (findings && result.exit_code != 2) {
          EXPECT_THAT(result.errors + contents(place)["page"], testing::ContainsRegex("cannot be (opened|read|written)")) << what;
          continue;
        }
        EXPECT_EQ(result.exit_code, 2) << what << "\n" << result.errors;
        EXPECT_THAT(result.errors, testing::ContainsRegex("imulab: [^ ]*[a-zA-Z_./-]+.*(Input/output error|No space left on device)")) << what;
        for (const auto& [name, text] : contents(place)) {
          const auto old = before.find(name), fresh = after.find(name);
          EXPECT_TRUE(old != before.end() || fresh != after.end()) << what << ": left behind " << name;
          // Stamps of the time apart, a new file is as long as it is without a fault.
          EXPECT_TRUE((old != before.end() && old->second == text) || (fresh != after.end() && fresh->second.size() == text.size()))
              << what << ": neither old nor new: " << name << " " << text.size();
        }
        for (const auto& [name, text] : before) EXPECT_TRUE(fs::exists(place / name)) << what << ": " << name << " is gone";
      }
    EXPECT_GE(faults, 4) << command;
    RecordProperty("faults", all_ += faults);
  }
};

TEST_F(Faults, OldOrNewOfEveryVerbThatWrites) {
  expect_old_or_new("procedure zhang-24 -o out", {"out"});
  expect_old_or_new("inspect S/recording.csv -o out --force --report page", {"out", "page"}, true);
  expect_old_or_new("calibrate S --method static -o out --force --report page", {"out", "page"});
  expect_old_or_new("compare c.json S/truth.json --report page", {"page"});
  expect_old_or_new("report c.json -o page", {"page"}, true);
  expect_old_or_new("predict p.toml --method handheld --report page", {"page"});
  expect_old_or_new("compensate c.json S --allow-undetermined -o out.csv --report page", {"out.csv", "page"});
  expect_old_or_new("compensate c.json S --allow-undetermined -o out.npz", {"out.npz"});
  for (const char* bag : {"imu_zstd.mcap", "imu_lz4.bag", "imu.db3"}) {
    const std::string kind = fs::path(bag).extension().string();
    fs::copy_file(fs::path(IMULAB_SOURCE) / "tests/recordings" / bag, inputs / ("run" + kind));
    const std::string vector = "output = \"rate\", unit = ";
    inputs.write("bag.toml", "format = \"imulab.session/1\"\n[imu]\nname = \"x\"\n[site]\ngravity_mps2 = 9.8\n[[recording]]\nfile = \"run" + kind +
                                 "\"\ntime = { column = \"header.stamp\", unit = \"ns\" }\n"
                                 "gyro = { columns = [\"angular_velocity.x\", \"angular_velocity.y\", \"angular_velocity.z\"], " +
                                 vector +
                                 "\"rad/s\" }\n"
                                 "accel = { columns = [\"linear_acceleration.x\", \"linear_acceleration.y\", \"linear_acceleration.z\"], " +
                                 vector + "\"m/s^2\" }\n");
    expect_old_or_new("compensate c.json bag.toml --allow-undetermined -o out" + kind, {"out" + kind});
  }
  expect_old_or_new("export c.json --allow-undetermined --to csv -o out --force", {"out"});
  expect_old_or_new("import matrix.json -o out --force", {"out"});
  expect_old_or_new("navigate none T -o out --report page", {"out", "page"});
  expect_old_or_new("budget m.toml --runs 0 --report page", {"page"});
  expect_old_or_new("plan --require 'accel.offset <= 1000 ug' -o out --report page", {"out", "page"});
}

TEST_F(Faults, AllOfAFolderOrNothing) {
  expect_old_or_new("simulate p.toml -o out", {"out/"});
  expect_old_or_new("trajectory m.toml -o out", {"out/"});
  expect_old_or_new("budget m.toml --runs 0 -o out", {"out/"});
  expect_old_or_new("compensate c.json S --allow-undetermined -o out", {"out/"});
  expect_old_or_new("export c.json --allow-undetermined --to all -o out", {"out/"}, true);
}

}  // namespace
}  // namespace imulab
