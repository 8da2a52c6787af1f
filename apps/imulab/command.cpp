#include "apps/imulab/command.hpp"

#include "imulab/core/error.hpp"

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <optional>

namespace imulab::command {

Option Option::required() { return Option(option_->required()); }
Option Option::takes_several(int at_least) { return Option(option_->expected(at_least, -1)); }
Option Option::one_of(const std::vector<std::string>& names) { return Option(option_->check(CLI::IsMember(names))); }
Option Option::in_range(double least, double most) { return Option(option_->check(CLI::Range(least, most))); }
Option Option::check(const std::function<std::string(const std::string&)>& problem) { return Option(option_->check(problem)); }
Option Option::show_default() { return Option(option_->capture_default_str()); }
Option Option::excludes(Option other) { return Option(option_->excludes(other.option_)); }
bool Option::given() const { return option_->count() > 0; }

Verb Verb::verb(const std::string& name, const std::string& summary) { return Verb(app_->add_subcommand(name, summary)); }

template <class Value>
Option Verb::option(const std::string& names, Value& value, const std::string& help) {
  return Option(app_->add_option(names, value, help));
}
template Option Verb::option(const std::string&, int&, const std::string&);
template Option Verb::option(const std::string&, std::uint64_t&, const std::string&);
template Option Verb::option(const std::string&, double&, const std::string&);
template Option Verb::option(const std::string&, std::string&, const std::string&);
template Option Verb::option(const std::string&, std::optional<double>&, const std::string&);
template Option Verb::option(const std::string&, std::optional<std::string>&, const std::string&);
template Option Verb::option(const std::string&, std::vector<std::string>&, const std::string&);

Option Verb::flag(const std::string& names, bool& value, const std::string& help) { return Option(app_->add_flag(names, value, help)); }
void Verb::needs_verb() { app_->require_subcommand(1); }
void Verb::does(std::function<void()> work) { app_->callback(std::move(work)); }

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
  CLI::App app{"Calibrate inertial measurement units, apply the calibration, and state how certain it is."};
  app.name("imulab");
  app.require_subcommand(1);
  app.set_version_flag("--version", "imulab " IMULAB_VERSION);
  for (const auto add : {add_procedure, add_simulate, add_calibrate, add_compensate, add_compare, add_verify, add_predict, add_plan, add_live,
                         add_trajectory, add_navigate, add_budget, add_export, add_demo})
    add(Verb(&app));
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
