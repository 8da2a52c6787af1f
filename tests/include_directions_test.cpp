// The rooms of the house include only rooms below them (docs/reference/architecture.md).
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace imulab {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::map<std::string, int> ranks{{"core", 0},     {"model", 1},    {"earth", 1},  {"recording", 2},  {"navigation", 3}, {"rig", 4},
                                       {"simulate", 5}, {"estimate", 5}, {"noise", 5},  {"inspection", 6}, {"formats", 7},    {"results", 8},
                                       {"fleet", 9},    {"export", 9},   {"report", 9}, {"tasks", 10},     {"apps", 11},      {"python", 11}};

/// The public headers, by the lowest of the rooms that implement them: that room and those above include them.
const std::map<std::string, std::set<std::string>> public_headers{
    {"core", {"eigen", "error", "parallel", "stop", "units", "version"}},
    {"model", {"calibration", "coefficient", "compare", "compensate", "finding", "finding_code", "frame", "grade", "outlier_filter", "sensor_model"}},
    {"earth", {"earth"}},
    {"recording", {"aid", "recording", "rests", "session"}},
    {"navigation", {"navigate"}},
    {"rig", {"procedure", "simulate"}},
    {"estimate", {"calibrate", "extrinsics", "plan", "predict"}},
    {"noise", {"noise"}},
    {"formats", {"exchange", "files"}},
    {"fleet", {"fleet"}}};

const std::set<std::string> rooms_of_files{"formats", "results", "export"};

/// The room of a path: imulab/ROOM/..., apps/... or python/...; none for anything else.
std::optional<std::string> room_of(const std::string& path) {
  static const std::regex room("^(?:imulab/([^/]+)/|(apps|python)/)"), header("^imulab/([^/]+)\\.hpp$");
  std::smatch found;
  if (std::regex_search(path, found, header))
    for (const auto& [owner, names] : public_headers)
      if (names.contains(found[1])) return owner;
  if (!std::regex_search(path, found, room)) return std::nullopt;
  const std::string name = found[1].matched ? found[1] : found[2];
  return ranks.contains(name) ? std::optional(name) : std::nullopt;
}

/// The folders of estimate/ know the kernel, the coarse solutions and the interface of a method, not each other; method.cpp itself, in no folder,
/// knows all.
std::string between_methods(const std::string& folder, const std::string& included) {
  for (const std::string& known : {folder + "/", std::string("kernel/"), std::string("coarse/"), std::string("method.hpp"),
                                   std::string("prediction.hpp"), std::string("turn_path.hpp")})
    if (folder.empty() || included.starts_with("imulab/estimate/" + known)) return "";
  return folder + " may not know another method";
}

/// The folder of a file of estimate/; empty for others.
std::string method_folder(const std::string& file) {
  static const std::regex folder("^imulab/estimate/([^/]+)/");
  std::smatch found;
  return std::regex_search(file, found, folder) ? found[1].str() : "";
}

/// The fault of one include of a file in `room`, and `folder` of estimate/; empty where nothing is.
std::string problem(const std::string& room, const std::string& folder, char quote, const std::string& included) {
  static const std::regex json_or_toml("^(nlohmann|toml\\+\\+|toml)(/|\\.|$)"), cli("^CLI/");
  if (std::regex_search(included, json_or_toml) && !rooms_of_files.contains(room)) return "only formats, results and export know TOML and JSON";
  if (std::regex_search(included, cli) && room != "apps") return "only apps knows the command line";
  const bool own = included.starts_with("imulab/") || included.starts_with("apps/") || included.starts_with("python/");
  if (!own) return quote == '"' ? "expected a path from the root, imulab/ROOM/NAME.hpp" : "";
  const auto target = room_of(included);
  if (!target) return "no such room";
  if (room == "estimate" && *target == room && included.starts_with("imulab/estimate/")) return between_methods(folder, included);
  if (*target == room || ranks.at(*target) < ranks.at(room)) return "";
  return room + " may not know " + *target;
}

/// Every include of a file that goes against the house, as "FILE:LINE: INCLUDE: why".
std::vector<std::string> violations(const std::string& file, const std::string& text) {
  static const std::regex include("^\\s*#\\s*include\\s*([\"<])([^\">]+)[\">]");
  const auto room = room_of(file);
  if (!room) return {file + ":1: in no room of the house"};
  std::vector<std::string> out;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::smatch found;
    if (!std::regex_search(line, found, include)) continue;
    const std::string why = problem(*room, method_folder(file), found[1].str()[0], found[2]);
    if (!why.empty()) out.push_back(file + ":" + std::to_string(number) + ": " + found[2].str() + ": " + why);
  }
  return out;
}

