// The public headers, imulab/*.hpp: what a program of its own may include. Each compiles by itself and needs no header of a room.
// ctest: headers
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <filesystem>
#include <regex>
#include <set>
#include <string>

namespace imulab {
namespace {

using ::testing::StartsWith;

/// "imulab/calibrate.hpp", ...
std::set<std::string> public_headers_of_tree() {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(IMULAB_SOURCE "/imulab"))
    if (entry.path().extension() == ".hpp") names.insert("imulab/" + entry.path().filename().string());
  return names;
}

std::string header_text(const std::string& name) { return read_text(IMULAB_SOURCE "/" + name); }

std::vector<std::string> captures(const std::string& text, const std::regex& what) {
  std::vector<std::string> out;
  for (std::sregex_iterator i(text.begin(), text.end(), what), end; i != end; ++i) out.push_back((*i)[1]);
  return out;
}

TEST(PublicHeaders, IncludeOnlyEachOther) {
  const std::set<std::string> all = public_headers_of_tree();
  EXPECT_GT(all.size(), 20u);
  for (const std::string& name : all)
    for (const std::string& included : captures(header_text(name), std::regex("#include [\"<]([^\">]+)[\">]")))
      if (included.find_first_of("./") != std::string::npos && !all.contains(included))
        EXPECT_THAT(included, StartsWith("Eigen/")) << name << ": expected a public header, Eigen, or one of the standard library";
}

TEST(PublicHeaders, AreThoseOfTheUmbrella) {
  std::set<std::string> all = public_headers_of_tree();
  const std::vector<std::string> included = captures(header_text("imulab/imulab.hpp"), std::regex("#include \"([^\"]+)\""));
  all.erase("imulab/imulab.hpp");
  EXPECT_EQ(std::set<std::string>(included.begin(), included.end()), all);
}

/// The standard output and errors of a compiler that only checks; empty: nothing to say.
std::string said_by(const TemporaryFolder& folder, const std::string& compiler, const std::string& arguments) {
  return run_shell(folder, compiler + " -I'" IMULAB_SOURCE "' -isystem /usr/include/eigen3 -Wall -Wextra -Wshadow -Wconversion -Werror " + arguments +
                               " 2>&1")
      .output;
}

/// Headers with Eigen are read after imulab/eigen.hpp, which each of them includes: once for all, in half the time.
TEST(PublicHeaders, CompileAlone) {
  const TemporaryFolder folder;
  folder.write("eigen.cpp", "#include \"imulab/eigen.hpp\"\n");
  ASSERT_EQ(said_by(folder, "clang++", "-std=c++20 -x c++-header eigen.cpp -o eigen.pch"), "");
  for (const std::string& name : public_headers_of_tree()) {
    if (name == "imulab/imulab.hpp") continue;  // below
    folder.write("one.cpp", "#include \"" + name + "\"\n");
    const bool light = std::set<std::string>{"imulab/version.hpp", "imulab/error.hpp",     "imulab/units.hpp",         "imulab/parallel.hpp",
                                             "imulab/grade.hpp",   "imulab/recording.hpp", "imulab/outlier_filter.hpp"}
                           .contains(name);
    EXPECT_EQ(said_by(folder, "clang++", std::string("-std=c++20 -fsyntax-only one.cpp") + (light ? "" : " -include-pch eigen.pch")), "") << name;
  }
}

/// The lines after "// Example:" of each header, as one program; the names in the parameters stand for the reader's own.
TEST(PublicHeaders, TheirExamplesCompileWithBothCompilers) {
  std::string program = "#include \"imulab/imulab.hpp\"\n#include <cstdio>\nusing namespace imulab;\n";
  const std::string parameters =
      "(Calibration calibration, Session session, Recording recording, std::vector<double> t, Columns3 gyro, Columns3 accel) ";
  for (const std::string& name : public_headers_of_tree()) {
    const std::vector<std::string> examples = captures(header_text(name), std::regex("\n// Example:\n((?://   [^\n]*\n)+)"));
    if (name == "imulab/imulab.hpp" || name == "imulab/eigen.hpp") continue;  // a list, and a part of the others
    ASSERT_EQ(examples.size(), 1u) << name;
    const std::string function = std::filesystem::path(name).stem();
    program += "static void example_" + std::filesystem::path(name).stem().string() + parameters + "{\n" +
               std::regex_replace(examples.front(), std::regex("(^|\n)// "), "$1") + "}\n";
  }
  const TemporaryFolder folder;
  folder.write("examples.cpp", program);
  for (const char* compiler : {"g++ -std=c++23", "clang++ -std=c++2b"})
    EXPECT_EQ(said_by(folder, compiler, "-Wno-unused -Wno-unused-parameter -Wno-missing-field-initializers -fsyntax-only examples.cpp"), "")
        << compiler;
}

}  // namespace
}  // namespace imulab
