// Headers of several IMUs in one program.
#include "imulab/error.hpp"
#include "imulab/exchange.hpp"
#include "imulab/export/c_header.hpp"
#include "imulab/export/c_header_parts.hpp"
#include "imulab/files.hpp"

#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/unit_of_every_term.hpp"
#include <regex>

namespace imulab {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// The unit of every term, and another that differs in its offsets alone. Their name is like a name of the header.
Calibration left_unit() {
  Calibration c = every_term();
  c.imu = "imulab_filter IMULAB_REAL";
  return c;
}
Calibration right_unit() {
  Calibration c = left_unit();
  c.model.accel.offset += Vector3d(1, 2, 3);
  return c;
}

CHeaderOptions all_parts(const std::string& prefix) {
  CHeaderOptions options;
  options.fixed_point = options.q15 = true;
  options.prefix = prefix;
  return options;
}

constexpr const char* two_units_program = R"(
#define IMU1_REAL double
#define RIGHT_2_REAL float
#include "right.h"
#include "left.h"
#include "plain.h"
#include <stdio.h>
int main(void) {
  const double in[12] = {0}, t[3] = {25, 25, 25}, f[3] = {4987.5, 4987.5, 4987.5};
  const float in2[3] = {0}, t2[3] = {25, 25, 25}, f2[3] = {4987.5, 4987.5, 4987.5};
  double a[3], w[3];
  float a2[3], w2[3];
  imu1_filter one;
  right_2_filter_fixed two;
  imu1_filter_init(&one);
  right_2_filter_fixed_init(&two);
  imu1_compensate(in, in, t, f, a, w);
  right_2_compensate(in2, in2, t2, f2, a2, w2);
  printf("%.3f %.3f\n", a[0], (double)a2[0]);
  return imu1_selftest() + imu1_selftest_fixed() + imu1_selftest_q15() + right_2_selftest() + right_2_selftest_fixed() + right_2_selftest_q15() +
         imulab_selftest();
}
)";

TEST(ExportPrefix, SeveralHeadersAreOneProgram) {
  const TemporaryFolder folder;
  folder.write("left.json", calibration_text(left_unit()));
  folder.write("right.json", calibration_text(right_unit()));
  for (const char* arguments : {"left.json --prefix imu1 -o left.h", "right.json --prefix right_2 -o right.h", "right.json -o plain.h"}) {
    const CommandResult exported = run_imulab(folder, std::string("export --to c-header --fixed-point --q15 ") + arguments);
    ASSERT_EQ(exported.exit_code, 0) << exported.errors;
  }
  folder.write("program.c", two_units_program);
  folder.write("program.cpp", two_units_program);
  for (const char* compiler : {"cc -std=c99 program.c", "c++ -std=c++98 -Wno-long-long program.cpp"}) {
    const CommandResult built = run_shell(folder, compiler + std::string(header_warnings) + " && ./program");
    EXPECT_EQ(built.exit_code, 0) << compiler << built.errors;
    EXPECT_EQ(built.output, "0.100 1.100\n") << compiler;
  }
}

