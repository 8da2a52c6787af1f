#include "apps/imulab/command.hpp"

#include "apps/imulab/files.hpp"
#include "apps/imulab/help.hpp"
#include "imulab/core/build.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/memory.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/unfinished.hpp"

#include <CLI/CLI.hpp>
#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <sstream>
#include <type_traits>
#include <utility>

namespace imulab::command {

struct UsedOptions {
  std::vector<CLI::Option*> read, written, created;
};

Option Option::required() { return option_->required(), *this; }
Option Option::takes_several(int at_least) { return option_->expected(at_least, -1), *this; }
Option Option::repeats() { return option_->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll), *this; }
Option Option::one_of(const std::vector<std::string>& names) { return option_->check(CLI::IsMember(names)), *this; }
Option Option::check(const std::function<std::string(const std::string&)>& problem) { return option_->check(problem), *this; }
Option Option::show_default() { return option_->capture_default_str(), *this; }
Option Option::excludes(Option other) { return option_->excludes(other.option_), *this; }
Option Option::reads() { return used_->read.push_back(option_), *this; }
Option Option::writes() { return used_->written.push_back(option_), *this; }
Option Option::creates() { return used_->created.push_back(option_), *this; }
bool Option::given() const { return option_->count() > 0; }

namespace {

/// The whole text as a number of this type; nothing where it is none, or none that the type holds.
template <class Value>
std::optional<Value> number_in(std::string_view text) {
  Value value{};
  text = imulab::text::without_plus(text);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// What is wrong with a number; CLI11 itself takes nan and inf, and the nearest number that a type holds.
template <class Value>
std::string bad_number(const std::string& text) {
  const auto value = number_in<Value>(text);
  if constexpr (std::is_floating_point_v<Value>)
    return value && std::isfinite(*value) ? "" : excerpt(text) + "; expected a finite number";
  else
    return value ? ""
                 : fmt::format("{}; expected a whole number from {} to {}", excerpt(text), std::numeric_limits<Value>::min(),
                               std::numeric_limits<Value>::max());
}

/// What is wrong with a text that has to be a number in a range; nothing where it is one.
std::function<std::string(const std::string&)> range_check(double least, double most, bool whole) {
  return [=](const std::string& text) {
    const double value = number_in<double>(text).value_or(std::numeric_limits<double>::quiet_NaN());
    const bool good = value >= least && value <= most && (!whole || value == std::floor(value));
    return good ? "" : fmt::format("{}; expected {} from {:.10g} to {:.10g}", excerpt(text), whole ? "a whole number" : "a number", least, most);
  };
}

}  // namespace

Option Option::in_range(double least, double most, bool whole) { return check(range_check(least, most, whole)); }

namespace {

constexpr const char* summary = "Calibrate inertial measurement units, apply the calibration, and state how certain it is.";

/// "-o,--output FILE" as the names and the value's name.
std::pair<std::string, std::string> split(const std::string& names) {
  const std::size_t space = names.find(' ');
  if (space != std::string::npos) return {names.substr(0, space), names.substr(space + 1)};
  return {names, ""};
}

/// The words between braces in CLI11's name of a type: "TEXT:{a,b}".
std::vector<std::string> choices_of(const std::string& type) {
  std::vector<std::string> choices;
  const std::size_t open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return choices;
  for (std::size_t begin = open + 1; begin < close;) {
    const std::size_t end = std::min(type.find(',', begin), close);
    choices.push_back(type.substr(begin, end - begin));
    begin = end + 1;
  }
  return choices;
}

OptionDescription describe(const CLI::Option& option) {
  OptionDescription o;
  for (const std::string& name : option.get_snames()) o.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) o.names.push_back("--" + name);
  o.choices = choices_of(option.get_type_name());
  const bool takes_value = option.get_items_expected_max() > 0;
  const std::string type = option.get_type_name();
  if (takes_value) o.value = type.substr(0, type.find(':'));
  if (option.get_positional()) o.value = option.get_name(true), std::transform(o.value.begin(), o.value.end(), o.value.begin(), ::toupper);
  o.help = option.get_description();
  o.initial = option.get_default_str();
  o.required = option.get_required();
  o.several = takes_value && option.get_items_expected_max() > 1;
  return o;
}

VerbDescription describe(const CLI::App& app, const std::string& before = "") {
  VerbDescription verb{before + app.get_name(), app.get_description(), app.get_parent() == nullptr ? "" : app.get_group(), {}, {}, {}};
  if (verb.group == "Subcommands") verb.group = "";
  std::istringstream lines(app.get_footer());
  for (std::string line; std::getline(lines, line);) verb.examples.push_back(line);
  for (const CLI::Option* option : app.get_options({})) verb.options.push_back(describe(*option));
  for (const CLI::App* root = app.get_parent(); root != nullptr; root = root->get_parent())
    if (root->get_parent() == nullptr)
      verb.options.insert(verb.options.end(), {describe(*root->get_option("--threads")), describe(*root->get_option("--memory"))});
  for (const CLI::App* own : app.get_subcommands([](const CLI::App*) { return true; })) verb.verbs.push_back(describe(*own, verb.name + " "));
  return verb;
}

/// "-o" rather than "--output".
std::string shortest_name(const CLI::Option& option) { return !option.get_snames().empty() ? "-" + option.get_snames().front() : option.get_name(); }

std::string name_of(const CLI::App& app) {
  return app.get_parent() == nullptr ? "" : name_of(*app.get_parent()) + app.get_parent()->get_name() + " ";
}

class Help : public CLI::FormatterBase {
 public:
  std::string make_help(const CLI::App* app, std::string, CLI::AppFormatMode) const override { return help_text(describe(*app, name_of(*app))); }
};

}  // namespace

