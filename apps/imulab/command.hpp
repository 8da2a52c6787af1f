// The command line: each verb adds itself to the application; main turns exceptions into exit codes.
#pragma once

#include <CLI/CLI.hpp>

namespace imulab::command {

/// 0 done; 1 the data do not support what was asked; 2 the command or an input file is wrong.
struct ExitCode {
  int value;
};

/// Warnings go to standard error, one a line, as "imulab: warning: ...".
void warn(const std::string& text);

// One a verb, defined in the file of that name; the callback does the work and may throw Error (2), Unsupported (1) or ExitCode.
void add_procedure(CLI::App& app);
void add_simulate(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_compensate(CLI::App& app);
void add_compare(CLI::App& app);
void add_demo(CLI::App& app);

}  // namespace imulab::command
