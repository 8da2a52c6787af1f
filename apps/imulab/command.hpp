// The command line: each verb adds itself to the application; `run` turns exceptions into exit codes.
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace imulab::command {

/// Runs one command line (without the program's name). 0 done; 1 the data do not support what was asked; 2 the command or an input file is wrong.
int run(std::vector<std::string> arguments);

/// Warnings go to standard error, one a line, as "imulab: warning: ...".
void warn(const std::string& text);

// One a verb, defined in the file of that name; the callback does the work and may throw Error (2) or Unsupported (1).
void add_procedure(CLI::App& app);
void add_simulate(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_compensate(CLI::App& app);
void add_compare(CLI::App& app);
void add_predict(CLI::App& app);
void add_plan(CLI::App& app);
void add_trajectory(CLI::App& app);
void add_navigate(CLI::App& app);
void add_budget(CLI::App& app);
void add_export(CLI::App& app);
void add_demo(CLI::App& app);

}  // namespace imulab::command