TEST(IncludeDirections, EveryFileKeepsThem) {
  namespace fs = std::filesystem;
  const fs::path root(IMULAB_SOURCE);
  std::set<std::string> rooms;
  for (const char* top : {"imulab", "apps", "python"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string file = fs::relative(entry.path(), root).generic_string();
      const auto extension = entry.path().extension();
      if ((extension != ".cpp" && extension != ".hpp") || file.ends_with("_test.cpp")) continue;
      if (entry.path().parent_path() == root / "imulab") continue;  // public headers include each other: public_headers_test.cpp
      std::ostringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      EXPECT_THAT(violations(file, text.str()), IsEmpty());
      if (const auto room = room_of(file)) rooms.insert(*room);
    }
  EXPECT_THAT(rooms, ::testing::IsSupersetOf({"core", "model", "earth", "recording", "estimate", "formats", "results", "tasks", "apps", "python"}))
      << "not all files were found";
}

TEST(IncludeDirections, AStepDownOrInsideTheRoomIsFine) {
  EXPECT_THAT(violations("imulab/formats/x.cpp",
                         "#include \"imulab/formats/file.hpp\"\n#include \"imulab/model/compare.hpp\"\n#include <nlohmann/json.hpp>\n"
                         "#include <vector>\n#include <toml++/toml.h>\n"),
              IsEmpty());
  EXPECT_THAT(violations("apps/imulab/x.cpp", "#include \"apps/imulab/command.hpp\"\n#include \"imulab/formats/file.hpp\"\n#include <CLI/CLI.hpp>\n"),
              IsEmpty());
}

TEST(IncludeDirections, AStepUpIsCaught) {
  EXPECT_THAT(violations("imulab/model/x.cpp", "#include \"imulab/core/error.hpp\"\n  #  include \"imulab/recording/session.hpp\"\n"),
              ElementsAre("imulab/model/x.cpp:2: imulab/recording/session.hpp: model may not know recording"));
  EXPECT_THAT(violations("imulab/formats/x.hpp", "#include \"apps/imulab/command.hpp\""), ElementsAre(HasSubstr("formats may not know apps")));
  EXPECT_THAT(violations("imulab/estimate/x.hpp", "#include <imulab/formats/file.hpp>"), ElementsAre(HasSubstr("estimate may not know formats")));
}

TEST(IncludeDirections, APublicHeaderIsOfTheRoomThatImplementsIt) {
  EXPECT_THAT(violations("imulab/model/x.cpp", "#include \"imulab/error.hpp\"\n#include \"imulab/calibration.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("imulab/model/x.cpp", "#include \"imulab/session.hpp\""), ElementsAre(HasSubstr("model may not know recording")));
  EXPECT_THAT(violations("imulab/model/x.cpp", "#include \"imulab/imulab.hpp\""), ElementsAre(HasSubstr("no such room")));
}

TEST(IncludeDirections, RoomsOfOneRankDoNotKnowEachOther) {
  EXPECT_THAT(violations("imulab/simulate/x.cpp", "#include \"imulab/estimate/static.hpp\""),
              ElementsAre(HasSubstr("simulate may not know estimate")));
  EXPECT_THAT(violations("imulab/earth/x.cpp", "#include \"imulab/model/frame.hpp\""), ElementsAre(HasSubstr("earth may not know model")));
}

TEST(IncludeDirections, MethodsDoNotKnowEachOther) {
  EXPECT_THAT(violations("imulab/estimate/hybrid/x.cpp", "#include \"imulab/estimate/rests/fit.hpp\""),
              ElementsAre(HasSubstr("hybrid may not know another method")));
  EXPECT_THAT(
      violations("imulab/estimate/hybrid/x.cpp", "#include \"imulab/estimate/kernel/information.hpp\"\n#include \"imulab/estimate/method.hpp\"\n"),
      IsEmpty());
  EXPECT_THAT(violations("imulab/estimate/method.cpp", "#include \"imulab/estimate/hybrid/hybrid.hpp\""), IsEmpty());
}

TEST(IncludeDirections, FileFormatsAndTheCommandLineStayInTheirRooms) {
  EXPECT_THAT(violations("imulab/model/x.cpp", "#include <nlohmann/json.hpp>"), ElementsAre(HasSubstr("only formats")));
  EXPECT_THAT(violations("apps/imulab/x.cpp", "#include <toml++/toml.hpp>"), ElementsAre(HasSubstr("only formats")));
  EXPECT_THAT(violations("imulab/formats/x.cpp", "#include <CLI/App.hpp>"), ElementsAre(HasSubstr("only apps")));
}

TEST(IncludeDirections, UnknownRoomsAndRelativePathsAreCaught) {
  EXPECT_THAT(violations("imulab/cellar/x.cpp", ""), ElementsAre(HasSubstr("in no room")));
  EXPECT_THAT(violations("imulab/model/x.cpp", "#include \"imulab/cellar/y.hpp\""), ElementsAre(HasSubstr("no such room")));
  EXPECT_THAT(violations("imulab/model/x.cpp", "#include \"frame.hpp\""), ElementsAre(HasSubstr("a path from the root")));
}

/// The output of verbs passes print.cpp, which shows what would steer a terminal; the picture of `live`, which steers it, is its own.
TEST(Printing, VerbsHaveOneWay) {
  const std::regex direct(R"(fmt::print\(|std::c(out|err)|[^n]printf\(|fputs)");
  std::size_t verbs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(IMULAB_SOURCE) / "apps/imulab")) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".cpp" || name.ends_with("_test.cpp") ||
        std::set<std::string>{"command.cpp", "print.cpp", "live.cpp"}.contains(name))
      continue;
    std::ostringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    EXPECT_FALSE(std::regex_search(text.str(), direct)) << name << ": expected print() or print_json()";
    ++verbs;
  }
  EXPECT_GT(verbs, 15u);
}

}  // namespace
}  // namespace imulab
