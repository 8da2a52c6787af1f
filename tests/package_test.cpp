// The installed package serves programs of their own: examples/, which the tutorial of the library shows.
// ctest: package
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string run(const TemporaryFolder& folder, const std::string& command) {
  const CommandResult result = run_shell(folder, command);
  EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.output << result.errors;
  return result.output;
}

/// The numbers of a text, line by line, without a header.
std::vector<std::vector<double>> numbers(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::vector<double> row;
    for (double value; fields >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

TEST(Package, TheExamplesBuildAndRunAgainstIt) {
  const TemporaryFolder folder;
  run(folder, "cmake --install '" + std::filesystem::path(command_path()).parent_path().string() + "' --prefix \"$PWD/prefix\"");
  EXPECT_THAT(run(folder, "prefix/bin/imulab --version"), StartsWith("imulab "));
  run(folder, "cmake -S '" IMULAB_SOURCE "/examples' -B build -DCMAKE_PREFIX_PATH=\"$PWD/prefix\" && cmake --build build");
  ASSERT_FALSE(HasFailure());

  EXPECT_EQ(run(folder, "ls prefix/include/imulab"), run(folder, "cd '" IMULAB_SOURCE "/imulab' && ls *.hpp")) << "public headers, and no others";

  // The unit of the example, recorded once more by the command: the same coefficients.
  run(folder, "prefix/bin/imulab procedure handheld -o hand.toml && prefix/bin/imulab simulate hand.toml -o session");
  EXPECT_THAT(run(folder, "build/calibrate"), HasSubstr("verdict: good\n"));
  EXPECT_THAT(run(folder, "prefix/bin/imulab compare calibration.json session/truth.json"), HasSubstr("0 of 42 coefficients differ significantly"));

  run(folder, "tail -n +2 session/recording.csv | tr , ' ' > samples");
  for (const char* outliers : {"", " --reject-outliers"}) {
    const auto live = numbers(run(folder, std::string("build/compensate calibration.json") + outliers + " < samples"));
    const auto expected = numbers(run(
        folder, std::string("prefix/bin/imulab compensate calibration.json session -o expected.csv") + outliers + " >/dev/null; cat expected.csv"));
    ASSERT_EQ(live.size(), 26400u);
    ASSERT_EQ(expected.size(), live.size());
    double worst = 0;
    for (std::size_t i = 0; i < live.size(); ++i)
      for (std::size_t k = 0; k < 7; ++k) worst = std::max(worst, std::abs(live[i].at(k) - expected[i].at(k)));
    EXPECT_LT(worst, 1e-6) << "nine digits of 264 s";
  }

  // Programs for wider registers than the library's, or under the address sanitizer, where Eigen would lay out matrices in another way.
  run(folder, "cp calibration.json expected.json");
  const bool widest = read_text("/proc/cpuinfo").find("avx512f") != std::string::npos;
  for (const std::string flags : {"-mavx2 -DCMAKE_CXX_COMPILER=g++", "-mavx512f -DCMAKE_CXX_COMPILER=clang++", "-fsanitize=address"}) {
    if (flags.starts_with("-mavx512f") && !widest) continue;
    run(folder, "rm -rf wide && cmake -S '" IMULAB_SOURCE "/examples' -B wide -DCMAKE_PREFIX_PATH=\"$PWD/prefix\" -DCMAKE_CXX_FLAGS=" + flags +
                    " && cmake --build wide");
    ASSERT_FALSE(HasFailure());
    EXPECT_EQ(run(folder, "wide/predict"), run(folder, "build/predict")) << flags;
    EXPECT_EQ(run(folder, "wide/compensate expected.json < samples > wide.txt; build/compensate expected.json < samples | cmp - wide.txt"), "")
        << flags;
    EXPECT_THAT(run(folder, "wide/calibrate"), HasSubstr("verdict: good\n")) << flags;
    EXPECT_THAT(run(folder, "prefix/bin/imulab compare calibration.json expected.json"), HasSubstr("0 of 42 coefficients differ significantly"));
  }
  const CommandResult eigen_first = run_shell(
      folder,
      "printf '#include <Eigen/Core>\n#include <imulab/imulab.hpp>' > first.cpp; g++ -std=c++20 -mavx2 -Iprefix/include -I/usr/include/eigen3 "
      "-fsyntax-only first.cpp");
  EXPECT_THAT(eigen_first.errors, HasSubstr("Include imulab before Eigen"));

  // What works in memory needs neither the libraries of files nor their headers.
  const std::string loaded = run(folder, "ldd build/predict");
  for (const char* of_files : {"sqlite", "yaml", "deflate", "libz.", "zstd", "lz4", "bz2", "hdf5", "matio"})
    EXPECT_THAT(loaded, Not(HasSubstr(of_files)));
  EXPECT_LE(std::count(loaded.begin(), loaded.end(), '\n'), 8) << loaded;
  const CommandResult no_component =
      run_shell(folder,
                "printf 'cmake_minimum_required(VERSION 3.25)\nproject(p CXX)\nfind_package(imulab REQUIRED COMPONENTS "
                "pages)' > CMakeLists.txt; cmake -S . -B p -DCMAKE_PREFIX_PATH=\"$PWD/prefix\"");
  EXPECT_THAT(no_component.errors, HasSubstr("imulab has no component pages; expected none, or"));

  // pkg-config gives the same, wherever the prefix stands.
  run(folder, "mv prefix moved && export PKG_CONFIG_PATH=\"$PWD/moved/$(cd moved && echo lib*/pkgconfig)\" && g++ -std=c++20 '" IMULAB_SOURCE
              "/examples/predict.cpp' $(pkg-config --cflags --libs imulab) -o by_pkg_config && ./by_pkg_config > by_pkg_config.txt");
  const std::string prediction = run(folder, "build/predict");
  EXPECT_EQ(run(folder, "cat by_pkg_config.txt"), prediction);
  EXPECT_THAT(prediction, HasSubstr("gyro.matrix.zz"));
  EXPECT_THAT(prediction, HasSubstr("% from orthogonality\n"));
  EXPECT_EQ(run_shell(folder, "build/compensate nowhere.json").exit_code, 1);

  // The node of ROS 2, with a stand-in for what it uses of that.
  run(folder, "export PKG_CONFIG_PATH=\"$PWD/moved/$(cd moved && echo lib*/pkgconfig)\" && g++ -std=c++20 -Wall -Wextra -Werror -I'" IMULAB_SOURCE
              "/tests/ros2' '" IMULAB_SOURCE "/examples/ros2/src/compensate_node.cpp' $(pkg-config --cflags --libs imulab-files) -o node");
  const std::string node = "./node -p calibration:=calibration.json";
  const auto published = numbers(run(folder, "head -100 samples | " + node + " | grep -v '#'")),
             in_bulk = numbers(run(folder, "head -101 expected.csv"));
  ASSERT_EQ(published.size(), 100u);
  for (std::size_t i = 0; i < published.size(); ++i)
    for (std::size_t k = 0; k < 7; ++k) EXPECT_NEAR(published[i].at(k), in_bulk[i].at(k), 1e-6);
  const std::string variances = run(folder, "moved/bin/imulab export calibration.json --to ros 2>/dev/null | grep linear");
  EXPECT_NEAR(published[0].at(8), std::stod(variances.substr(variances.rfind(", 0.0, ") + 7)), 0.05 * published[0].at(8)) << variances;
  EXPECT_THAT(run(folder, "printf '0 nan 0 0 0 0 9.8\\n1 0 0 0 0 0 9.8\\n' | " + node), HasSubstr("1 of 2 messages left out: not finite"));
  const CommandResult no_file = run_shell(folder, "./node -p calibration:=nowhere.json < /dev/null");
  EXPECT_EQ(no_file.exit_code, 1);
  EXPECT_THAT(no_file.errors, HasSubstr("nowhere.json: cannot be opened"));
}

TEST(Package, TheTutorialShowsTheExamples) {
  const std::string page = read_text(IMULAB_SOURCE "/docs/start/library.md");
  std::map<std::string, std::string> sources;  // by file
  for (const auto& entry : std::filesystem::directory_iterator(IMULAB_SOURCE "/examples"))
    sources[entry.path().filename().string()] = read_text(entry.path());
  std::size_t shown = 0;
  const std::regex excerpt("`examples/([^`]+)`[^`]*\n```[a-z]+\n([^`]*)```\n");
  for (std::sregex_iterator i(page.begin(), page.end(), excerpt), end; i != end; ++i, ++shown)
    EXPECT_THAT(sources[(*i)[1]], HasSubstr((*i)[2])) << (*i)[1];
  EXPECT_EQ(shown, 2u);
}

TEST(Package, TheTutorialNamesItsDependencies) {
  const std::map<std::string, std::string> packages{{"Eigen3", "libeigen3-dev"},    {"fmt", "libfmt-dev"},  {"tomlplusplus", "libtomlplusplus-dev"},
                                                    {"PkgConfig", "pkg-config"},    {"ZLIB", "zlib1g-dev"}, {"libdeflate", "libdeflate-dev"},
                                                    {"yaml-cpp", "libyaml-cpp-dev"}};
  const std::string page = read_text(IMULAB_SOURCE "/docs/start/library.md"), list = read_text(IMULAB_SOURCE "/cmake/dependencies.cmake");
  const std::regex dependency("(?:find_package|pkg_check_modules)\\(([\\w-]+)");
  for (std::sregex_iterator i(list.begin(), list.end(), dependency), end; i != end; ++i) {
    ASSERT_TRUE(packages.contains((*i)[1])) << (*i)[1];
    EXPECT_THAT(page, HasSubstr(packages.at((*i)[1])));
  }
  // libimulab-dev depends on the rows of dependencies.txt that say "linked", and recommends those of files.
  const std::string rows_of_packages = read_text(IMULAB_SOURCE "/dependencies.txt");
  const std::regex linked("(\\S+) +# linked(?: by files)?: ");
  std::set<std::string> found, needed;
  for (std::sregex_iterator i(rows_of_packages.begin(), rows_of_packages.end(), linked), end; i != end; ++i) found.insert((*i)[1]);
  for (const auto& [module, package] : packages) needed.insert(package);
  EXPECT_EQ(found, needed);
  const std::map<std::string, std::string> optional{{"TBB", "libtbb-dev"},     {"LZ4", "liblz4-dev"},        {"ZSTD", "libzstd-dev"},
                                                    {"BZIP2", "libbz2-dev"},   {"SQLITE", "libsqlite3-dev"}, {"HDF5", "libhdf5-dev"},
                                                    {"MATIO", "libmatio-dev"}, {"SECCOMP", "libseccomp-dev"}};
  const std::string optional_list = read_text(IMULAB_SOURCE "/cmake/optional_dependencies.cmake");
  const std::regex row("imulab_optional\\((?!loaded)\\w+ (\\w+) ");
  std::size_t rows = 0;
  for (std::sregex_iterator i(optional_list.begin(), optional_list.end(), row), end; i != end; ++i, ++rows) {
    ASSERT_TRUE(optional.contains((*i)[1])) << (*i)[1];
    EXPECT_THAT(page, HasSubstr(optional.at((*i)[1])));
  }
  EXPECT_EQ(rows, optional.size());
}

}  // namespace
}  // namespace imulab
