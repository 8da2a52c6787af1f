// The command explains itself: --help, manual pages and the completion of shells, all from the tables of the verbs.
#pragma once

#include "imulab/tasks/verb.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab::command {

/// For a terminal of 80 columns.
std::string help_text(const Verb& verb);

/// A manual page in roff, for section 1.
std::string manual_page(const Verb& verb, const std::string& version);

/// The text that a shell sources to complete the command line. `shell` is one of `completion_shells`.
std::string completion(const Verb& command, const std::string& shell);
inline const std::vector<std::string> completion_shells{"bash", "zsh", "fish"};

/// Declares `imulab help`.
void add_help(Verb& command);

/// The verb that the words lead to. Throws Error for a word that is none of its verbs (CLI11 says only that one is required); it ends at an option.
const Verb& verb_at(const Verb& command, const std::vector<std::string>& words);

/// "imulab report CALIBRATION [options]".
std::string usage(const Verb& verb);

/// What the command line lacks, with the usage, and with what is allowed where that are a few words.
std::string lacking(const Verb& verb, const std::string& problem);

/// "; did you mean --noise noise.json?": of a file in no place that is like an option for files. Empty where there is none.
std::string option_of_file(const Verb& verb, const std::vector<std::string>& words, const std::string& problem);

/// Says what was meant by the first word that looks like an option and is none: "--reprot is not an option; did you mean --report?".
std::optional<std::string> unknown_option(const Verb& verb, const std::vector<std::string>& words);

}  // namespace imulab::command
