// The command line: each verb declares its options here and says what it does; `run` turns exceptions into exit codes. One source knows CLI11.
#pragma once

#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace imulab::command {

/// Runs one command line (without the program's name). 0 done; 1 the data do not support the request; 2 the command or an input file is wrong.
int run(std::vector<std::string> arguments);

/// A result for people, on standard output: the one way there, which shows what would steer a terminal. On a terminal a verdict at its begin has a
/// color.
void print(const std::string& text, std::FILE* out = stdout);

/// A result for programs, as it is.
void print_json(const std::string& text);

/// Warnings go to standard error, one a line, as "imulab: warning: ...", after what was printed before.
void warn(const std::string& text);

/// What was done without being asked for: on standard error like a warning, as "imulab: ...".
void note(const std::string& text);

/// What ends the command: on standard error, as "imulab: ...".
void complain(const std::string& text);

struct UsedOptions;  // of a verb: those that name files

/// An option of a verb. Each call changes it and returns it again.
class Option {
 public:
  Option required();
  Option takes_several(int at_least);  ///< values, any number from this on
  Option repeats();                    ///< one value each time
  Option one_of(const std::vector<std::string>& names);
  Option in_range(double least, double most, bool whole = false);
  Option check(const std::function<std::string(const std::string& text)>& problem);  ///< what is wrong with the text; empty: nothing
  Option show_default();                                                             ///< in --help
  Option excludes(Option other);
  Option reads();    ///< its values name files that are read, or sessions; see files.hpp
  Option writes();   ///< its value names a file that is written
  Option creates();  ///< its value names a folder that is made
  bool given() const;

 private:
  friend class Verb;
  explicit Option(CLI::Option* option, std::shared_ptr<UsedOptions> used) : option_(option), used_(std::move(used)) {}
  CLI::Option* option_;
  std::shared_ptr<UsedOptions> used_;
};

/// A verb. Values and what it does must outlive the declaration: a callback keeps what it captures.
class Verb {
 public:
  explicit Verb(CLI::App* app);
  Verb verb(const std::string& name, const std::string& summary);
  /// Names as in "-o,--output FILE", where FILE is what --help calls the value, or a name without a dash for a value in its place. The value has a
  /// type that command.cpp lists.
  template <class Value>
  Option option(const std::string& names, Value& value, const std::string& help);
  Option flag(const std::string& names, bool& value, const std::string& help);
  void needs_verb();                              ///< one of its own
  void example(const std::string& command_line);  ///< for --help; several calls give several
  /// The work. May throw Error (exit code 2) or Unsupported (1).
  void does(std::function<void()> work);

 private:
  CLI::App* app_;
  std::shared_ptr<UsedOptions> used_;
};

// One a verb, defined in the file of that name.
void add_procedure(Verb app);
void add_simulate(Verb app);
void add_inspect(Verb app);
void add_noise(Verb app);
void add_calibrate(Verb app);
void add_compensate(Verb app);
void add_compare(Verb app);
void add_verify(Verb app);
void add_predict(Verb app);
void add_plan(Verb app);
void add_live(Verb app);
void add_trajectory(Verb app);
void add_navigate(Verb app);
void add_budget(Verb app);
void add_export(Verb app);
void add_import(Verb app);
void add_report(Verb app);
void add_fleet(Verb app);
void add_demo(Verb app);

}  // namespace imulab::command
