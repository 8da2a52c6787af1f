// The command line: it parses by the tables of the verbs, and turns exceptions into exit codes. One source knows CLI11.
#pragma once

#include "imulab/formats/text/json.hpp"
#include "imulab/tasks/verb.hpp"

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace imulab::command {

/// Runs one command line (without the program's name, which is how it was started). 0 done; 1 the data do not support the request; 2 the command or
/// an input file is wrong.
int run(std::vector<std::string> arguments, const std::string& program = "imulab");
/// What to type to start this program again: its path, where it was started by one.
const std::string& program_name();
/// The same of a verb's work that was done in parts: the answer of the whole, from their files, by the command in them and `own` options. Throws what
/// `run` turns into exit codes.
void join_parts(std::vector<std::string> command, const std::vector<std::string>& own, const std::vector<std::string>& parts);

/// A result for people, on standard output: the one way there, which shows what would steer a terminal. On a terminal a verdict at its begin has a
/// color.
void print(const std::string& text, std::FILE* out = stdout);

/// A result for programs, as it is.
void print_json(const std::string& text);
/// An object that is no answer of a task: with its conclusion at its begin, like those.
void print_json(const JsonFields& object, const Conclusion& conclusion, const std::vector<std::string>& warnings = {});

/// Warnings go to standard error, one a line, as "imulab: warning: ...", after what was printed before.
void warn(const std::string& text);

void warn_each(const std::vector<std::string>& texts);

/// Shows an answer: its warnings, its page where --report names one, then its table and `closing`, or its JSON; not where standard output already has
/// the file of -o. Throws Unsupported with its shortcomings.
void show(const Answer& answer, const ShowOptions& o, const std::string& closing = "");
/// The closing line about the file of -o: "written: FILE", or that there is none.
std::string written_text(const std::string& output, const std::string& otherwise = "not saved: no -o FILE was given");

/// Something done without being asked for: on standard error like a warning, as "imulab: ...".
void note(const std::string& text);

/// The error that ends the command: on standard error, as "imulab: ...".
void complain(const std::string& text);

/// Declares the verb of these options, which does `run`.
template <class Options>
void add(Verb& command, void (*run)(const Options&)) {
  const auto o = std::make_shared<Options>();
  declare(command, *o).does = [o, run] { run(*o); };
}

// One a verb, defined in the file of that name, or in verbs.cpp where its work is one task.
void add_procedure(Verb& app);
void add_simulate(Verb& app);
void add_inspect(Verb& app);
void add_noise(Verb& app);
void add_calibrate(Verb& app);
void add_compensate(Verb& app);
void add_compare(Verb& app);
void add_verify(Verb& app);
void add_extrinsics(Verb& app);
void add_predict(Verb& app);
void add_plan(Verb& app);
void add_live(Verb& app);
void add_trajectory(Verb& app);
void add_navigate(Verb& app);
void add_budget(Verb& app);
void add_export(Verb& app);
void add_import(Verb& app);
void add_report(Verb& app);
void add_join(Verb& app);
void add_fleet(Verb& app);
void add_fleet_upkeep(Verb& fleet);  // check, merge, export, remove
void add_demo(Verb& app);

}  // namespace imulab::command
