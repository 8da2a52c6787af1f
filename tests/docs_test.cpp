// Every command in the documentation works: the ```console blocks of a page of README.md and docs/**/*.md run in order in one new folder.
//
// A line "$ command" is run by the shell with the built imulab in PATH ("> " continues it). "# exit code N" after it is the expected exit code (0
// if absent). Output is illustrative, but a line that begins with "imulab: " must appear on standard error. A picture that a page shows is one that
// commands made, by its file's name.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <algorithm>
#include <cctype>
#include <regex>
#include <set>
#include <vector>

namespace imulab {
namespace {

namespace fs = std::filesystem;

struct DocumentedCommand {
  std::string where, text;
  int exit_code = 0;
  std::vector<std::string> errors;
};

std::vector<DocumentedCommand> commands_of(const std::string& page, const std::string& name) {
  std::vector<DocumentedCommand> commands;
  std::istringstream lines(page);
  bool inside = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.starts_with("```")) {
      inside = line == "```console";
    } else if (inside && line.starts_with("$ ")) {
      commands.push_back({name + ":" + std::to_string(number), line.substr(2), 0, {}});
    } else if (inside && !commands.empty() && line.starts_with(">")) {
      commands.back().text.append("\n").append(line, std::min<std::size_t>(2, line.size()));
    } else if (inside && !commands.empty() && line.starts_with("# exit code ")) {
      commands.back().exit_code = std::stoi(line.substr(12));
    } else if (inside && !commands.empty() && line.starts_with("imulab: ")) {
      commands.back().errors.push_back(line);
    }
  }
  return commands;
}

struct PageRun {
  std::vector<std::string> wrong;  ///< what differs from the page, one text per command
  std::set<std::string> files;     ///< names of those that the commands made
};

/// Names of the files in a folder and below it, but not behind links.
std::set<std::string> files_below(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.file_size() > 0) names.insert(entry.path().filename().string());
  return names;
}

PageRun run_page(const std::string& page, const std::string& name) {
  const TemporaryFolder folder;
  for (const char* part : {"docs", "tests", "examples"})
    fs::create_directory_symlink(fs::path(IMULAB_SOURCE) / part, folder / part);  // as in the repository
  const std::string path = "export PATH=\"" + fs::path(command_path()).parent_path().string() + ":$PATH\"; ";
  PageRun run;
  std::vector<std::string>& wrong = run.wrong;
  for (const DocumentedCommand& command : commands_of(page, name)) {
    if (command.text.starts_with("./dev")) continue;  // builds the project
    const CommandResult result = run_shell(folder, path + command.text);
    const std::string what = command.where + ": " + command.text + "\n";
    if (result.exit_code != command.exit_code) wrong.push_back(what + "exit code " + std::to_string(result.exit_code) + "\n" + result.errors);
    for (const std::string& line : command.errors)
      if (result.errors.find(line + "\n") == std::string::npos) wrong.push_back(what + "did not say: " + line + "\nbut: " + result.errors);
  }
  run.files = files_below(folder.path());
  return run;
}

std::vector<std::string> wrong_commands(const std::string& page, const std::string& name) { return run_page(page, name).wrong; }

/// File names of the pictures that a page shows.
std::vector<std::string> pictures_of(const std::string& page) {
  std::vector<std::string> names;
  static const std::regex picture(R"(!\[[^\]]*\]\(([^)\s]+)\))");
  for (std::sregex_iterator at(page.begin(), page.end(), picture), end; at != end; ++at)
    names.push_back(fs::path((*at)[1].str()).filename().string());
  return names;
}

std::vector<fs::path> all_pages() {
  std::vector<fs::path> pages{fs::path(IMULAB_SOURCE) / "README.md"};
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(IMULAB_SOURCE) / "docs"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  return pages;
}

/// The anchors that a web page makes of the headings: "## Monte Carlo, 2nd" becomes "monte-carlo-2nd".
std::set<std::string> anchors_of(const std::string& page) {
  std::set<std::string> anchors;
  std::istringstream lines(page);
  bool code = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) code = !code;
    if (code || !line.starts_with("#")) continue;
    std::string anchor;
    for (const char c : line.substr(line.find_first_not_of("# ")))
      if (c == ' ' || c == '-')
        anchor += '-';
      else if (std::isalnum(static_cast<unsigned char>(c)) || c == '_')
        anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    anchors.insert(anchor);
  }
  return anchors;
}

