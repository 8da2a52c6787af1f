#include "apps/imulab/command.hpp"

#include "apps/imulab/files.hpp"
#include "apps/imulab/help.hpp"
#include "apps/imulab/sessions.hpp"
#include "imulab/core/memory.hpp"
#include "imulab/core/nearest_name.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/formats/text/unfinished.hpp"
#include "imulab/parallel.hpp"
#include "imulab/version.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

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
#include <type_traits>
#include <utility>

namespace imulab::command {

namespace {

/// The whole text as a number of this type; nothing where it is none, or none that the type holds.
template <class Value>
std::optional<Value> number_in(std::string_view text) {
  Value value{};
  text = imulab::text::without_plus(text);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// Says what is wrong with a number; CLI11 itself takes nan and inf, and the nearest number that a type holds.
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

/// A function that says what is wrong with a text that has to be a number in a range.
std::function<std::string(const std::string&)> range_check(double least, double most, bool whole) {
  return [=](const std::string& text) {
    const double value = number_in<double>(text).value_or(std::numeric_limits<double>::quiet_NaN());
    const bool good = value >= least && value <= most && (!whole || value == std::floor(value));
    return good ? "" : fmt::format("{}; expected {} from {:.10g} to {:.10g}", excerpt(text), whole ? "a whole number" : "a number", least, most);
  };
}

constexpr const char* summary = "Calibrate inertial measurement units, apply the calibration, and state how certain it is.";

/// "-o" rather than "--output".
const std::string& shortest_name(const VerbOption& option) { return option.is_positional() ? option.names : option.flags.front(); }

class Help : public CLI::FormatterBase {
 public:
  explicit Help(const Verb& verb) : verb_(verb) {}
  std::string make_help(const CLI::App*, std::string, CLI::AppFormatMode) const override { return help_text(verb_); }

 private:
  const Verb& verb_;
};

/// An option and its row.
struct ParsedOption {
  VerbOption* row;
  CLI::Option* option;
};

template <class Value>
CLI::Option* added_option(CLI::App& app, const VerbOption& row, Value& value) {
  return app.add_option(row.names, value, row.help);
}

/// One that adds to the list of another option, which is declared before and so is set before.
CLI::Option* added_option(CLI::App& app, const VerbOption& row, std::vector<std::string>& value) {
  if (row.prefix.empty()) return app.add_option(row.names, value, row.help);
  return app.add_option_function<std::vector<std::string>>(
      row.names,
      [&value, prefix = row.prefix](const std::vector<std::string>& given) {
        for (const std::string& text : given) value.push_back(prefix + text);
      },
      row.help);
}

ParsedOption parsed(CLI::App& app, VerbOption& row) {
  CLI::Option* const option = std::visit(
      [&](auto* value) {
        using Value = std::decay_t<decltype(*value)>;
        if constexpr (std::is_same_v<Value, bool>) {
          return app.add_flag(row.names, *value, row.help);
        } else {
          CLI::Option* const made = added_option(app, row, *value)->type_name(row.is_positional() ? "TEXT" : row.value_name);
          if constexpr (std::is_arithmetic_v<Value>) made->check(bad_number<Value>);
          if constexpr (std::is_same_v<Value, std::optional<double>>) made->check(bad_number<double>);
          return made;
        }
      },
      row.value);
  if (row.is_required) option->required();
  if (row.is_repeated) option->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  if (row.at_least) option->expected(*row.at_least, -1);
  if (!row.choices.empty())
    option->check([&row](const std::string& text) {
      const bool known = std::find(row.choices.begin(), row.choices.end(), text) != row.choices.end();
      return known ? "" : excerpt(text) + " is not allowed" + expected_name(text, row.choices);
    });
  if (row.range) option->check(range_check((*row.range)[0], (*row.range)[1], row.is_whole));
  if (row.problem_of) option->check(row.problem_of);
  return {&row, option};
}

/// A file's folder is there already, but for one that -o names, which the verb may make.
void check_place(const std::vector<ParsedOption>& options, const std::string& file) {
  const std::string folder = std::filesystem::path(file).parent_path().lexically_normal().string();
  for (const auto& [row, option] : options)
    for (const std::string& made : option->results())
      if (row->names.ends_with("--output") && !folder.empty() && made != file &&
          (folder + "/").starts_with((std::filesystem::path(made) / "").lexically_normal().string()))
        return;
  expect_place_for(file);
}

/// Checks the files that options name, then does the work of the verb.
void do_work(const Verb& verb, const std::vector<ParsedOption>& options) {
  using enum VerbOption::File;
  int streams = 0;
  for (const auto& [row, option] : options)
    if (row->names == "--force" && option->count() > 0) replace_files();
  for (const VerbOption::File use : {written, created, read})
    for (const auto& [row, option] : options) {
      row->given = option->count() > 0;
      if (row->given && row->names.ends_with("--verbose")) show_evidence(true);
      if (row->file != use) continue;
      for (const std::string& file : option->results()) {
        const std::string part = verb.sharing != nullptr && row->names.ends_with("--output") ? verb.sharing->part : "";
        if (part.starts_with("auto"))
          will_fill(shortest_name(*row), file);
        else if (use == written || (use == created && !part.empty()))
          will_write(shortest_name(*row), file), check_place(options, file);
        else if (use == created)
          will_create(shortest_name(*row), file);
        if (use == read) will_read(file), streams += file == "-";
      }
    }
  for (const auto& [row, option] : options)
    if (row->keeps)
      for (const std::string& file : option->results()) expect_free(shortest_name(*row), file);
  if (streams > 1) throw Error("-: standard input is named twice; expected it once");
  try {
    verb.does();
  } catch (const NotJson& e) {  // a file in the place of another
    const std::string text = e.what();
    for (const auto& [row, option] : options)
      for (const std::string& file : option->results())
        if (row->is_positional() && text.starts_with(input_name(file) + ":")) throw Error(text + "; usage: " + usage(verb));
    throw;
  }
}

/// Everything below a verb as CLI11 has it.
void declare_to(CLI::App& app, Verb& verb) {
  app.formatter(std::make_shared<Help>(verb));
  std::vector<ParsedOption> options;
  for (VerbOption& row : verb.options) {
    if (row.inherited) continue;
    options.push_back(parsed(app, row));
    for (const VerbOption* const other : row.excluded)
      for (const auto& [before, option] : options)
        if (before == other) options.back().option->excludes(option);
  }
  for (Verb& own : verb.verbs) declare_to(*app.add_subcommand(own.own_name(), own.summary), own);
  if (!verb.does) app.require_subcommand(1);
  if (verb.does)
    app.callback([&verb, &app, options] {
      if (app.get_subcommands().empty()) do_work(verb, options);
    });
}

struct Group {
  const char* title;
  std::vector<void (*)(Verb&)> verbs;
};

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

/// Options that every verb has.
struct CommonOptions {
  bool help = false, version = false, verbose = false, force = false;
  std::uint64_t threads = 0;
  double memory_mb = 0;
};

/// Their rows, for help: CLI11 has them once.
void add_common(Verb& verb, CommonOptions& o, bool top = true) {
  const auto inherit = [&](const std::string& names, auto& value, const std::string& help) {
    verb.option(names, value, help).of_command().inherited = true;
    return std::prev(verb.options.end());
  };
  verb.options.splice(verb.options.begin(), verb.options, inherit("-h,--help", o.help, "print this help and exit"));
  if (top) inherit("--version", o.version, "print the version, and what imulab was built with");
  inherit("--threads N", o.threads, "use at most this many processors; results are equal to the last bit");
  const auto has = [&](const char* flag) {
    return std::ranges::any_of(verb.options, [&](const VerbOption& row) { return row.names.find(flag) != std::string::npos; });
  };
  if (has("--topic") && !has("--verbose"))  // it reads recordings
    inherit("-v,--verbose", o.verbose, "also print why a recording is read as it is");
  if (std::ranges::any_of(verb.options, [](const VerbOption& row) { return row.keeps; }))
    verb.option("--force", o.force, "replace existing files").of_command();
  inherit("--memory MB", o.memory_mb, "refuse recordings that need more memory (default: physical memory)");
  for (Verb& own : verb.verbs) add_common(own, o, false);
}

/// All verbs and what they take.
void declare(Verb& command) {
  add_demo(command);
  add_help(command);
  for (Verb& verb : command.verbs) verb.group = "start here";
  for (const Group& group :
       {Group{"calibrate", {add_inspect, add_calibrate, add_live, add_extrinsics, add_noise, add_compare, add_verify, add_report, add_fleet}},
        Group{"before the measurement", {add_procedure, add_simulate, add_predict, add_plan, add_join}},
        Group{"use a calibration", {add_compensate, add_export, add_import}}, Group{"in navigation", {add_trajectory, add_navigate, add_budget}}})
    for (const auto add : group.verbs) {
      add(command);
      command.verbs.back().group = group.title;
    }
}

/// `parts`: files of the parts of the work, in its place.
int parse_and_do(std::vector<std::string> arguments, const std::vector<std::string>& parts = {}) {
  remove_unfinished_on_signals();
  forget_files();
  show_evidence(false);
  Verb command("imulab", summary);
  declare(command);
  CommonOptions common;
  add_common(command, common);
  CLI::App app{summary, command.name};
  app.fallthrough();
  declare_to(app, command);
  app.set_version_flag("--version", version_text);
  std::optional<ThreadLimit> threads;
  std::optional<MemoryLimit> memory;
  app.add_option_function<std::size_t>("--threads", [&](std::size_t n) { threads.emplace(n); })->type_name("N")->check(range_check(1, 1024, true));
  app.add_option_function<double>("--memory", [&](double mb) { memory.emplace(static_cast<std::uint64_t>(1e6 * mb)); })
      ->type_name("MB")
      ->check(range_check(1e-3, 1e9, false));
  app.add_flag_callback("-v,--verbose", [] { show_evidence(true); });
  if (arguments.empty()) {
    print(help_text(command), stderr);
    return 2;
  }
  for (std::size_t i = 1; i < arguments.size(); ++i)
    if (arguments[i - 1] == "procedure" && arguments[i] == "hand-held") arguments[i] = "handheld";  // as it was called before
  const Verb& verb = verb_at(command, arguments);
  if (!parts.empty() && verb.sharing == nullptr) throw Error(parts.front() + ": is a part of another version's work");
  if (!parts.empty()) verb.sharing->joined = parts;
  for (const std::string& part : parts) will_read(part);
  const std::vector<std::string> given = arguments;
  std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() != 0) {
      const bool lacks = dynamic_cast<const CLI::RequiredError*>(&e) != nullptr;
      const std::string otherwise = lacks ? lacking(verb, e.what()) : e.what() + option_of_file(verb, given, e.what());
      throw Error(unknown_option(verb, given).value_or(otherwise) + " (--help explains the command)");
    }
    app.exit(e);  // help and version
  }
  expect_output_written();
  return 0;
}

}  // namespace