Verb::Verb(CLI::App* app) : app_(app), used_(std::make_shared<UsedOptions>()) {}
Verb Verb::verb(const std::string& name, const std::string& about) { return Verb(app_->add_subcommand(name, about)); }
void Verb::example(const std::string& command_line) { app_->footer(app_->get_footer() + (app_->get_footer().empty() ? "" : "\n") + command_line); }

template <class Value>
Option Verb::option(const std::string& names, Value& value, const std::string& help) {
  const auto [own, value_name] = split(names);
  CLI::Option* const option = app_->add_option(own, value, help);
  option->type_name(!value_name.empty() ? value_name : std::is_arithmetic_v<Value> || std::is_same_v<Value, std::optional<double>> ? "N" : "TEXT");
  if constexpr (std::is_arithmetic_v<Value>) option->check(bad_number<Value>);
  if constexpr (std::is_same_v<Value, std::optional<double>>) option->check(bad_number<double>);
  return Option(option, used_);
}
template Option Verb::option(const std::string&, int&, const std::string&);
template Option Verb::option(const std::string&, std::uint64_t&, const std::string&);
template Option Verb::option(const std::string&, double&, const std::string&);
template Option Verb::option(const std::string&, std::string&, const std::string&);
template Option Verb::option(const std::string&, std::optional<double>&, const std::string&);
template Option Verb::option(const std::string&, std::optional<std::string>&, const std::string&);
template Option Verb::option(const std::string&, std::vector<std::string>&, const std::string&);

Option Verb::flag(const std::string& names, bool& value, const std::string& help) { return Option(app_->add_flag(names, value, help), used_); }
void Verb::needs_verb() { app_->require_subcommand(1); }
void Verb::does(std::function<void()> work) {
  app_->callback([used = used_, work = std::move(work)] {
    for (const CLI::Option* option : used->written)
      for (const std::string& file : option->results()) will_write(shortest_name(*option), file);
    for (const CLI::Option* option : used->created)
      for (const std::string& folder : option->results()) will_create(shortest_name(*option), folder);
    std::ptrdiff_t streams = 0;
    for (const CLI::Option* option : used->read) {
      const std::vector<std::string> files = option->results();
      streams += std::count(files.begin(), files.end(), "-");
      for (const std::string& file : files) will_read(file);
    }
    if (streams > 1) throw Error("-: standard input is named twice; expected it once");
    work();
  });
}

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

struct Group {
  const char* title;
  std::vector<void (*)(Verb)> verbs;
};

