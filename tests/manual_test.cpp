// The form of the manual: pages of limited length, tables that render, every verb and every listed message there. page_tables_test.cpp has the tables
// that follow from the program.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <algorithm>
#include <cctype>
#include <map>
#include <numeric>
#include <regex>
#include <sstream>

namespace imulab {
namespace {

namespace fs = std::filesystem;

/// The pages of docs/ by their path in it.
std::map<std::string, std::string> manual_pages() {
  const fs::path docs = fs::path(IMULAB_SOURCE) / "docs";
  std::map<std::string, std::string> pages;
  for (const auto& entry : fs::recursive_directory_iterator(docs))
    if (entry.path().extension() == ".md") pages[fs::relative(entry.path(), docs).generic_string()] = read_text(entry.path());
  return pages;
}

/// A word has a letter or a digit: bars of tables and dashes are none.
std::size_t words_of(const std::string& text) {
  std::istringstream words(text);
  return static_cast<std::size_t>(std::count_if(std::istream_iterator<std::string>(words), {}, [](const std::string& word) {
    return std::any_of(word.begin(), word.end(), [](unsigned char c) { return std::isalnum(c) != 0; });
  }));
}

/// Without blocks of code, which a test compares with what they show.
std::string prose_of(const std::string& page) {
  std::istringstream lines(page);
  std::string prose, before;
  bool fenced = false, indented = false;
  for (std::string line; std::getline(lines, line); before = line) {
    indented = line.starts_with("    ") && (indented || before.empty());  // as Markdown has it: after an empty line
    if (line.starts_with("```"))
      fenced = !fenced;
    else if (!fenced && !indented)
      prose += line + "\n";
  }
  return prose;
}

/// Cells of a row of a table, as GitHub divides it: at bars without a backslash, in code as well.
std::size_t cells_of(const std::string& row) {
  std::size_t bars = 0;
  for (std::size_t i = 0; i < row.size(); ++i) bars += row[i] == '|' && (i == 0 || row[i - 1] != '\\');
  return bars - 1;
}

/// Rows that have another number of cells than the head of their table: two rows in one line, or a bar in a cell.
std::vector<std::string> wrong_rows(const std::string& page) {
  std::vector<std::string> wrong;
  std::istringstream lines(prose_of(page));
  std::size_t cells = 0;  // of the table that a line belongs to; 0: none
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("|")) {
      cells = 0;
    } else {
      if (cells == 0) cells = cells_of(line);
      if (cells_of(line) != cells) wrong.push_back(line);
    }
  }
  return wrong;
}

/// Without the list of references, which ends reference/grades.md.
std::string without_references(const std::string& page) { return page.substr(0, page.find("\n## References\n")); }

/// Words outside blocks of code, tables, comments and the list of references.
std::size_t words_to_read(const std::string& page) {
  std::istringstream lines(prose_of(without_references(page)));
  std::size_t words = 0;
  for (std::string line; std::getline(lines, line);)
    if (!line.starts_with("|") && !line.starts_with("<!--")) words += words_of(line);
  return words;
}

TEST(Manual, StaysWithinItsLimits) {
  std::size_t all = 0;
  for (const auto& [name, page] : manual_pages()) {
    all += words_to_read(page);
    EXPECT_LE(words_to_read(page), name.starts_with("start/") ? 520u : 1200u) << name;
  }
  for (const char* name : {"README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"})
    all += words_to_read(read_text(fs::path(IMULAB_SOURCE) / name));
  EXPECT_LE(all, 26400u);
  EXPECT_EQ(words_to_read("one, 2 - three\n| a | b |\n```text\nfour\n```\n\n    five\n\nsix\n## References\nseven\n"), 4u);
}

TEST(Manual, EveryTableRenders) {
  for (const auto& [name, page] : manual_pages()) EXPECT_THAT(wrong_rows(page), testing::IsEmpty()) << name;
  EXPECT_THAT(wrong_rows(read_text(fs::path(IMULAB_SOURCE) / "README.md")), testing::IsEmpty());
  EXPECT_THAT(wrong_rows("| a | b |\n| --- | --- |\n| 1 | `x \\| y` |\n"), testing::IsEmpty());
  EXPECT_THAT(wrong_rows("| a | b |\n| --- | --- |\n| 1 | 2 | | 3 | 4 |\n"), testing::SizeIs(1));
}

TEST(Manual, ListsEveryPage) {
  const std::map<std::string, std::string> pages = manual_pages();
  const std::string& index = pages.at("README.md");
  for (const auto& [name, page] : pages)
    if (name != "README.md") EXPECT_NE(index.find("](" + name + ")"), std::string::npos) << name;
}

TEST(Manual, HasEveryVerb) {
  const TemporaryFolder folder;
  const std::string help = run_shell(folder, "'" + command_path() + "' --help").output;
  const std::string page = manual_pages().at("reference/command.md");
  const std::regex verb("\n  ([a-z]+)  ");
  std::size_t verbs = 0;
  for (std::sregex_iterator at(help.begin(), help.end(), verb), end; at != end; ++at, ++verbs) {
    if ((*at)[1] == "help") continue;
    EXPECT_NE(page.find("\n| `" + (*at)[1].str() + "` |"), std::string::npos) << (*at)[1];
  }
  EXPECT_GE(verbs, 19u);
}

/// All sources, with the strings that a line end divides joined.
std::string source_texts() {
  std::string all, joined;
  for (const char* part : {"imulab", "apps"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(IMULAB_SOURCE) / part))
      if (entry.path().extension() == ".cpp" || entry.path().extension() == ".hpp") all += read_text(entry.path());
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t quote = std::min(all.find('"', at), all.size());
    joined.append(all, at, quote - at);
    const std::size_t next = std::min(all.find_first_not_of(" \n", quote + 1), all.size());
    const bool divided = next < all.size() && all[next] == '"' && all.find('\n', quote) < next;
    if (!divided && quote < all.size()) joined += '"';
    at = divided ? next + 1 : quote + 1;
  }
  return joined;
}

TEST(Manual, EveryListedMessageIsOneOfTheProgram) {
  const std::string sources = source_texts();
  const std::string page = manual_pages().at("reference/results.md");
  const std::size_t begin = page.find("\n## Messages\n"), end = page.find("\n## Codes\n");
  ASSERT_LT(begin, end);
  std::istringstream lines(page.substr(begin, end - begin));
  const std::regex message("^\\| `([^`]+)` \\|");
  std::size_t messages = 0;
  for (std::string line; std::getline(lines, line);) {
    std::smatch found;
    if (!std::regex_search(line, found, message)) continue;
    ++messages;
    const std::string text = std::regex_replace(found[1].str(), std::regex("\\.\\.\\."), "\n");
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part);) EXPECT_NE(sources.find(part), std::string::npos) << found[1] << ": " << part;
  }
  EXPECT_GE(messages, 35u);
}

}  // namespace
}  // namespace imulab
