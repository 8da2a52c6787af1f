// The exported header compiles as C99 and as C++ without a warning and does what the library does.
#include "imulab/io/c_header.hpp"
#include "imulab/io/calibration_file.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/compensate.hpp"
#include "tests/run_command.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

namespace imulab {
namespace {

/// A unit that uses every term, in counts, with a resonance frequency as the gyros' thermal reading.
Calibration every_term() {
  Calibration c;
  c.imu = "unit */ #include <x>";  // hostile
  c.method = "truth";
  c.model.accel.raw_unit = c.model.gyro.raw_unit = "count";
  for (int index = 0; index < coefficient_count; ++index) {
    const Coefficient& k = coefficient_table()[static_cast<std::size_t>(index)];
    const double sign = index % 2 ? -1 : 1, size = 1 + 0.1 * (index % 7);
    double value = 0;
    switch (k.term) {
      case Term::offset: value = 0.1; break;
      case Term::matrix: value = k.row == k.column ? 2e-3 : 1e-5; break;
      case Term::quadratic: value = 1e-9; break;
      case Term::cubic: value = 1e-13; break;
      case Term::thermal: value = k.column == 1 ? 2.5 : 0.03; break;
      case Term::g_sensitivity: value = 1e-4; break;
      case Term::lever_arm: break;
    }
    if (value != 0) set_coefficient(c.model, index, (k.row == k.column && k.term == Term::matrix ? 1 : sign) * size * value);
  }
  c.model.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  c.model.gyro.temperature = ThermalReading{"raw", 4987.5, {4900, 5100}};
  c.covariance.resize(0, 0);
  return c;
}

struct Row {
  std::array<double, 12> in;
};

std::vector<Row> rows() {
  std::vector<Row> out;
  for (int i = 0; i < 20; ++i) {
    Row r;
    for (int k = 0; k < 6; ++k) r.in[static_cast<std::size_t>(k)] = 5000 * std::sin(1.0 + 3 * i + k);
    for (int k = 6; k < 9; ++k) r.in[static_cast<std::size_t>(k)] = 35 + 30 * std::sin(2. * i + k);
    for (int k = 9; k < 12; ++k) r.in[static_cast<std::size_t>(k)] = 4987.5 + 50 * std::cos(2. * i + k);
    out.push_back(r);
  }
  return out;
}

constexpr const char* program = R"(
#include "calibration.h"
#include <stdio.h>
int main(void) {
  double v[12];
  for (;;) {
    imulab_real x[12], force[3], rate[3];
    int k;
    for (k = 0; k < 12; ++k)
      if (scanf("%lf", &v[k]) != 1) return 0;
    for (k = 0; k < 12; ++k) x[k] = (imulab_real)v[k];
    imulab_compensate(x, x + 3, x + 6, x + 9, force, rate);
    printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", (double)force[0], (double)force[1], (double)force[2], (double)rate[0], (double)rate[1], (double)rate[2]);
  }
}
)";

TEST(Export, TheHeaderCompilesAnywhereAndDoesWhatTheLibraryDoes) {
  const Calibration c = every_term();
  const TemporaryFolder folder;
  folder.write("calibration.json", calibration_text(c));
  ASSERT_EQ(run_imulab(folder, "export calibration.json --to c-header -o calibration.h").exit_code, 0);
  folder.write("program.c", program);
  folder.write("program.cpp", program);
  std::string input;
  for (const Row& r : rows()) {
    for (const double x : r.in) input += std::to_string(x) + " ";
    input += "\n";
  }
  folder.write("input", input);
  struct Build {
    std::string command;
    double tolerance;  // of full scale: rounding of some twenty operations
  };
  for (const Build& build : {Build{"cc -std=c99 program.c", 1e-14}, {"c++ -std=c++98 -Wno-long-long program.cpp", 1e-14},
                             {"cc -std=c99 -DIMULAB_REAL=float program.c", 3e-6}, {"c++ -std=c++20 -DIMULAB_REAL=float program.cpp", 3e-6}}) {
    const CommandResult compiled = run_shell(folder, build.command + " -O2 -Wall -Wextra -Wpedantic -Werror -o program");
    ASSERT_EQ(compiled.exit_code, 0) << build.command << compiled.errors;
    std::istringstream output(run_shell(folder, "./program < input").output);
    std::istringstream given(input);
    for (std::size_t i = 0; i < rows().size(); ++i) {
      std::array<double, 12> x;
      for (double& v : x) given >> v;
      RawSample raw{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
      raw.accel_tau = Vector3d(x[6], x[7], x[8]).array() - 25;
      raw.gyro_tau = Vector3d(x[9], x[10], x[11]).array() - 4987.5;
      const Motion expected = compensate(c.model, raw);
      Vector3d force, rate;
      output >> force[0] >> force[1] >> force[2] >> rate[0] >> rate[1] >> rate[2];
      ASSERT_TRUE(output) << build.command;
      EXPECT_LT((force - expected.force).norm(), build.tolerance * 20) << build.command;  // full scale: 10 m/s^2 and rad/s in each axis
      EXPECT_LT((rate - expected.rate).norm(), build.tolerance * 20) << build.command;
    }
  }
}

TEST(Export, WithoutThermalTermsNoTemperatureIsRead) {
  Calibration c;
  c.covariance.resize(0, 0);
  const std::string text = c_header(c);
  EXPECT_THAT(text, testing::HasSubstr("(void)accel_temperature;"));
  EXPECT_THAT(text, testing::HasSubstr("const imulab_real f_x = (imulab_real)1.0 * accel_x;"));
}

TEST(Export, RefusesWhatItCannotWrite) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_imulab(folder, "export none.json --to c-header").exit_code, 2);
  folder.write("calibration.json", calibration_text(every_term()));
  const CommandResult unknown = run_imulab(folder, "export calibration.json --to stone");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.errors, testing::HasSubstr("c-header"));
}

}  // namespace
}  // namespace imulab
