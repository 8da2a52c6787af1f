// For tests of commands that are stopped: what a folder holds, and whether every file of it is the old one or the whole new one.
#pragma once

#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <map>
#include <string>
#include <vector>

namespace imulab {

using FolderContents = std::map<std::string, std::string>;

/// All files of the folder by their names; a folder counts by a "/".
inline FolderContents folder_contents(const std::filesystem::path& folder) {
  FolderContents all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    all[std::filesystem::relative(entry.path(), folder).string()] = entry.is_directory() ? "/" : read_text(entry.path());
  return all;
}

/// The folder of a run: the inputs, and old files where the new ones go.
inline void prepare_run(const std::filesystem::path& inputs, const std::filesystem::path& place, const std::vector<std::string>& outputs) {
  namespace fs = std::filesystem;
  fs::remove_all(place);
  fs::copy(inputs, place, fs::copy_options::recursive);
  for (const std::string& name : outputs)
    if (name.find('/') == std::string::npos) std::ofstream(place / name) << "old";
}

/// Stamps of the time apart, a new file is as long as it is when nothing stops the command.
inline void expect_each_old_or_new(const FolderContents& before, const FolderContents& after, const FolderContents& now, const std::string& what) {
  for (const auto& [name, text] : now) {
    const auto old = before.find(name), fresh = after.find(name);
    EXPECT_TRUE(old != before.end() || fresh != after.end()) << what << ": left behind " << name;
    EXPECT_TRUE((old != before.end() && old->second == text) || (fresh != after.end() && fresh->second.size() == text.size()))
        << what << ": neither old nor new: " << name << " " << text.size();
  }
  for (const auto& [name, text] : before) EXPECT_TRUE(now.contains(name)) << what << ": " << name << " is gone";
}

/// Of a folder ("out/") all files are there that are there when nothing stops the command, or those of before.
inline void expect_whole_or_absent(const FolderContents& before, const FolderContents& after, const FolderContents& now, const std::string& folder,
                                   const std::string& what) {
  const auto names = [&](const FolderContents& all) {
    std::vector<std::string> out;
    for (const auto& [name, text] : all)
      if (name.starts_with(folder)) out.push_back(name);
    return out;
  };
  if (names(now) != names(before)) {
    EXPECT_EQ(names(now), names(after)) << what;
  }
}

/// Inputs of the verbs: a session S, its calibration c.json, a procedure p.toml, a mission m.toml and its session T, and a fleet's store have.db.
inline void write_inputs_of_all_verbs(const TemporaryFolder& inputs) {
  inputs.write("m.toml",
               "format = \"imulab.mission/1\"\nrate_hz = 10\n[start]\nlatitude_deg = 45\nlongitude_deg = 10\nheight_m = 100\n[[segment]]\nkind = "
               "\"rest\"\nduration_s = 20\n[errors]\ngrade = \"navigation\"\n");
  inputs.write("still.toml",
               "format = \"imulab.session/1\"\n[imu]\nname = \"still\"\ngrade = \"mems\"\n[site]\nlatitude_deg = 45\n[[recording]]\nfile = "
               "\"recording.csv\"\nrate_hz = 20\ntime = { column = \"t\", unit = \"s\" }\ngyro = { columns = [\"gx\", \"gy\", \"gz\"], output = "
               "\"rate\", unit = \"rad/s\" }\naccel = { columns = [\"ax\", \"ay\", \"az\"], output = \"rate\", unit = \"m/s^2\" }\n[[step]]\nkind = "
               "\"hold\"\nstart_s = 0\nend_s = 60\n");
  for (const char* command : {"procedure handheld --poses 12 -o p.toml", "procedure zhang-24 -o zhang.toml", "simulate p.toml -o S",
                              "calibrate S --method static -o c.json || true", "export c.json --to json-matrix -o matrix.json",
                              "trajectory m.toml -o T", "simulate still.toml -o N", "fleet add c.json --store have.db"})
    ASSERT_EQ(run_imulab(inputs, command).exit_code, 0) << command;
}

}  // namespace imulab
