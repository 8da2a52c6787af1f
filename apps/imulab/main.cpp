#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <exception>

namespace imulab::command {

void warn(const std::string& text) { fmt::print(stderr, "imulab: warning: {}\n", text); }


int run(std::vector<std::string> arguments) {
  CLI::App app{"The laboratory for inertial measurement units: calibrate, compensate, and know how sure you are."};
  app.name("imulab");
  app.require_subcommand(1);
  app.set_version_flag("--version", "imulab " IMULAB_VERSION);
  add_procedure(app);
  add_simulate(app);
  add_calibrate(app);
  add_compensate(app);
  add_compare(app);
  add_demo(app);
  try {
    std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
    app.parse(std::move(arguments));
    return 0;
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  } catch (const Unsupported& e) {
    fmt::print(stderr, "imulab: {}\n", e.what());
    return 1;
  } catch (const std::exception& e) {  // Error, and what the system refuses
    fmt::print(stderr, "imulab: {}\n", e.what());
    return 2;
  }
}

}  // namespace imulab::command

int main(int argc, char** argv) { return imulab::command::run({argv + 1, argv + argc}); }