void warn_each(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) warn(text);
}

void show(const Answer& answer, const ShowOptions& o, const std::string& closing) {
  warn_each(answer.warnings);
  if (!o.report.empty()) write_whole(o.report, answer.page());
  if (o.output != "-" && o.json) print_json(answer.document());
  if (o.output != "-" && !o.json) print(answer.text(o.verbose) + closing);
  if (!answer.shortcomings.empty()) throw Unsupported(answer.shortcomings);
}

std::string written_text(const std::string& output, const std::string& otherwise) {
  return output.empty() ? otherwise : "written: " + one_line(output);
}

void join_parts(std::vector<std::string> command, const std::vector<std::string>& own, const std::vector<std::string>& parts) {
  Verb all("imulab", summary);
  declare(all);
  expect_command_of_part(verb_at(all, command), command, parts.front());
  command.insert(command.end(), own.begin(), own.end());
  parse_and_do(std::move(command), parts);
}

namespace {
std::string started_as = "imulab";
}
const std::string& program_name() { return started_as; }

int run(std::vector<std::string> arguments, const std::string& program) {
  if (program.find('/') != std::string::npos) started_as = program;
  try {
    return parse_and_do(std::move(arguments));
  } catch (const Unsupported& e) {
    complain(e.what());
    return 1;
  } catch (const OptionError& e) {
    complain(fmt::format("--{}: {}", e.option(), e.what()));
    return 2;
  } catch (const MemoryError& e) {
    complain(fmt::format("{} (--memory MB sets another limit)", e.what()));
    return 2;
  } catch (const std::bad_alloc&) {
    complain("out of memory; expected less data, or a machine with more memory");
    return 2;
  } catch (const std::filesystem::filesystem_error& e) {
    std::error_code gone;
    static_cast<void>(std::filesystem::current_path(gone));
    complain(gone ? "the current folder is not there any more; expected one that is: cd to it"
                  : fmt::format("{}: {}", e.path1().string(), e.code().message()));
    return 2;
  } catch (const std::exception& e) {  // Error, and what the system refuses
    complain(e.what());
    return 2;
  }
}

}  // namespace imulab::command
