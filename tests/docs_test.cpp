// Every command in the documentation works: the ```console blocks of a page of README.md and docs/**/*.md run in order in one new folder.
//
// console_page.hpp says what a block is. A picture that a page shows is one that commands made, by its file's name.
//
// With IMULAB_WRITE_DOCS in the environment (./dev docs --write), outputs and pictures are written into the pages instead of compared.
// ctest: docs
#include <gmock/gmock.h>

#include "tests/console_page.hpp"
#include "tests/run_command.hpp"
#include <algorithm>
#include <cctype>
#include <functional>
#include <regex>
#include <set>
#include <vector>

namespace imulab {
namespace {

namespace fs = std::filesystem;

struct PageRun {
  std::vector<std::string> wrong{};  ///< what differs from the page, one text per command
  std::set<std::string> files{};     ///< names of those that the commands made
  std::string anew{};                ///< the page with what the commands print now
};

/// Files in a folder and below it, but not behind links.
std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.file_size() > 0) files.push_back(entry.path());
  return files;
}

/// `use` gets each file that the commands made.
PageRun run_page(const std::string& page, const std::string& name, const std::function<void(const fs::path&)>& use = {}) {
  const TemporaryFolder folder;
  for (const char* part : {"docs", "tests", "examples"})
    fs::create_directory_symlink(fs::path(IMULAB_SOURCE) / part, folder / part);  // as in the repository
  const std::string path = "export PATH=\"" + fs::path(command_path()).parent_path().string() + ":$PATH\"; ";
  PageRun run;
  const std::vector<DocumentedCommand> commands = commands_of(page);
  std::vector<ShownOutput> outputs(commands.size());
  for (std::size_t k = 0; k < commands.size(); ++k) {
    const DocumentedCommand& command = commands[k];
    if (command.text.starts_with("./dev")) continue;  // builds the project
    const CommandResult result = run_shell(folder, path + command.text);
    std::string wrong;
    if (result.exit_code != command.exit_code) wrong += "\nexit code " + std::to_string(result.exit_code) + "\n" + result.errors;
    outputs[k] = compared(command, result.output, result.errors);
    for (const std::string& difference : outputs[k].differences) wrong += "\n" + difference;
    if (!wrong.empty()) run.wrong.push_back(name + ":" + std::to_string(command.line + 1) + ": " + command.text + wrong);
  }
  run.anew = written_anew(page, commands, outputs);
  for (const fs::path& file : files_below(folder.path())) {
    run.files.insert(file.filename().string());
    if (use) use(file);
  }
  return run;
}

std::vector<std::string> wrong_commands(const std::string& page, const std::string& name) { return run_page(page, name).wrong; }

/// Pictures that a page shows, relative to its folder.
std::vector<fs::path> pictures_of(const std::string& page) {
  std::vector<fs::path> files;
  static const std::regex picture(R"(!\[[^\]]*\]\(([^)\s]+)\))");
  for (std::sregex_iterator at(page.begin(), page.end(), picture), end; at != end; ++at) files.emplace_back((*at)[1].str());
  return files;
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
  const bool writes = std::getenv("IMULAB_WRITE_DOCS") != nullptr;
  std::size_t commands = 0;
  std::set<std::string> made;
  for (const fs::path& page : all_pages()) {
    const std::string text = read_text(page);
    commands += commands_of(text).size();
    const PageRun run = run_page(text, page.filename().string(), [&](const fs::path& file) {
      for (const fs::path& picture : pictures_of(text))
        if (writes && picture.filename() == file.filename()) fs::copy_file(file, page.parent_path() / picture, fs::copy_options::overwrite_existing);
    });
    if (writes && run.anew != text) std::ofstream(page, std::ios::binary) << run.anew;
    if (!writes) EXPECT_THAT(run.wrong, testing::IsEmpty());
    made.insert(run.files.begin(), run.files.end());
    if (page.filename() == "README.md") continue;  // shows others' pictures, too
    for (const fs::path& picture : pictures_of(text))
      EXPECT_TRUE(run.files.contains(picture.filename().string())) << page << " does not make " << picture;
  }
  EXPECT_GE(commands, 5u);  // the tutorial by hand alone has more
  for (const fs::path& picture : pictures_of(read_text(fs::path(IMULAB_SOURCE) / "README.md")))
    EXPECT_TRUE(made.contains(picture.filename().string())) << picture;
}

