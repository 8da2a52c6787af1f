// imulab demo: the main job end to end, as a user would type it.
#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <memory>

namespace imulab::command {

namespace {

namespace fs = std::filesystem;

/// Says and does one command; the demo ends where one fails.
void step(const std::string& why, const std::vector<std::string>& arguments) {
  std::string line = "imulab";
  for (const std::string& argument : arguments) line += " " + argument;
  fmt::print("\n# {}\n$ {}\n\n", why, line);
  std::fflush(stdout);
  if (run(arguments) != 0) throw Error("the demo stopped at: " + line);
}

void demo(const fs::path& folder, std::uint64_t seed) {
  const fs::path procedure = folder / "hand-held.toml", session = folder / "session", calibration = folder / "calibration.json";
  // Its own earlier files go, and nothing else.
  for (const fs::path& own : {procedure, session / "session.toml", session / "recording.csv", session / "truth.json", session, calibration, folder / "compensated.csv"})
    if (fs::exists(own) && !(fs::is_directory(own) && !fs::is_empty(own))) fs::remove(own);
  fs::create_directories(folder);

  const std::string number = std::to_string(seed);
  step("A procedure: a unit turned by hand between 40 rests.", {"procedure", "hand-held", "--poses", "40", "--seed", number, "-o", procedure.string()});
  step("A virtual MEMS unit goes through it; truth.json keeps what the calibration has to find.",
       {"simulate", procedure.string(), "-o", session.string(), "--seed", number});
  step("Calibrate from the recording alone: no rig, no steps, no initial values.", {"calibrate", session.string(), "--method", "handheld", "-o", calibration.string()});
  step("Compare with the truth, in sigmas.", {"compare", calibration.string(), (session / "truth.json").string()});
  step("Apply it: rates in rad/s and specific forces in m/s^2.", {"compensate", calibration.string(), session.string(), "-o", (folder / "compensated.csv").string()});
  fmt::print("\nEverything is in {}\n", fs::absolute(folder).lexically_normal().string());
}

}  // namespace

void add_demo(CLI::App& app) {
  struct Arguments {
    std::string folder = "imulab-demo";
    std::uint64_t seed = 1;
  };
  const auto a = std::make_shared<Arguments>();
  CLI::App* const verb = app.add_subcommand("demo", "Simulate, calibrate, compare with the truth, compensate: no input needed");
  verb->add_option("-o,--output", a->folder, "where the files go")->capture_default_str();
  verb->add_option("--seed", a->seed, "another seed, another unit and other noise")->capture_default_str();
  verb->callback([a] { demo(a->folder, a->seed); });
}

}  // namespace imulab::command
