// The tables of the manual that follow from tables of the program have exactly its names and words (page_tables.hpp).
//
// With IMULAB_WRITE_DOCS in the environment (./dev docs --write), they are written into the pages instead of compared.
#include "tests/page_tables.hpp"

#include "imulab/exchange.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/session_keys.hpp"
#include <cstdlib>
#include <functional>

namespace imulab {
namespace {

namespace fs = std::filesystem;

/// An option of a verb, from the verb's manual page.
struct OptionOfVerb {
  std::string verb, head, meaning;
  bool is_same(const OptionOfVerb& other) const { return head == other.head && meaning == other.meaning; }
  std::string command() const { return verb.substr(0, verb.find(' ')); }
};

std::string without_roff(std::string text) {
  static const std::regex escape(R"(\\(&|.))");
  text = std::regex_replace(text, std::regex(R"(^\\&)"), "");
  return std::regex_replace(text, escape, "$1");
}

std::vector<OptionOfVerb> options_of_all_verbs() {
  const TemporaryFolder folder;
  EXPECT_EQ(run_imulab(folder, "help --man man").exit_code, 0);
  std::set<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder / "man")) files.insert(entry.path());
  std::vector<OptionOfVerb> options;
  for (const fs::path& file : files) {
    const std::vector<std::string> lines = page_lines(read_text(file));
    std::smatch name;  // "imulab fleet add", with which the usage begins
    const std::string usage = without_roff(lines.at(4));
    std::regex_search(usage, name, std::regex("^imulab( [a-z][a-z0-9-]*)*"));
    const std::string verb = usage.substr(std::min<std::size_t>(7, name.length()), name.length() - std::min<std::size_t>(7, name.length()));
    if (verb.empty() || verb == "help") continue;
    const auto section = std::find(lines.begin(), lines.end(), ".SH OPTIONS"), end = std::find(section, lines.end(), ".SH EXAMPLES");
    for (auto line = section + 1; line + 2 < end; line += 3) options.push_back({verb, without_roff(line[1].substr(3)), without_roff(line[2])});
  }
  return options;
}

std::string option_head(const std::string& head) { return std::regex_replace(as_code(head), std::regex(", "), "`, `"); }

using Options = std::vector<OptionOfVerb>;

/// Each option once, with the verbs that have it in these words.
std::vector<std::pair<OptionOfVerb, std::vector<std::string>>> grouped(const Options& options) {
  std::vector<std::pair<OptionOfVerb, std::vector<std::string>>> groups;
  for (const OptionOfVerb& option : options) {
    auto same = std::find_if(groups.begin(), groups.end(), [&](const auto& group) { return group.first.is_same(option); });
    if (same == groups.end()) same = groups.insert(groups.end(), {option, {}});
    same->second.push_back(option.verb);
  }
  return groups;
}

/// Options that several commands have in the same words.
bool is_shared(const OptionOfVerb& option, const Options& all) {
  return std::any_of(all.begin(), all.end(), [&](const OptionOfVerb& o) { return o.is_same(option) && o.command() != option.command(); });
}

PageTable shared_options(const Options& all) {
  std::set<std::string> verbs;
  for (const OptionOfVerb& option : all) verbs.insert(option.verb);
  PageTable table{{"option", "verbs", "meaning"}};
  for (const auto& [option, of] : grouped(all))
    if (is_shared(option, all))
      table.push_back(
          {option_head(option.head), of.size() == verbs.size() ? "all" : fmt::format("{}", fmt::join(of, ", ")), cell_text(option.meaning)});
  return table;
}

/// The other options of a command and of its own verbs.
PageTable options_of(const std::string& command, const Options& all) {
  Options own;
  for (const OptionOfVerb& option : all)
    if (option.command() == command && !is_shared(option, all)) own.push_back(option);
  const bool nested = std::any_of(own.begin(), own.end(), [&](const OptionOfVerb& o) { return o.verb != command; });
  PageTable table{nested ? std::vector<std::string>{"option", "of `" + command + "`", "meaning"} : std::vector<std::string>{"option", "meaning"}};
  for (const auto& [option, of] : grouped(own)) {
    std::vector<std::string> row{option_head(option.head), cell_text(option.meaning)}, verbs;
    for (const std::string& verb : of) verbs.push_back(as_code(verb.substr(std::min(verb.size(), command.size() + 1))));
    if (nested) row.insert(row.begin() + 1, fmt::format("{}", fmt::join(verbs, ", ")));
    if (option.head.starts_with("--to ")) row.back() = "the program that reads the file: a target of the table";  // which has all words
    table.push_back(row);
  }
  return table;
}

std::string listed_as_code(Quantity quantity, bool increment) {
  std::vector<std::string> names;
  for (const std::string_view name : unit_names(quantity, increment)) names.push_back(as_code(std::string(name)));
  return fmt::format("{}", fmt::join(names, ", "));
}

PageTable units() {
  return {{"`output`", "`unit` of gyro", "`unit` of accel"},
          {"`rate`", listed_as_code(Quantity::gyro, false), listed_as_code(Quantity::accel, false)},
          {"`increment`", listed_as_code(Quantity::gyro, true), listed_as_code(Quantity::accel, true)}};
}

PageTable effect_sizes() {
  PageTable table{{"effect", "meaning", "key in `[imu]`", "strategic", "navigation", "tactical", "mems"}};
  for (const Effect& effect : effects()) {
    std::vector<std::string> row{as_code(std::string(effect.name)), std::string(effect.words), as_code(std::string(effect.declared()))};
    for (const double size : effect.prior) row.push_back(fmt::format("{:g} {}", size, effect.unit_name));
    table.push_back(row);
  }
  return table;
}

