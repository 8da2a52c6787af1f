// The exported header checks itself, gives all samples of its filter, and stands names and readings of any kind.
#include "imulab/error.hpp"
#include "imulab/export/c_header.hpp"
#include "imulab/outlier_filter.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/unit_of_every_term.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>

namespace imulab {
namespace {

using ::testing::HasSubstr;

constexpr const char* selftest = "#include \"calibration.h\"\nint main(void) { return imulab_selftest(); }\n";
constexpr const char* both_selftests =
    "#include \"calibration.h\"\nint main(void) { return imulab_selftest() ? 1 : imulab_selftest_fixed() ? 2 : imulab_selftest_q15() ? 3 : 0; }\n";

/// Exit code of a program with a header. Throws where it does not compile.
int run_with(const TemporaryFolder& folder, const std::string& header, const std::string& program, const std::string& compiler) {
  folder.write("calibration.h", header);
  folder.write("program.c", program);
  folder.write("program.cpp", program);
  const CommandResult compiled = run_shell(folder, compiler + header_warnings);
  if (compiled.exit_code != 0) throw std::runtime_error(compiler + "\n" + compiled.errors);
  return run_shell(folder, "./program").exit_code;
}

const std::vector<std::string> compilers{"cc -std=c99 program.c", "c++ -std=c++98 -Wno-long-long program.cpp",
                                         "cc -std=c99 -DIMULAB_REAL=float program.c", "c++ -std=c++20 -DIMULAB_REAL=float program.cpp",
                                         "cc -std=gnu17 -march=native -ffast-math program.c"};

TEST(ExportSelftest, PassesWhereverItCompiles) {
  const TemporaryFolder folder;
  CHeaderOptions options;
  options.fixed_point = options.q15 = true;
  Calibration plain, other_axes = every_term_in_si();
  plain.covariance.resize(0, 0);
  other_axes.recorded_accel = RecordedAs{"g*s", 1, 0.005, {"-y", "+x", "-z"}};
  other_axes.recorded_gyro = RecordedAs{"mdeg/s", 0.0164, 0, {"+z", "-x", "-y"}};
  for (const Calibration& c : {every_term(), plain, other_axes})
    for (const std::string& compiler : compilers) EXPECT_EQ(run_with(folder, c_header(c, options), both_selftests, compiler), 0) << compiler;
}

TEST(ExportSelftest, FindsACompilersOtherArithmetic) {
  const TemporaryFolder folder;
  const std::string header = c_header(every_term());
  folder.write("calibration.h", header);
  folder.write("program.c", selftest);
  ASSERT_EQ(run_shell(folder, "cc -O2 -fsingle-precision-constant program.c -o program").exit_code, 0);
  EXPECT_NE(run_shell(folder, "./program").exit_code, 0) << "constants of single precision in a header of double";
  // One coefficient that is wrong in its tenth digit.
  const std::string matrix = "(imulab_real)0.002";
  const std::size_t first = header.find(matrix);
  ASSERT_NE(first, std::string::npos);
  std::string wrong = header;
  wrong.replace(first, matrix.size(), "(imulab_real)(1 + 1e-10) * " + matrix);
  EXPECT_NE(run_with(folder, wrong, selftest, "cc -std=c99 program.c"), 0);
}

constexpr const char* selftest_of_filter = R"(
#include "calibration.h"
#include <stdio.h>
static void show(int replaced, const imulab_real* x) {
  int k;
  printf("%d", replaced);
  for (k = 0; k < 6; ++k) printf(" %.17g", x[k]);
  printf("\n");
}
int main(void) {
  imulab_filter filter;
  imulab_real x[6];
  int k;
  imulab_filter_init(&filter);
  while (scanf("%lf %lf %lf %lf %lf %lf", x, x + 1, x + 2, x + 3, x + 4, x + 5) == 6)
    if ((k = imulab_filter_push(&filter, x, x)) >= 0) show(k, x);
  while ((k = imulab_filter_flush(&filter, x)) >= 0) show(k, x);
  return imulab_filter_flush(&filter, x) != -1;
}
)";

std::string line_of(int replaced, const OutlierFilter::Readings& r) {
  std::string text = fmt::format("{}", replaced);
  for (const double x : r) {
    char number[40];
    std::snprintf(number, sizeof number, " %.17g", x);
    text += std::isnan(x) ? " nan" : number;
  }
  return text + "\n";
}

TEST(ExportedFilter, GivesEverySampleOnceAlsoThoseThatAreNoNumbers) {
  const TemporaryFolder folder;
  Calibration c;
  c.covariance.resize(0, 0);
  for (const int samples : {0, 1, 2, 3, 4, 5, 500}) {
    OutlierFilter filter;
    std::string input, expected;
    for (int i = 0; i < samples; ++i) {
      OutlierFilter::Readings r;
      for (std::size_t k = 0; k < 6; ++k) r[k] = std::sin(1e5 * (i + 1) * (static_cast<double>(k) + 1)) + (i % 90 == 80 ? 100 : 0);
      if (i % 7 == 3) r[1] = std::numeric_limits<double>::quiet_NaN();
      if (i == 300) r[2] = std::numeric_limits<double>::infinity();
      if (i == 20) r[3] = -std::numeric_limits<double>::infinity();
      if (i > 100 && i < 110) r[4] = std::numeric_limits<double>::quiet_NaN();
      input += line_of(0, r).substr(2);
      if (const auto out = filter.push(r)) expected += line_of(out->replaced, out->readings);
    }
    while (const auto out = filter.rest()) expected += line_of(0, out->readings);
    folder.write("input", input);
    ASSERT_EQ(run_with(folder, c_header(c), selftest_of_filter, "cc -std=c99 program.c"), 0) << "and no sample after the last";
    const std::string output = std::regex_replace(run_shell(folder, "./program < input").output, std::regex("-nan"), "nan");
    EXPECT_EQ(output, expected) << samples;
    EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), samples);
  }
}

