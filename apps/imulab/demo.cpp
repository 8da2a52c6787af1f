// imulab demo: a good calibration from a poor table and its proof by a drive (Cheng 2014), with the commands that a user would type.
#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"
#include "imulab/io/text/file.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <memory>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

constexpr const char* drive = R"(format = "imulab.mission/1"
rate_hz = 100
truth_rate_hz = 1
carrier = "vehicle"

[start]
latitude_deg = 40
longitude_deg = 116.3
height_m = 50

[[segment]]
kind = "rest"                  # to align on
duration_s = 301

[[segment]]
kind = "accelerate"            # to 60 km/h
to_mps = 16.666667
duration_s = 20

[[segment]]
kind = "straight"
duration_s = 375

[[segment]]
kind = "turn"
angle_deg = 45
rate_dps = 3

[[segment]]
kind = "repeat"                # an hour of it
last = 2
times = 9

[[segment]]
kind = "brake"
duration_s = 20

[errors]                       # noise; the coefficients are the unit's
gyro = { angle_random_walk_deg_per_sqrt_h = 0.001 }
accel = { velocity_random_walk_ug_per_sqrt_hz = 5 }
)";

/// Prints and runs one command; the demo ends if it fails.
void step(const std::string& why, const std::vector<std::string>& arguments) {
  std::string line = "imulab";
  for (const std::string& argument : arguments) line += " " + argument;
  if (!why.empty()) fmt::print("\n# {}\n", why);
  fmt::print("$ {}\n", line);
  std::fflush(stdout);
  if (run(arguments) != 0) throw Error("the demo stopped at: " + line);
}

/// Removes the files of an earlier demo, and nothing else.
void clear(const fs::path& folder) {
  for (const char* session : {"path", "positions", "drive"}) {
    for (const char* file : {"session.toml", "recording.csv", "truth.json", "truth.csv"}) fs::remove(folder / session / file);
    if (fs::exists(folder / session) && fs::is_empty(folder / session)) fs::remove(folder / session);
  }
  for (const char* file : {"path.toml", "positions.toml", "drive.toml", "hybrid.json", "classical.json"}) fs::remove(folder / file);
}

void demo(const fs::path& folder, std::uint64_t seed) {
  clear(folder);
  fs::create_directories(folder);
  const auto in = [&](const char* name) { return (folder / name).string(); };
  const std::string number = std::to_string(seed), other = std::to_string(seed + 1);
  step("A table of only 1 arcmin turns a navigation-grade IMU along a path: 25 min, 20 turns.",
       {"procedure", "cheng-path", "--table", "60", "-o", in("path.toml")});
  step("", {"simulate", in("path.toml"), "-o", in("path"), "--seed", number});
  step("The classical procedure on the same table, with the same IMU, for 31 min.",
       {"procedure", "zhang-24", "--table", "60", "--rest", "17", "-o", in("positions.toml")});
  step("", {"simulate", in("positions.toml"), "--unit", in("path/truth.json"), "-o", in("positions"), "--seed", other});
  step("Classical: the table's angles are the reference.", {"calibrate", in("positions"), "--method", "turntable", "-o", in("classical.json")});
  step("Hybrid: the reference is that the IMU stays in one place. The table only turns it.",
       {"calibrate", in("path"), "--method", "hybrid", "-o", in("hybrid.json")});
  step("Comparison with the truth, in sigmas.", {"compare", in("hybrid.json"), in("path/truth.json")});
  write_whole(folder / "drive.toml", drive);
  step("The accuracy in practice: the IMU is driven for an hour (drive.toml).",
       {"trajectory", in("drive.toml"), "--unit", in("path/truth.json"), "--seed", number, "-o", in("drive")});
  step("Pure-inertial navigation with the classical calibration:", {"navigate", in("classical.json"), in("drive"), "--align", "--vertical", "fixed"});
  step("and with the hybrid one:", {"navigate", in("hybrid.json"), in("drive"), "--align", "--vertical", "fixed"});
  fmt::print("\nOne drive is one draw, mainly of noise and alignment; docs/cheng2014.md has 200 of them.\n");
  fmt::print("All files are in {}\n", fs::absolute(folder).lexically_normal().string());
}

}  // namespace

void add_demo(Verb app) {
  struct Arguments {
    std::string folder = "imulab-demo";
    std::uint64_t seed = 1;
  };
  const auto a = std::make_shared<Arguments>();
  Verb verb = app.verb("demo", "Calibrate on a poor table in two ways and navigate an hour's drive with each; no input needed");
  verb.option("-o,--output", a->folder, "the folder to write to").show_default();
  verb.option("--seed", a->seed, "random seed of the IMU and the noise").show_default();
  verb.does([a] { demo(a->folder, a->seed); });
}

}  // namespace imulab::command