/// Links of a page, relative to `folder`, to files or headings that do not exist.
std::vector<std::string> broken_links(const std::string& page, const fs::path& folder) {
  std::vector<std::string> broken;
  static const std::regex link(R"(\]\(([^)#\s]*)(?:#([^)\s]*))?\))");
  for (std::sregex_iterator at(page.begin(), page.end(), link), end; at != end; ++at) {
    const std::string target = (*at)[1], anchor = (*at)[2];
    if (target.starts_with("http")) continue;
    const fs::path file = folder / target;
    if (!fs::exists(file) || (!anchor.empty() && !anchors_of(target.empty() ? page : read_text(file)).contains(anchor))) broken.push_back(at->str());
  }
  return broken;
}

TEST(Documentation, EveryCommandRuns) {
  std::size_t commands = 0;
  std::set<std::string> made;
  for (const fs::path& page : all_pages()) {
    const std::string text = read_text(page);
    commands += commands_of(text, "").size();
    const PageRun run = run_page(text, page.filename().string());
    EXPECT_THAT(run.wrong, testing::IsEmpty());
    made.insert(run.files.begin(), run.files.end());
    if (page.filename() == "README.md") continue;  // shows others' pictures, too
    for (const std::string& picture : pictures_of(text)) EXPECT_TRUE(run.files.contains(picture)) << page << " does not make " << picture;
  }
  EXPECT_GE(commands, 5u);  // the tutorial by hand alone has more
  for (const std::string& picture : pictures_of(read_text(fs::path(IMULAB_SOURCE) / "README.md"))) EXPECT_TRUE(made.contains(picture)) << picture;
}

TEST(Documentation, EveryLinkExists) {
  for (const fs::path& page : all_pages()) EXPECT_THAT(broken_links(read_text(page), page.parent_path()), testing::IsEmpty()) << page;
}

TEST(Documentation, ABrokenLinkIsFound) {
  const fs::path docs = fs::path(IMULAB_SOURCE) / "docs/reference";
  EXPECT_THAT(broken_links("[a](glossary.md) [b](glossary.md#statistics) [c](https://example.org/#x)", docs), testing::IsEmpty());
  EXPECT_THAT(broken_links("[a](glosary.md) [b](glossary.md#nothing)", docs), testing::SizeIs(2));
  EXPECT_THAT(broken_links("# A word, or 2\n[a](#a-word-or-2)", docs), testing::IsEmpty());
}

TEST(Documentation, AWrongCommandIsFound) {
  const auto page = [](const std::string& block) { return "text\n```console\n" + block + "```\n"; };
  EXPECT_THAT(wrong_commands(page("$ imulab --version\n"), "p"), testing::IsEmpty());
  EXPECT_THAT(
      wrong_commands(
          page("$ imulab calibrate nothing --method static\nimulab: nothing: cannot be opened: No such file or directory\n# exit code 2\n"), "p"),
      testing::IsEmpty());
  EXPECT_THAT(wrong_commands(page("$ imulab calibarte\n"), "p"), testing::ElementsAre(testing::StartsWith("p:3: imulab calibarte\nexit code 2")));
  EXPECT_THAT(wrong_commands(page("$ imulab --version\n# exit code 1\n"), "p"), testing::SizeIs(1));
  EXPECT_THAT(wrong_commands(page("$ imulab --version\nimulab: warning: old\n"), "p"), testing::SizeIs(1));
  EXPECT_THAT(wrong_commands(page("$ cat > f <<END\n> a\n> END\n$ grep -q a f\n$ grep -q b f\n"), "p"), testing::SizeIs(1));
  EXPECT_THAT(wrong_commands("```\n$ imulab calibarte\n```\n", "p"), testing::IsEmpty());  // not marked console
}

}  // namespace
}  // namespace imulab
