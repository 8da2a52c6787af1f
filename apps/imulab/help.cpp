#include "apps/imulab/help.hpp"

#include "imulab/core/nearest_name.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace imulab::command {

namespace {

using text::wrapped;

/// "-o, --output FILE".
std::string head(const VerbOption& o) {
  const std::string dots = o.takes_many() ? "..." : "";
  if (o.is_positional()) return o.value_name + dots;
  return fmt::format("{}{}{}{}", fmt::join(o.flags, ", "), o.value_name.empty() ? "" : " ", o.value_name, dots);
}

/// "the file to write; one of a, b (default: a)".
std::string body(const VerbOption& o) {
  std::string text = o.help;
  if (!o.choices.empty()) text += fmt::format(" [{}]", fmt::join(o.choices, ", "));
  if (!o.initial.empty()) text += fmt::format(" (default: {})", o.initial);
  return text;
}

/// A name, and beside or below it what it means.
std::string entry(const std::string& name, const std::string& meaning) {
  constexpr std::size_t column = 25;
  const std::string first = "  " + name;
  if (first.size() + 2 > column) return first + "\n" + wrapped(std::string(column, ' '), meaning);
  return wrapped(fmt::format("{:<{}}", first, column), meaning);
}

std::string list(const std::list<Verb>& verbs) {
  std::string text, group;
  for (const Verb& verb : verbs) {
    if (verb.group != group || text.empty()) text += fmt::format("\n{}\n", verb.group.empty() ? "commands" : verb.group);
    group = verb.group;
    text += entry(verb.own_name(), verb.summary);
  }
  return text;
}

std::string roff(std::string text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\\\";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  return out.starts_with('.') || out.starts_with('\'') ? "\\&" + out : out;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

// ---- completion

/// Verbs without verbs of their own, with the words that lead to them: "procedure handheld".
void add_leaves(const Verb& verb, const std::string& words, std::vector<std::pair<std::string, const Verb*>>& leaves) {
  if (verb.verbs.empty()) leaves.emplace_back(words, &verb);
  for (const Verb& own : verb.verbs) add_leaves(own, words.empty() ? own.own_name() : words + " " + own.own_name(), leaves);
}

std::string names_of(const Verb& verb) {
  std::vector<std::string> names;
  for (const VerbOption& o : verb.options) names.insert(names.end(), o.flags.begin(), o.flags.end());
  return fmt::format("{}", fmt::join(names, " "));
}

std::string verbs_of(const Verb& verb) {
  std::vector<std::string> names;
  for (const Verb& own : verb.verbs) names.push_back(own.own_name());
  return fmt::format("{}", fmt::join(names, " "));
}

/// Cases over "VERB OPTION" that give the words for an option's value.
std::string choice_cases(const Verb& command, const char* assign) {
  std::vector<std::pair<std::string, const Verb*>> leaves;
  add_leaves(command, "", leaves);
  std::string text;
  for (const auto& [words, verb] : leaves)
    for (const VerbOption& o : verb->options)
      for (const std::string& name : o.flags)
        if (!o.choices.empty()) text += fmt::format("    '{} {}') {}'{}' ;;\n", words, name, assign, fmt::join(o.choices, " "));
  return text;
}

/// Cases over the verb that give the words that may follow.
std::string word_cases(const Verb& command, const std::string& words, const char* assign) {
  std::string text = fmt::format("    '{}') {}'{}{}{}' ;;\n", words, assign, verbs_of(command), command.verbs.empty() ? "" : " ", names_of(command));
  for (const Verb& own : command.verbs) text += word_cases(own, words.empty() ? own.own_name() : words + " " + own.own_name(), assign);
  return text;
}

/// The words of the command line that name a verb, in $verb.
std::string verb_words(const Verb& command) {
  std::vector<std::string> names;
  for (const Verb& verb : command.verbs) names.push_back(verb.own_name());
  return fmt::format("      {}) verb=$word ;;\n", fmt::join(names, "|"));
}

std::string bash(const Verb& command) {
  std::string nested;
  for (const Verb& verb : command.verbs)
    for (const Verb& own : verb.verbs) nested += fmt::format("      '{0} {1}') verb='{0} {1}' ;;\n", verb.own_name(), own.own_name());
  return "# bash completion of imulab\n_imulab() {\n  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} verb='' word "
         "words=''\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n    if [ -z \"$verb\" ]; then case \"$word\" in\n" +
         verb_words(command) + "    esac; else case \"$verb $word\" in\n" + nested +
         "      *) ;;\n    esac; fi\n  done\n  case \"$verb $before\" in\n" + choice_cases(command, "words=") + "    *) case \"$verb\" in\n" +
         word_cases(command, "", "words=") +
         "    esac ;;\n  esac\n  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "  case \"$current\" in -*) ;; *) [ -n \"$verb\" ] && COMPREPLY+=($(compgen -f -- \"$current\")) ;; esac\n}\n"
         "complete -o filenames -F _imulab imulab\n";
}

std::string zsh(const Verb& command) {
  std::string nested;
  for (const Verb& verb : command.verbs)
    for (const Verb& own : verb.verbs) nested += fmt::format("      '{0} {1}') verb='{0} {1}' ;;\n", verb.own_name(), own.own_name());
  return "#compdef imulab\nlocal verb='' word list=''\nfor word in ${words[2,CURRENT-1]}; do\n  if [[ -z $verb ]]; then case $word in\n" +
         verb_words(command) + "    esac; else case \"$verb $word\" in\n" + nested +
         "      *) ;;\n    esac; fi\ndone\ncase \"$verb ${words[CURRENT-1]}\" in\n" + choice_cases(command, "list=") + "    *) case \"$verb\" in\n" +
         word_cases(command, "", "list=") + "    esac ;;\nesac\ncompadd -- ${=list}\n[[ -n $verb && ${words[CURRENT]} != -* ]] && _files\n";
}

std::string quoted(std::string text) {
  for (std::size_t at = 0; (at = text.find('\'', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return "'" + text + "'";
}

std::string fish(const Verb& command) {
  std::string text = "# fish completion of imulab\n";
  for (const Verb& verb : command.verbs)
    text += fmt::format("complete -c imulab -n __fish_use_subcommand -f -a {} -d {}\n", verb.own_name(), quoted(verb.summary));
  std::vector<std::pair<std::string, const Verb*>> leaves;
  add_leaves(command, "", leaves);
  for (const auto& [words, verb] : leaves) {
    const std::string seen = fmt::format("'__fish_seen_subcommand_from {}'", words.substr(words.rfind(' ') + 1));
    if (const auto space = words.find(' '); space != std::string::npos)
      text += fmt::format("complete -c imulab -n '__fish_seen_subcommand_from {}' -f -a {} -d {}\n", words.substr(0, space), words.substr(space + 1),
                          quoted(verb->summary));
    for (const VerbOption& o : verb->options) {
      if (o.flags.empty()) continue;
      std::string line = fmt::format("complete -c imulab -n {}", seen);
      for (const std::string& name : o.flags) line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!o.value_name.empty()) line += o.choices.empty() ? " -r" : fmt::format(" -x -a '{}'", fmt::join(o.choices, " "));
      text += line + " -d " + quoted(o.help) + "\n";
    }
  }
  return text;
}

}  // namespace

std::string usage(const Verb& verb) {
  std::string text;
  for (const VerbOption& o : verb.options)
    if (o.is_positional()) text += o.is_required ? " " + head(o) : fmt::format(" [{}]", head(o));
  for (const VerbOption& o : verb.options)
    if (!o.is_positional() && o.is_required) text += fmt::format(" {} {}", o.flags.back(), o.value_name);
  return verb.name + text + (verb.verbs.empty() ? " [options]" : verb.does ? " [COMMAND]" : " COMMAND");
}

std::string help_text(const Verb& verb) {
  std::string text = wrapped("", verb.summary) + "\n" + wrapped("usage: ", usage(verb)) + list(verb.verbs);
  std::string values, options;
  for (const VerbOption& o : verb.options) (o.is_positional() ? values : options) += entry(head(o), body(o));
  text += (values.empty() ? "" : "\n" + values) + "\noptions\n" + options;
  if (!verb.examples.empty()) text += fmt::format("\nexample{}\n", verb.examples.size() == 1 ? "" : "s");
  for (const std::string& example : verb.examples) text += "  " + example + "\n";
  return text;
}

std::string manual_page(const Verb& verb, const std::string& version) {
  std::string title = verb.name;
  std::replace(title.begin(), title.end(), ' ', '-');
  std::string text = fmt::format(".TH {} 1 \"\" \"imulab {}\" \"User commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}\n", upper(title), version,
                                 roff(title), roff(verb.summary), roff(usage(verb)));
  if (!verb.verbs.empty()) text += ".SH COMMANDS\n";
  for (const Verb& own : verb.verbs) text += fmt::format(".TP\n.B {}\n{}\n", roff(own.own_name()), roff(own.summary));
  text += ".SH OPTIONS\n";
  for (const VerbOption& o : verb.options) text += fmt::format(".TP\n.B {}\n{}\n", roff(head(o)), roff(body(o)));
  if (!verb.examples.empty()) text += ".SH EXAMPLES\n.nf\n";
  for (const std::string& example : verb.examples) text += roff(example) + "\n";
  if (!verb.examples.empty()) text += ".fi\n";
  return text +
         ".SH EXIT STATUS\n0: done. 1: the data do not support what was asked; what could be determined is still written. 2: the command or a file "
         "is "
         "wrong.\n";
}

std::string completion(const Verb& command, const std::string& shell) {
  if (shell == "fish") return fish(command);
  return shell == "zsh" ? zsh(command) : bash(command);
}

namespace {

/// Its words in small letters, with a space before and after each; "whole-unit" is one.
std::string spaced_words(std::string_view text) {
  std::string words = " ";
  for (const char c : text)
    words += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' ? static_cast<char>(std::tolower(static_cast<unsigned char>(c))) : ' ';
  return words + " ";
}

/// The option that was meant: one with the word in its name, else the one with the nearest name, else the one whose help begins with the word, or has
/// it soonest in its first clause.
std::string_view meant_option(const Verb& verb, const std::string& name) {
  constexpr std::size_t least_letters = 4, dashes = 2;
  std::vector<std::string_view> flags;
  for (const VerbOption& row : verb.options) flags.insert(flags.end(), row.flags.begin(), row.flags.end());
  if (name.size() >= least_letters + dashes)
    for (const std::string_view flag : flags)
      if (flag.find(std::string_view(name).substr(dashes)) != std::string_view::npos) return flag;
  if (const std::string_view nearest = nearest_name(name, flags); !nearest.empty()) return nearest;
  std::string words = spaced_words(name.substr(dashes));
  std::replace(words.begin(), words.end(), '-', ' ');
  std::string_view meant;
  std::size_t earliest = std::string::npos;
  for (const VerbOption& row : verb.options) {
    if (row.is_positional() || row.inherited) continue;
    const std::size_t at = spaced_words(row.value_name + " " + row.help.substr(0, row.help.find_first_of(",;:("))).find(words);
    if (at < earliest) earliest = at, meant = row.flags.back();
  }
  return meant;
}

}  // namespace

std::optional<std::string> unknown_option(const Verb& verb, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    const auto has_name = [&](const VerbOption& row) { return std::find(row.flags.begin(), row.flags.end(), name) != row.flags.end(); };
    if (name.size() <= 2 || !name.starts_with("--") || std::any_of(verb.options.begin(), verb.options.end(), has_name)) continue;
    const std::string_view meant = meant_option(verb, name);
    return fmt::format("{} is not an option of {}{}", excerpt(name), verb.name, meant.empty() ? "" : fmt::format("; did you mean {}?", meant));
  }
  return std::nullopt;
}

std::string lacking(const Verb& verb, const std::string& problem) {
  constexpr std::size_t few = 12;
  for (const VerbOption& row : verb.options)
    for (const std::string& flag : row.flags)
      if (problem.starts_with(flag + " ") && !row.choices.empty() && row.choices.size() <= few)
        return fmt::format("{}; expected one of {}; usage: {}", problem, fmt::join(row.choices, ", "), usage(verb));
  return problem + "; usage: " + usage(verb);
}

std::string option_of_file(const Verb& verb, const std::vector<std::string>& words, const std::string& problem) {
  for (const std::string& word : words)
    for (const VerbOption& row : verb.options)
      for (const std::string& flag : row.flags)
        if (row.file == VerbOption::File::read && flag.starts_with("--") && problem.ends_with(" " + word) &&
            std::filesystem::path(word).stem().string().find(flag.substr(2)) != std::string::npos)
          return fmt::format("; did you mean {} {}?", flag, excerpt(word));
  return {};
}

}  // namespace imulab::command
