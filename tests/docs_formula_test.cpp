// The documentation's statements about the sensor model, applied: the code of the conventions, and the signs.
#include "imulab/compensate.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/unit_of_every_term.hpp"
#include <array>
#include <cmath>
#include <regex>

namespace imulab {
namespace {

std::string docs_page(const std::string& name) { return read_text(std::filesystem::path(IMULAB_SOURCE) / "docs" / name); }

/// All C of a page.
std::string c_of(const std::string& page) {
  std::string code;
  std::istringstream lines(page);
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```"))
      inside = line == "```c";
    else if (inside)
      code += line + "\n";
  }
  return code;
}

std::string c_numbers(const Vector3d& v) { return fmt::format("{{{:.17g}, {:.17g}, {:.17g}}}", v[0], v[1], v[2]); }
template <int columns>
std::string c_numbers(const Eigen::Matrix<double, 3, columns>& m) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += "{";
    for (int j = 0; j < columns; ++j) text += fmt::format("{:.17g}, ", m(i, j));
    text += "}, ";
  }
  return "{" + text + "}";
}

std::string triad_of(const TriadModel& m) {
  return fmt::format("{{{}, {}, {}, {}, {}, {}, {}, {:.17g}, {{{:.17g}, {:.17g}}}}}", c_numbers(m.offset), c_numbers(m.matrix),
                     c_numbers(m.quadratic), c_numbers(m.cubic), c_numbers(m.thermal), c_numbers(m.matrix_thermal1), c_numbers(m.matrix_thermal2),
                     m.temperature->reference, m.temperature->range[0], m.temperature->range[1]);
}

/// Readings and temperatures, in the order of the page's function.
std::array<double, 12> formula_sample(int i) {
  std::array<double, 12> x;
  for (int k = 0; k < 12; ++k)
    x[static_cast<std::size_t>(k)] = k < 6 ? 9000 * std::sin(1 + 3 * i + k) : k < 9 ? 35 + 30 * std::sin(i + k) : 4987.5 + 90 * std::cos(i + k);
  return x;
}

TEST(DocumentedFormula, OfTheConventionsIsTheWholeModel) {
  const Calibration c = every_term();
  constexpr int samples = 20;
  std::string rows;
  for (int i = 0; i < samples; ++i) {
    rows += "{";
    for (const double x : formula_sample(i)) rows += fmt::format("{:.17g}, ", x);
    rows += "},\n";
  }
  const TemporaryFolder folder;
  folder.write("program.c", c_of(docs_page("reference/conventions.md")) + "#include <stdio.h>\nint main(void) {\n  const struct triad accel = " +
                                triad_of(c.model.accel) + ", gyro = " + triad_of(c.model.gyro) +
                                ";\n  const double g_sensitivity[3][3] = " + c_numbers(c.model.g_sensitivity) + ", in[][12] = {" + rows + R"(};
  int i;
  for (i = 0; i < )" + std::to_string(samples) +
                                R"(; ++i) {
    double f[3], w[3];
    compensate(&accel, &gyro, g_sensitivity, in[i], in[i] + 3, in[i] + 6, in[i] + 9, f, w);
    printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", f[0], f[1], f[2], w[0], w[1], w[2]);
  }
  return 0;
}
)");
  const CommandResult ran = run_shell(folder, "cc -std=c99 -Wall -Wextra -pedantic -Werror program.c -o program && ./program");
  ASSERT_EQ(ran.exit_code, 0) << ran.errors;
  std::istringstream output(ran.output);
  for (int i = 0; i < samples; ++i) {
    const std::array<double, 12> x = formula_sample(i);
    RawSample raw{.gyro = {x[3], x[4], x[5]}, .accel = {x[0], x[1], x[2]}};
    for (std::size_t k = 0; k < 3; ++k) {  // some are outside the range
      raw.accel_tau[static_cast<Eigen::Index>(k)] = c.model.accel.temperature->tau(x[6 + k]);
      raw.gyro_tau[static_cast<Eigen::Index>(k)] = c.model.gyro.temperature->tau(x[9 + k]);
    }
    const Motion expected = compensate(c.model, raw);
    Vector3d force, rate;
    ASSERT_TRUE(output >> force[0] >> force[1] >> force[2] >> rate[0] >> rate[1] >> rate[2]);
    constexpr double rounding = 20 * 1e-14;  // some twenty operations on outputs up to 20 m/s^2 and rad/s
    EXPECT_LT((force - expected.force).norm(), rounding);
    EXPECT_LT((rate - expected.rate).norm(), rounding);
  }
}

TEST(DocumentedFormula, TheSignOfTheGSensitivityIsThatOfTheModel) {
  const std::string conventions = on_one_line(docs_page("reference/conventions.md"));
  std::smatch said;
  ASSERT_TRUE(std::regex_search(
      conventions, said,
      std::regex("gyro\\.g_sensitivity\\.xx` = ([-+0-9.e]+) \\(rad/s\\)/\\(m/s\\^2\\)[^.]*reads\\s+([-+0-9.e]+) rad/s\\s+with 1 g along \\+x")));
  Calibration c;
  c.model.g_sensitivity(0, 0) = std::stod(said[1]);
  const RawSample at_rest{.gyro = {std::stod(said[2]), 0, 0}, .accel = {unit::g, 0, 0}};
  EXPECT_NEAR(compensate(c.model, at_rest).rate.x(), 0, 5e-5) << "the page has two digits";
  for (const char* name : {"reference/conventions.md", "start/by-hand.md", "reference/calibration-file.md"}) {
    const std::string page = on_one_line(docs_page(name));
    EXPECT_NE(page.find("minus the false rate"), std::string::npos) << name;
    EXPECT_EQ(page.find("| false rate"), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace imulab
