#include "imulab/tasks/verb.hpp"

#include "imulab/fleet/store/server.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/results/conclusion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <type_traits>

namespace imulab {
namespace {

std::string shown_value(const VerbOption::Value& value) {
  return std::visit(
      [](const auto* of) -> std::string {
        using Type = std::decay_t<decltype(*of)>;
        if constexpr (std::is_same_v<Type, std::string>) return *of;
        if constexpr (std::is_floating_point_v<Type>) return fmt::format("{:g}", *of);
        if constexpr (std::is_integral_v<Type>) return fmt::format("{}", *of);
        return "";
      },
      value);
}

}  // namespace

VerbOption::VerbOption(const std::string& its_names, Value its_value, std::string its_help) : value(its_value), help(std::move(its_help)) {
  const std::size_t space = std::min(its_names.find(' '), its_names.size());
  names = its_names.substr(0, space);
  std::istringstream each(names);
  for (std::string flag; std::getline(each, flag, ',');)
    if (flag.starts_with('-')) flags.push_back(flag);
  keyword = is_positional() ? "" : flags.back().substr(std::min<std::size_t>(2, flags.back().size()));
  std::replace(keyword.begin(), keyword.end(), '-', '_');
  if (is_flag()) return;
  const bool text = std::holds_alternative<std::string*>(value) || std::holds_alternative<std::optional<std::string>*>(value) ||
                    std::holds_alternative<std::vector<std::string>*>(value);
  value_name = is_positional() ? names : space < its_names.size() ? its_names.substr(space + 1) : text ? "TEXT" : "N";
  if (is_positional()) std::transform(value_name.begin(), value_name.end(), value_name.begin(), ::toupper);
}

VerbOption& VerbOption::show_default() { return initial = shown_value(value), *this; }

const VerbOption& Verb::at(const std::string& flag) const {
  for (const VerbOption& option : options)
    if (std::find(option.flags.begin(), option.flags.end(), flag) != option.flags.end()) return option;
  throw Error(fmt::format("{} has no option {}", name, flag));
}

std::optional<Sharing> SharingOptions::sharing() const {
  if (checkpoint.empty() && !is_divided()) return std::nullopt;
  Sharing out{.checkpoint = checkpoint};
  std::vector<PartReader::Source> parts = sources;
  for (const std::string& file : joined) parts.push_back(PartReader::file(file));
  if (!parts.empty()) out.joined = std::make_shared<PartReader>(std::move(parts));
  if (part.empty()) return out;
  const std::string command = verb != nullptr ? command_of(*verb) : "";
  if (fleet::without_passwords(command) != command)
    throw OptionError("part", part + ": a part keeps its command; expected the store's password in ~/.pgpass or PGPASSWORD, not in --prior");
  out.part = std::make_shared<PartWriter>(errors_of_option("part", [&] { return part_named(part); }), command);
  return out;
}

std::string command_of(const Verb& verb) {
  std::string words;
  const auto add = [&](const std::string& text) { (words += text) += '\0'; };
  add(verb.own_name());
  for (const VerbOption& row : verb.options) {
    if (!row.given || row.inherited || (row.keyword.empty() && !row.is_positional())) continue;
    const bool place = row.is_positional();
    if (!place) add(row.flags.back());
    std::visit(
        [&](const auto* value) {
          using Type = std::decay_t<decltype(*value)>;
          if constexpr (std::is_same_v<Type, bool>) {
          } else if constexpr (std::is_same_v<Type, std::vector<std::string>>) {
            for (const std::string& text : *value) add(text);
          } else if constexpr (std::is_same_v<Type, std::optional<std::string>>) {
            add(value->value_or(""));
          } else if constexpr (std::is_same_v<Type, std::optional<double>>) {
            add(fmt::format("{}", value->value_or(0)));
          } else {
            const std::string text = fmt::format("{}", *value);
            add(place && text.starts_with('-') ? "./" + text : text);
          }
        },
        row.value);
  }
  return words;
}

void expect_command_of_part(const Verb& verb, const std::vector<std::string>& words, const std::string& part) {
  for (const std::string& word : words) {
    const bool number = word.size() > 1 && (word[1] == '.' || (word[1] >= '0' && word[1] <= '9'));
    const auto is_word = [&](const VerbOption& row) {
      return !row.keyword.empty() && std::find(row.flags.begin(), row.flags.end(), word) != row.flags.end();
    };
    if (word.starts_with('-') && !number && std::none_of(verb.options.begin(), verb.options.end(), is_word))
      throw Error(fmt::format("{}: its command has {}, which no part has; expected a file of --part", part, excerpt(word)));
  }
}

VerbOption& report_option(Verb& verb, std::string& file) {
  return verb.option("--report FILE", file, "also write the result as a page, one self-contained HTML file")
      .check([](const std::string& text) { return text == "-" ? "-; expected a file to write" : ""; })
      .writes()
      .of_command();
}

VerbOption& json_option(Verb& verb, bool& json, const std::string& help) { return verb.option("--json", json, help).of_command(); }

VerbOption& seed_option(Verb& verb, std::uint64_t& seed, const std::string& help) { return verb.option("--seed", seed, help).show_default(); }

VerbOption& store_option(Verb& verb, std::string& store) {
  return verb.option("--store STORE", store, "the fleet's store: a file, or postgresql://USER@HOST/DATABASE").show_default();
}

VerbOption& prior_option(Verb& verb, std::string& store) {
  return verb.option("--prior STORE", store, "a fleet's store: its mean and covariance are the prior; of terms over temperature their sizes").reads();
}

VerbOption& allow_undetermined_option(Verb& verb, bool& allowed) {
  return verb.option("--allow-undetermined", allowed, "use a calibration although the data did not determine some of its biases or matrices");
}

void sharing_options(Verb& verb, SharingOptions& o) {
  o.verb = &verb, verb.sharing = &o;
  verb.option(
          "--part K/N", o.part,
          "do only the K-th of N parts, and write it to -o FILE for imulab join; auto: K and N from Slurm, mpirun or Kubernetes; -o is then a folder")
      .of_command();
  verb.option("--checkpoint DIR", o.checkpoint, "a folder for finished work: after an interruption the same command resumes there").of_command();
}

std::string Answer::headline() const {
  if (!conclusion.headline.empty()) return conclusion.headline;
  std::istringstream lines(table(false));
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t begin = line.find_first_not_of(" \t"); begin != std::string::npos)
      return line.substr(begin, line.find_last_not_of(" \t") + 1 - begin);
  return "";
}

std::vector<std::string> Answer::all_warnings() const {
  std::vector<std::string> all = told;
  all.insert(all.end(), warnings.begin(), warnings.end());
  return all;
}

std::string Answer::document() const {
  if (printed) return printed();
  Conclusion whole = conclusion;
  whole.headline = headline();
  return with_conclusion(json(), whole, all_warnings());
}

std::string Answer::text(bool details) const {
  const std::string own = table(details);
  if (conclusion.verdict == Verdict::none) return own;
  std::string begin = text::wrapped("", conclusion_text(conclusion));
  if (own.starts_with(begin)) return own;
  if (conclusion.requirements.size() == 1) return begin + "\n" + own;  // the headline says it
  for (const RequirementResult& r : conclusion.requirements)
    begin += text::wrapped(&r == &conclusion.requirements.front() ? "  required        " : "                  ", judged_text(r));
  return begin + "\n" + own;
}

}  // namespace imulab