/// `imulab help`.
void add_help(CLI::App& app) {
  struct Arguments {
    std::vector<std::string> verb;
    std::string manual, shell;
  };
  const auto a = std::make_shared<Arguments>();
  Verb verb = Verb(&app).verb("help", "Explain a command; write manual pages or the completion of a shell");
  verb.option("COMMAND", a->verb, "for example calibrate").takes_several(0);
  verb.option("--man FOLDER", a->manual, "write a manual page for each command into this folder");
  verb.option("--completion SHELL", a->shell, "print what this shell sources to complete command lines").one_of(completion_shells);
  verb.example("imulab help calibrate");
  verb.example("source <(imulab help --completion bash)");
  verb.does([a, &app] {
    if (!a->shell.empty()) return fmt::print("{}", completion(describe(app), a->shell));
    if (!a->manual.empty()) {
      std::filesystem::create_directories(a->manual);
      const VerbDescription all = describe(app);
      write_whole(std::filesystem::path(a->manual) / "imulab.1", manual_page(all, IMULAB_VERSION));
      for (const VerbDescription& v : all.verbs)
        write_whole(std::filesystem::path(a->manual) / fmt::format("imulab-{}.1", v.name.substr(v.name.rfind(' ') + 1)),
                    manual_page(v, IMULAB_VERSION));
      return;
    }
    const CLI::App* at = &app;
    if (const std::string unknown = unknown_command(app, a->verb); !unknown.empty()) throw Error(unknown);
    for (const std::string& name : a->verb) at = at->get_subcommand(name);
    fmt::print("{}", at->help());
  });
}

std::string version_text() {
  const Build b = build();
  std::string text = fmt::format("imulab {}\ncompiler  {}, {}, {}\n", b.version, b.compiler, b.type, b.processor);
  for (const bool with : {true, false})
    for (const BuildOption& option : b.options)
      if (option.built_with == with) text += fmt::format("{:8}  {:6}  {}\n", with ? "with" : "without", option.name, option.purpose);
  text.pop_back();
  return text;
}

void expect_output_written() {
  std::cout.flush();
  if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0) throw Error("standard output cannot be written: the result is lost");
}

/// All verbs and what they take.
void declare(CLI::App& app, std::optional<ThreadLimit>& threads, std::optional<MemoryLimit>& memory) {
  app.name("imulab");
  app.formatter(std::make_shared<Help>());
  app.fallthrough();
  app.require_subcommand(1);
  app.set_version_flag("--version", version_text, "print the version, and what imulab was built with");
  app.add_option_function<std::size_t>(
         "--threads", [&](std::size_t n) { threads.emplace(n); }, "work on at most this many processors; the results do not depend on it")
      ->type_name("N")
      ->check(range_check(1, 1024, true));
  app.add_option_function<double>(
         "--memory", [&](double mb) { memory.emplace(static_cast<std::uint64_t>(1e6 * mb)); },
         "refuse work that would take more memory (all there is)")
      ->type_name("MB")
      ->check(range_check(1e-3, 1e9, false));
  add_demo(Verb(&app));
  add_help(app);
  for (CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) verb->group("start here");
  for (const Group& group :
       {Group{"calibrate", {add_inspect, add_calibrate, add_live, add_noise, add_compare, add_verify, add_report, add_fleet}},
        Group{"before the measurement", {add_procedure, add_simulate, add_predict, add_plan}},
        Group{"use a calibration", {add_compensate, add_export, add_import}}, Group{"in navigation", {add_trajectory, add_navigate, add_budget}}})
    for (const auto add : group.verbs) {
      add(Verb(&app));
      app.get_subcommands([](const CLI::App*) { return true; }).back()->group(group.title);
    }
}

int parse_and_do(std::vector<std::string> arguments) {
  remove_unfinished_on_signals();
  forget_files();
  std::optional<ThreadLimit> threads;
  std::optional<MemoryLimit> memory;
  CLI::App app{summary};
  declare(app, threads, memory);
  if (arguments.empty()) {
    fmt::print(stderr, "{}", app.help());
    return 2;
  }
  if (const std::string unknown = unknown_command(app, arguments); !unknown.empty()) throw Error(unknown);
  std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) throw Error(fmt::format("{} (--help explains the command)", e.what()));
    app.exit(e);  // help and version
  }
  expect_output_written();
  return 0;
}

}  // namespace

int run(std::vector<std::string> arguments) {
  try {
    return parse_and_do(std::move(arguments));
  } catch (const Unsupported& e) {
    complain(e.what());
    return 1;
  } catch (const MemoryError& e) {
    complain(fmt::format("{} (--memory MB sets another limit)", e.what()));
    return 2;
  } catch (const std::bad_alloc&) {
    complain("out of memory; expected less data, or a machine with more memory");
    return 2;
  } catch (const std::exception& e) {  // Error, and what the system refuses
    complain(e.what());
    return 2;
  }
}

}  // namespace imulab::command
