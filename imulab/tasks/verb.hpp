// A verb: its options in one table, and the form of its answer. The command parses by the table; help, manual pages, completion and the keywords of
// the Python module are read from it.
#pragma once

#include "imulab/core/part_file.hpp"
#include "imulab/core/shared_work.hpp"
#include "imulab/error.hpp"
#include "imulab/model/conclusion.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace imulab {

/// An option is wrong: an Error to which the caller adds how the user spells options.
class OptionError : public Error {
 public:
  OptionError(std::string option, const std::string& text) : Error(text), option_(std::move(option)) {}
  const std::string& option() const { return option_; }  ///< its long name without dashes

 private:
  std::string option_;
};

/// Returns what `f` returns. An Error that it throws becomes one of this option.
template <class F>
decltype(auto) errors_of_option(const std::string& option, const F& f) {
  try {
    return f();
  } catch (const Error& e) {
    throw OptionError(option, e.what());
  }
}

/// One row of the table. Each call below changes the row and returns it again.
class VerbOption {
 public:
  using Value = std::variant<bool*, int*, std::uint64_t*, double*, std::string*, std::optional<double>*, std::optional<std::string>*,
                             std::vector<std::string>*>;
  enum class File { none, read, written, created };

  VerbOption(const std::string& its_names, Value its_value, std::string its_help);

  VerbOption& required() { return is_required = true, *this; }
  VerbOption& takes_several(int least) { return at_least = least, *this; }  ///< values, any number from this on
  VerbOption& repeats() { return is_repeated = true, *this; }               ///< one value each time
  /// Of a list that another option fills: its value is added as KEY=value.
  VerbOption& declares(const std::string& key) { return prefix = key + "=", repeats(); }
  VerbOption& one_of(std::vector<std::string> texts) { return choices = std::move(texts), *this; }
  VerbOption& in_range(double least, double most, bool whole = false) { return range = {{least, most}}, is_whole = whole, *this; }
  /// `problem` says what is wrong with the text of a value; an empty answer: nothing.
  VerbOption& check(std::function<std::string(const std::string&)> problem) { return problem_of = std::move(problem), *this; }
  VerbOption& show_default();  ///< in help
  VerbOption& excludes(VerbOption& other) { return excluded.push_back(&other), *this; }
  VerbOption& reads() { return file = File::read, *this; }                           ///< its values name files that are read, or sessions
  VerbOption& writes() { return file = File::written, *this; }                       ///< its value names a file that is written
  VerbOption& keeps_existing() { return keeps = true, *this; }                       ///< only --force replaces a file that it names
  VerbOption& creates() { return file = File::created, *this; }                      ///< its value names a folder that is made, but of a --part
  VerbOption& called(std::string name) { return keyword = std::move(name), *this; }  ///< another keyword in Python than its long name
  VerbOption& of_command() { return keyword.clear(), *this; }                        ///< Python does not take it

  bool is_positional() const { return flags.empty(); }
  bool is_flag() const { return std::holds_alternative<bool*>(value); }
  bool takes_many() const { return std::holds_alternative<std::vector<std::string>*>(value) && !is_repeated; }

  std::string names;               ///< "-o,--output" or "session"
  std::vector<std::string> flags;  ///< "-o", "--output"; none for a value in its place
  std::string value_name;          ///< "FILE"; empty for a flag
  Value value;                     ///< the value that it sets, which holds the default
  std::string help, keyword, initial;
  std::string prefix;                ///< of each value in the list
  std::vector<std::string> choices;  ///< the only values, if they are limited to these
  std::optional<std::array<double, 2>> range;
  std::function<std::string(const std::string&)> problem_of;
  std::vector<VerbOption*> excluded;
  std::optional<int> at_least;
  File file = File::none;
  bool is_required = false, is_repeated = false, is_whole = false;
  bool keeps = false;
  bool given = false;      ///< on the command line
  bool inherited = false;  ///< the command itself takes it; the row is for help
};

struct SharingOptions;

/// A verb, or the command itself. Its values must outlive it.
class Verb {
 public:
  explicit Verb(std::string its_name, std::string its_summary) : name(std::move(its_name)), summary(std::move(its_summary)) {}
  Verb(const Verb&) = delete;
  Verb& operator=(const Verb&) = delete;