TEST(ExportedHeader, NamesCannotLeaveTheirCommentsAndQuotes) {
  const TemporaryFolder folder;
  const std::vector<std::string> names{
      "*/ #error out",        "/* in", "line\nfeed #error", "carriage\rreturn #error", "end \\", "?\?/\n#error", "\"quoted\" %s {} {0}",
      "\xC2\xB0\xE2\x80\xAE", "'",     "// x \\\n#error"};
  for (std::size_t k = 0; k < names.size(); ++k) {  // each name in each place
    const auto name = [&](std::size_t place) { return names[(k + 3 * place) % names.size()]; };
    Calibration c = every_term();
    c.imu = name(0), c.method = name(1), c.created = name(2), c.software = name(3);
    c.model.accel.temperature->unit = name(4), c.model.gyro.temperature->unit = name(5);
    CHeaderOptions options;
    options.fixed_point = options.q15 = true;
    const std::string compiler = k % 2 == 0 ? "cc -std=c99 -trigraphs program.c" : "c++ -std=c++98 -Wno-long-long -trigraphs program.cpp";
    EXPECT_EQ(run_with(folder, c_header(c, options), both_selftests, compiler), 0) << names[k];
  }
  Calibration c = every_term();
  c.model.gyro.raw_unit = "*/ #error";
  EXPECT_THAT([&] { c_header(c); }, ThrowsMessage<Error>(testing::StartsWith("readings of the gyros in _/ #error; expected one of")));
  c = every_term();
  c.imu = std::string(100000, 'x');
  EXPECT_THAT(c_header(c), HasSubstr("x...\", method"));
  EXPECT_LT(c_header(c).size(), 40000u);
}

TEST(ExportedHeader, IsLinesThatAnEditorShows) {
  CHeaderOptions options;
  options.fixed_point = options.q15 = true;
  const std::string header = c_header(every_term(), options);
  for (const char c : header) ASSERT_TRUE(c == '\n' || (c >= ' ' && c <= '~')) << static_cast<int>(c);
}

}  // namespace
}  // namespace imulab