PageTable targets() {
  PageTable table{{"target", "contents", "file of `--to all`"}};
  for (const ExportTarget& target : export_targets())
    table.push_back({as_code(std::string(target.name)), cell_text(std::string(target.summary)), as_code(std::string(target.file))});
  return table;
}

/// Numbers and names that a finding has are "..."; endings of words that depend on a number are left out.
PageTable codes() {
  PageTable table{{"code", "severity", "text"}};
  static const std::regex ending(R"(([a-z])\{\})"), values(R"(\{[^{}]*\}( ?\{[^{}]*\})*)");
  for (const FindingRow& row : finding_table) {
    const std::string words = row.words == "{}" ? "" : std::regex_replace(std::string(row.words), ending, "$1");
    table.push_back({as_code(std::string(row.name)), std::string(to_string(row.severity)), cell_text(std::regex_replace(words, values, "..."))});
  }
  return table;
}

std::map<std::string, PageTable> tables_of_program() {
  const Options all = options_of_all_verbs();
  std::map<std::string, PageTable> tables{
      {"options of several verbs", shared_options(all)}, {"units", units()}, {"effects", effect_sizes()}, {"targets", targets()}, {"codes", codes()}};
  for (const OptionOfVerb& option : all) tables.try_emplace("options of " + option.command(), options_of(option.command(), all));
  return tables;
}

std::vector<fs::path> pages_with_tables() {
  std::vector<fs::path> pages;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(IMULAB_SOURCE) / "docs"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  return pages;
}

TEST(PageTables, HaveTheWordsOfTheProgram) {
  const std::map<std::string, PageTable> tables = tables_of_program();
  const bool writes = std::getenv("IMULAB_WRITE_DOCS") != nullptr;
  std::set<std::string> missing;
  for (const auto& [name, table] : tables)
    if (table.size() > 1) missing.insert(name);
  for (const fs::path& file : pages_with_tables()) {
    std::vector<std::string> page = page_lines(read_text(file));
    const std::vector<MarkedPart> parts = marked_parts(page);
    for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
      if (part->kind != "table") continue;
      ASSERT_TRUE(tables.contains(part->name)) << file << ": " << part->name;
      missing.erase(part->name);
      const auto begin = page.begin() + static_cast<std::ptrdiff_t>(part->begin), end = page.begin() + static_cast<std::ptrdiff_t>(part->end);
      const std::vector<std::string> lines = table_lines(tables.at(part->name));
      if (!writes) EXPECT_EQ(std::vector<std::string>(begin, end), lines) << file << ": ./dev docs --write writes the table: " << part->name;
      if (writes) page.insert(page.erase(begin, end), lines.begin(), lines.end());
    }
    if (writes) std::ofstream(file, std::ios::binary) << fmt::format("{}\n", fmt::join(page, "\n"));
  }
  EXPECT_THAT(missing, testing::IsEmpty()) << "are in no page";
}

TEST(PageTables, HaveTheKeysOfTheProgram) {
  TableKeys keys = keys_of_session_files();
  keys.merge(keys_of_missions()), keys.merge(keys_of_laboratories()), keys.merge(keys_of_data_sheets()), keys.merge(columns_of_stores());
  for (const Effect& effect : effects()) keys["effects"].insert({std::string(effect.name), false});
  for (const ExportTarget& target : export_targets()) keys["targets"].insert({std::string(target.name), false});
  for (const std::string& key : declaration_keys()) keys["--set"].insert({key, false});
  for (const fs::path& file : pages_with_tables()) {
    const std::vector<std::string> page = page_lines(read_text(file));
    TableKeys shown;
    for (const MarkedPart& part : marked_parts(page))
      if (part.kind == "keys") add_keys(page, part, shown);
    for (const auto& [name, own] : shown) {
      EXPECT_EQ(own, keys[name]) << file << ": " << name;
      keys.erase(name);
    }
  }
  EXPECT_THAT(keys, testing::IsEmpty()) << "are in no page";
}

TEST(PageTables, AWrongTableIsFound) {
  const std::vector<std::string> page{"<!-- keys: [imu] -->", "", "| key | a |", "| --- | --- |", "| `name`\\*, `serial` | `grade` |", "",
                                      "<!-- end -->"};
  const std::vector<MarkedPart> parts = marked_parts(page);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].name, "[imu]");
  TableKeys keys;
  add_keys(page, parts[0], keys);
  EXPECT_EQ(keys, (TableKeys{{"[imu]", {{"name", true}, {"serial", false}}}}));
  add_keys({"", "| table | key |", "| --- | --- |", "| `a`, `b` | `x` |", "| | `y`\\* |", "| (root) | `z` |"}, {"keys", "of", 0, 6}, keys = {});
  EXPECT_EQ(keys, (TableKeys{{"of (root)", {{"z", false}}}, {"of a", {{"x", false}, {"y", true}}}, {"of b", {{"x", false}, {"y", true}}}}));
  EXPECT_THAT(table_lines({{"a", "b"}, {"1", ""}}), testing::ElementsAre("", "| a | b |", "| --- | --- |", "| 1 | |", ""));
  EXPECT_EQ(cell_text("the session's [truth]"), "the session's [truth]");
  EXPECT_EQ(option_head("-o, --outages EVERY,LENGTH"), "`-o`, `--outages EVERY,LENGTH`");
  EXPECT_EQ(cell_text("with --part, \"n <= 2\" | <y> [a, b] (default: a)"), "with `--part`, `n <= 2` \\| &lt;y>. Values: a, b (default: a)");
}

}  // namespace
}  // namespace imulab