  /// A verb of this one, which begins with the examples that this one has.
  Verb& verb(const std::string& its_name, const std::string& its_summary) {
    Verb& own = verbs.emplace_back(name + " " + its_name, its_summary);
    own.examples = examples;
    return own;
  }
  /// Names as in "-o,--output FILE", where FILE is how help calls the value, or a name without a dash for a value in its place.
  template <class Value>
  VerbOption& option(const std::string& names, Value& value, const std::string& help) {
    return options.emplace_back(names, &value, help);
  }
  void example(const std::string& command_line) { examples.push_back(command_line); }
  /// Throws Error where there is no such option.
  const VerbOption& at(const std::string& flag) const;
  std::string own_name() const { return name.substr(name.rfind(' ') + 1); }

  std::string name;  ///< "imulab procedure handheld"
  std::string summary;
  std::string group;                  ///< the heading under which it is listed
  std::vector<std::string> examples;  ///< command lines
  std::list<VerbOption> options;
  SharingOptions* sharing = nullptr;  ///< of a work that can be divided
  std::list<Verb> verbs;              ///< one of them has to be named, unless the verb does something itself
  std::function<void()> does;         ///< may throw Error (exit code 2) or Unsupported (1)
};

/// Gets each warning of work that goes on after it.
using Tell = std::function<void(const std::string& warning)>;

/// Options with which the command shows an answer.
struct ShowOptions {
  std::string output, report;
  bool json = false, verbose = false;
};

/// Options of verbs whose work can be done in parts, and resumed (docs/reference/fleet-store.md).
struct SharingOptions {
  std::string checkpoint, part;
  std::vector<std::string> joined;            ///< files of all parts, in place of the work
  std::vector<PartReader::Source> sources{};  ///< the same in memory
  const Verb* verb = nullptr;                 ///< whose options make the same work again

  /// True for a part, and where parts are joined.
  bool is_divided() const { return !part.empty() || !joined.empty() || !sources.empty(); }
  /// None where the work is done at one go. Throws Error for a part that is not there.
  std::optional<Sharing> sharing() const;
};

/// A command line of what was given to a verb, but for what only shows the answer: words that end with a byte 0.
std::string command_of(const Verb& verb);
/// Throws Error, with the part's name, for options that command_of never writes: a part is a file of somebody, and names no file that is written.
void expect_command_of_part(const Verb& verb, const std::vector<std::string>& words, const std::string& part);

// Rows that several verbs have.
VerbOption& report_option(Verb& verb, std::string& file);
VerbOption& json_option(Verb& verb, bool& json, const std::string& help = "print the result as JSON");
VerbOption& seed_option(Verb& verb, std::uint64_t& seed, const std::string& help = "random seed; the same seed gives the same result");
VerbOption& store_option(Verb& verb, std::string& store);
VerbOption& prior_option(Verb& verb, std::string& store);
VerbOption& allow_undetermined_option(Verb& verb, bool& allowed);
void sharing_options(Verb& verb, SharingOptions& o);

/// The answer of a verb, whatever its result is: the command, the Python module and a page show it without knowing the result.
struct Answer {
  std::function<std::string()> json;               ///< the data
  std::function<std::string(bool details)> table;  ///< for a terminal
  std::function<std::string()> page = {};          ///< HTML with pictures; empty: there is none
  std::vector<std::string> warnings = {};
  std::vector<std::string> told = {};  ///< warnings that were shown while it was made; its JSON has them first
  std::string shortcomings = {};       ///< why it is not what was asked for; empty: it is
  Conclusion conclusion = {};
  std::function<std::string()> printed = {};  ///< what --json prints where that is not the data with the conclusion at its begin

  /// Of its conclusion; without one, the first line of its table.
  std::string headline() const;
  std::vector<std::string> all_warnings() const;
  /// What --json prints: the data with verdict, headline and warnings. Lists stay as they are.
  std::string document() const;
  /// What a terminal shows: the verdict with its headline and the requirements, then the table; without a verdict the table, which begins with its
  /// own headline.
  std::string text(bool details) const;
};

/// An answer and its result.
template <class Data>
struct AnswerOf : Answer {
  std::shared_ptr<const Data> data;
};

}  // namespace imulab
