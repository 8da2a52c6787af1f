#include "apps/imulab/command.hpp"
#include "imulab/core/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <exception>

namespace imulab::command {

void warn(const std::string& text) { fmt::print(stderr, "imulab: warning: {}\n", text); }

namespace {

/// CLI11 says of a misspelt command only that one is required: name it, and those there are.
std::string unknown_command(const CLI::App& app, const std::vector<std::string>& arguments) {
  const CLI::App* at = &app;
  for (const std::string& argument : arguments) {
    const auto commands = at->get_subcommands([](const CLI::App*) { return true; });
    if (commands.empty() || argument.starts_with('-')) return {};
    const auto found = std::find_if(commands.begin(), commands.end(), [&](const CLI::App* command) { return command->get_name() == argument; });
    if (found == commands.end()) {
      std::string names;
      for (const CLI::App* command : commands) names += (names.empty() ? "" : ", ") + command->get_name();
      return fmt::format("{} is not a {}, expected one of {}", argument, at == &app ? "command" : at->get_name(), names);
    }
    at = *found;
  }
  return {};
}

}  // namespace

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
  add_predict(app);
  add_plan(app);
  add_trajectory(app);
  add_navigate(app);
  add_budget(app);
  add_export(app);
  add_demo(app);
  app.failure_message(
      [](const CLI::App*, const CLI::Error& e) { return fmt::format("imulab: {}\nRun with --help for more information.\n", e.what()); });
  try {
    if (const std::string unknown = unknown_command(app, arguments); !unknown.empty()) throw Error(unknown);
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
