// imulab help
#include "apps/imulab/command.hpp"
#include "apps/imulab/help.hpp"
#include "imulab/core/nearest_name.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace imulab::command {

namespace {

/// A page of the verb, imulab-fleet-add.1, and of each of its own verbs.
void write_manual_pages(const Verb& verb, const std::filesystem::path& folder) {
  std::string file = verb.name + ".1";
  std::replace(file.begin(), file.end(), ' ', '-');
  write_whole(folder / file, manual_page(verb, IMULAB_VERSION));
  for (const Verb& own : verb.verbs) write_manual_pages(own, folder);
}

}  // namespace

const Verb& verb_at(const Verb& command, const std::vector<std::string>& words) {
  const Verb* at = &command;
  for (const std::string& word : words) {
    if (at->verbs.empty() || word.starts_with('-')) break;
    const auto found = std::find_if(at->verbs.begin(), at->verbs.end(), [&](const Verb& own) { return own.own_name() == word; });
    if (found == at->verbs.end()) {
      std::vector<std::string> names;
      for (const Verb& own : at->verbs) names.push_back(own.own_name());
      const std::string kind = at == &command ? "command" : at->own_name() == "procedure" ? "procedure" : at->own_name() + " command";
      throw Error(fmt::format("{} is not a {}{}", excerpt(word), kind, expected_name(word, names)));
    }
    at = &*found;
  }
  return *at;
}

void add_help(Verb& command) {
  struct Arguments {
    std::vector<std::string> verb;
    std::string manual, shell;
  };
  const auto a = std::make_shared<Arguments>();
  Verb& verb = command.verb("help", "Explain a command; write manual pages or the completion of a shell");
  verb.option("COMMAND", a->verb, "for example calibrate").takes_several(0);
  verb.option("--man FOLDER", a->manual, "write a manual page for each command into this folder");
  verb.option("--completion SHELL", a->shell, "print what this shell sources to complete command lines").one_of(completion_shells);
  verb.example("imulab help calibrate");
  verb.example("source <(imulab help --completion bash)");
  verb.does = [a, &command, &verb] {
    if (!a->shell.empty()) return print(completion(command, a->shell));
    if (a->manual.empty()) return print(help_text(a->verb.empty() ? verb : verb_at(command, a->verb)));
    std::filesystem::create_directories(a->manual);
    write_manual_pages(command, a->manual);
  };
}

}  // namespace imulab::command