TEST(Documentation, EveryLinkExists) {
  for (const fs::path& page : all_pages()) EXPECT_THAT(broken_links(read_text(page), page.parent_path()), testing::IsEmpty()) << page;
}

TEST(Documentation, ABrokenLinkIsFound) {
  const fs::path docs = fs::path(IMULAB_SOURCE) / "docs/reference";
  EXPECT_THAT(broken_links("[a](conventions.md) [b](conventions.md#glossary) [c](https://example.org/#x)", docs), testing::IsEmpty());
  EXPECT_THAT(broken_links("[a](convention.md) [b](conventions.md#nothing)", docs), testing::SizeIs(2));
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

TEST(Documentation, AWrongOutputIsFoundAndWrittenAnew) {
  const std::string command = "$ printf 'chi2 %s (x1 of 42)\\nkept\\n  2.00  m\\nend\\n' 22.5\n";
  const auto run = [&](const std::string& output) { return run_page("text\n```console\n" + command + output + "```\nmore\n", "p"); };
  for (const char* good : {"", "...\n", "chi2 22.5 (x1 of 42)\nkept\n2 m\nend\n", "chi2  22.4 (x1 of 42)\n...\n  2.00 m\nend\n",
                           "chi2 22.5 ...\n...\nend\n", "# tolerance 20 %\nchi2 19 (x1 of 42)\n...\n", "...\nkept\n  ...\n"})
    EXPECT_THAT(run(good).wrong, testing::IsEmpty()) << good;
  for (const char* bad : {"chi2 22.5 (x1 of 42)\n", "chi2 22.2 (x1 of 42)\n...\n", "chi2 -22.5 (x1 of 42)\n...\n", "chi2 22.5 (x2 of 42)\n...\n",
                          "chi3 22.5 ...\n...\n", "...\nkept\nend\n", "...\nend\n...\nkept\n", "# tolerance 20 %\nchi2 17 (x1 of 42)\n...\n",
                          "kept\n...\n", "...\nend\nlost\n", "...\nelse\n...\n"})
    EXPECT_THAT(run(bad).wrong, testing::SizeIs(1)) << bad;
  EXPECT_EQ(run("chi2 19 ...\n# tolerance 2 %\nkept all\n...\nlost\n").anew,
            "text\n```console\n" + command + "chi2 22.5 ...\n# tolerance 2 %\nkept\n...\n```\nmore\n");
  EXPECT_EQ(run("kept\n  4 m\n").anew, "text\n```console\n" + command + "chi2 22.5 (x1 of 42)\nkept\n  2.00  m\nend\n```\nmore\n");
  EXPECT_EQ(run("").anew, "text\n```console\n" + command + "```\nmore\n");
}

TEST(Documentation, AWrongMessageIsFoundAndWrittenAnew) {
  const std::string command = "$ echo 'imulab: warning: up to 0.835 deg/s at 100 deg/s' >&2\n";
  const auto run = [&](const std::string& error) { return run_page("```console\n" + command + error + "```\n", "p"); };
  for (const char* good : {"", "imulab: warning: up to 0.832 deg/s at 100 deg/s\n", "imulab: warning: up to 0.835 ...\n"})
    EXPECT_THAT(run(good).wrong, testing::IsEmpty()) << good;
  for (const char* bad : {"imulab: warning: up to 0.82 deg/s at 100 deg/s\n", "imulab: warning: up to 0.835 deg/s\n", "imulab: error: lost\n"})
    EXPECT_THAT(run(bad).wrong, testing::SizeIs(1)) << bad;
  EXPECT_EQ(run("imulab: warning: up to 2 deg/s at ...\n# exit code 0\n").anew,
            "```console\n" + command + "imulab: warning: up to 0.835 deg/s at ...\n# exit code 0\n```\n");
}

}  // namespace
}  // namespace imulab
