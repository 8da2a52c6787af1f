// What the command says of itself: --help, manual pages and the completion of shells, all from one description of the verbs.
#pragma once

#include <string>
#include <vector>

namespace imulab::command {

struct OptionDescription {
  std::vector<std::string> names;  ///< "-o", "--output"; none for a value in its place
  std::string value;               ///< its name, "FILE"; empty for a flag
  std::string help;
  std::string initial;               ///< default; empty: none to tell
  std::vector<std::string> choices;  ///< the only values, if they are limited to these
  bool required = false, several = false;
};

struct VerbDescription {
  std::string name;  ///< "imulab procedure hand-held"
  std::string summary;
  std::string group;                  ///< the heading under which it is listed
  std::vector<std::string> examples;  ///< command lines
  std::vector<OptionDescription> options;
  std::vector<VerbDescription> verbs;
};

/// For a terminal of 80 columns.
std::string help_text(const VerbDescription& verb);

/// A manual page in roff, for section 1.
std::string manual_page(const VerbDescription& verb, const std::string& version);

/// What a shell sources to complete the command line. `shell` is one of `completion_shells`.
std::string completion(const VerbDescription& command, const std::string& shell);
inline const std::vector<std::string> completion_shells{"bash", "zsh", "fish"};

}  // namespace imulab::command