TEST(ExportPrefix, AnotherHeaderWithTheSameNamesIsAnErrorThatSaysWhatToDo) {
  const TemporaryFolder folder;
  folder.write("left.h", c_header(left_unit()));
  folder.write("right.h", c_header(right_unit()));
  CHeaderOptions integers;
  integers.fixed_point = true;
  folder.write("integers.h", c_header(left_unit(), integers));
  folder.write("one.h", c_header(left_unit(), all_parts("imu1")));
  folder.write("other.h", c_header(right_unit(), all_parts("imu1")));
  folder.write("capitals.h", c_header(right_unit(), all_parts("IMU1")));
  const auto compiled = [&](const std::string& first, const std::string& second) {
    folder.write("program.c", "#include \"" + first + ".h\"\n#include \"" + second + ".h\"\nint main(void) { return 0; }\n");
    return run_shell(folder, std::string("cc -std=c99 program.c") + header_warnings);
  };
  EXPECT_EQ(compiled("left", "left").exit_code, 0);
  EXPECT_EQ(compiled("one", "one").exit_code, 0);
  EXPECT_EQ(compiled("left", "one").exit_code, 0);
  for (const auto& [first, second] : {std::pair{"left", "right"}, {"right", "left"}, {"left", "integers"}, {"one", "other"}, {"one", "capitals"}}) {
    const CommandResult result = compiled(first, second);
    EXPECT_NE(result.exit_code, 0) << first << " " << second;
    EXPECT_THAT(result.errors, AllOf(HasSubstr("Two different calibration headers with the prefix"), HasSubstr("--to c-header --prefix imu1"),
                                     Not(HasSubstr("redefinition"))))
        << first << " " << second;
  }
}

TEST(ExportPrefix, EveryNameBeginsWithIt) {
  const std::string text = c_header(left_unit(), all_parts("imu1"));
  const std::size_t code = text.find("*/");
  EXPECT_THAT(text.substr(0, code), AllOf(HasSubstr("\"imulab_filter IMULAB_REAL\""), HasSubstr("Names begin with imu1_ and IMU1_.")));
  EXPECT_THAT(text.substr(code), Not(testing::ContainsRegex("[Ii][Mm][Uu][Ll][Aa][Bb]_")));
  const std::regex defined(
      "#define ([A-Za-z0-9_]+)|^static inline [a-z0-9_]+ ([A-Za-z0-9_]+)\\(|^typedef .*[ }]([A-Za-z0-9_]+);|^\\} ([A-Za-z0-9_]+);",
      std::regex::ECMAScript | std::regex::multiline);
  std::size_t names = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), defined), end; at != end; ++at, ++names)
    for (std::size_t k = 1; k < at->size(); ++k)
      if ((*at)[k].matched) {
        EXPECT_TRUE((*at)[k].str().starts_with("imu1_") || (*at)[k].str().starts_with("IMU1_")) << (*at)[k];
        EXPECT_LE((*at)[k].length() - 4 + 32, 63) << (*at)[k] << ": of which C99 reads the first 63 characters";
      }
  EXPECT_GT(names, 40u);
}

TEST(ExportPrefix, IsAName) {
  for (const std::string& good : std::vector<std::string>{"imu1", "left", "a", "Left_2", std::string(32, 'x')})
    EXPECT_NO_THROW(firmware::expect_prefix(good)) << good;
  for (const std::string& bad :
       std::vector<std::string>{"", "1imu", "_imu", "imu_", "imu__1", "imu-1", "imu 1", "imu\n", "im\u00fc", "a\"b", std::string(33, 'x')})
    EXPECT_THROW(firmware::expect_prefix(bad), Error) << bad;
  const TemporaryFolder folder;
  folder.write("c.json", calibration_text(every_term()));
  const CommandResult wrong = run_imulab(folder, "export c.json --to c-header --prefix 1imu");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("--prefix: \"1imu\" cannot begin a name in C; expected a letter, then"));
  const CommandResult other = run_imulab(folder, "export c.json --to csv --prefix imu1");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.errors, HasSubstr("--to csv: has none of the options of c-header"));
  folder.write("si.json", calibration_text(every_term_in_si()));
  EXPECT_EQ(run_imulab(folder, "export si.json --to all -o out --prefix imu1").exit_code, 0);
  EXPECT_THAT(read_text(folder / "out/imu_calibration.h"), HasSubstr("imu1_compensate"));
}

TEST(ExportPrefix, IsAnOptionOfTheLibrarysTable) {
  const Calibration c = every_term();
  EXPECT_THAT(export_target("c-header").text({.calibration = c, .options = {.prefix = "imu1"}}), HasSubstr("imu1_compensate"));
}

}  // namespace
}  // namespace imulab
