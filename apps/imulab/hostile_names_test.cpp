// Names that others choose (units, stations, files) in everything that the command prints and writes: they open no row, steer no terminal, turn no
// direction of writing, and no spreadsheet runs them.
#include "imulab/formats/text/csv_field.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <filesystem>
#include <string>

namespace imulab {
namespace {

namespace fs = std::filesystem;

struct HostileNames : testing::Test {
  TemporaryFolder folder;
  static constexpr const char* name = "=1\nFORGED\t\x1b[31m\u202eX";

  /// `rows`: in a page, line ends are spaces, and messages are no tables.
  static void expect_harmless(const std::string& text, const std::string& what, bool rows) {
    EXPECT_EQ(text.find('\x1b'), std::string::npos) << what;
    EXPECT_EQ(text.find("\u202e"), std::string::npos) << what;
    if (rows) {
      EXPECT_THAT("\n" + text, testing::Not(testing::ContainsRegex("\n *FORGED"))) << what;
    }
    if (what.ends_with(".csv")) {
      EXPECT_THAT("\n" + text, testing::Not(testing::ContainsRegex("[\n,;] *\"?=1"))) << what;
    }
  }
  CommandResult expect_harmless_run(const std::string& arguments) {
    CommandResult result = run_imulab(folder, arguments);
    EXPECT_LE(result.exit_code, 1) << arguments << "\n" << result.errors;
    expect_harmless(result.output, arguments, true);
    expect_harmless(result.errors, arguments, false);
    return result;
  }
};

TEST_F(HostileNames, OpenNoRowAndSteerNothing) {
  const std::string toml = nlohmann::json(name).dump(), file = nlohmann::json("r\nFORGED\u202e.csv").dump(), quoted = std::string("'") + name + "'";
  run_imulab(folder, "procedure handheld --poses 12 -o plain.toml");
  std::string procedure = read_text(folder / "plain.toml");
  const auto replace = [&](const std::string& key, const std::string& with) {
    const std::size_t begin = procedure.find("\n" + key + " = ") + 1;
    procedure.replace(begin, procedure.find('\n', begin) - begin, with);
  };
  replace("name", "name = " + toml + "\nserial = " + toml);
  replace("file", "file = " + file);
  folder.write("p.toml", procedure);
  for (const std::string& arguments :
       {std::string("simulate p.toml -o S"), std::string("inspect S --report inspect.html"),
        std::string("calibrate S --method static -o c.json --report c.html"), std::string("compare c.json S/truth.json --report compare.html"),
        std::string("compensate c.json S --allow-undetermined -o out --report out.html"),
        std::string("predict p.toml --method handheld --report p.html"), std::string("export c.json --allow-undetermined --to all -o exports"),
        std::string("report c.json --certificate -o certificate.html"), "fleet add c.json --store f.db --station " + quoted + " --operator " + quoted,
        std::string("fleet list --store f.db"), "fleet show " + quoted + " --store f.db", std::string("fleet stats --store f.db --report f.html"),
        std::string("fleet export --csv --store f.db -o f.csv"), std::string("fleet list --json --store f.db"),
        std::string("fleet stats --json --store f.db")})
    expect_harmless_run(arguments);
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    const std::string kind = entry.path().extension().string();
    if (!entry.is_regular_file() || kind == ".db" || entry.path().filename() == "p.toml") continue;
    expect_harmless(read_text(entry.path()), entry.path().string(), kind != ".html");
  }
  EXPECT_EQ(nlohmann::json::parse(read_text(folder / "c.json"))["serial"], name);  // in data the name is whole
  EXPECT_THAT(read_text(folder / "f.csv"), testing::HasSubstr("," + text::csv_field(name) + ","));
}

}  // namespace
}  // namespace imulab
