// The exported header compiles as C99 and as C++ without a warning and does what the library does.
#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"
#include "imulab/export/c_header.hpp"
#include "imulab/files.hpp"
#include "imulab/outlier_filter.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/unit_of_every_term.hpp"
#include <cmath>
#include <sstream>

namespace imulab {
namespace {

struct ReadRow {
  std::array<double, 12> in;
};

std::vector<ReadRow> read_rows() {
  std::vector<ReadRow> out;
  for (int i = 0; i < 20; ++i) {
    ReadRow r;
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
  for (const ReadRow& r : read_rows()) {
    for (const double x : r.in) input += std::to_string(x) + " ";
    input += "\n";
  }
  folder.write("input", input);
  struct Build {
    std::string command;
    double tolerance;  // of full scale: rounding of some twenty operations
  };
  for (const Build& build : {Build{"cc -std=c99 program.c", 1e-14},
                             {"c++ -std=c++98 -Wno-long-long program.cpp", 1e-14},
                             {"cc -std=c99 -DIMULAB_REAL=float program.c", 3e-6},
                             {"c++ -std=c++20 -DIMULAB_REAL=float program.cpp", 3e-6}}) {
    const CommandResult compiled = run_shell(folder, build.command + header_warnings);
    ASSERT_EQ(compiled.exit_code, 0) << build.command << compiled.errors;
    std::istringstream output(run_shell(folder, "./program < input").output);
    std::istringstream given(input);
    for (std::size_t i = 0; i < read_rows().size(); ++i) {
      std::array<double, 12> x;
      for (double& v : x) given >> v;
      RawSample raw{.gyro = {x[3], x[4], x[5]}, .accel = {x[0], x[1], x[2]}};
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

constexpr const char* filter_program = R"(
#include "calibration.h"
#include <stdio.h>
int main(void) {
  imulab_filter filter;
  double v[6];
  imulab_filter_init(&filter);
  for (;;) {
    imulab_real x[6], out[6];
    int k, replaced;
    for (k = 0; k < 6; ++k)
      if (scanf("%lf", &v[k]) != 1) return 0;
    for (k = 0; k < 6; ++k) x[k] = (imulab_real)v[k];
    replaced = imulab_filter_push(&filter, x, out);
    if (replaced < 0) continue;
    printf("%d", replaced);
    for (k = 0; k < 6; ++k) printf(" %.17g", (double)out[k]);
    printf("\n");
  }
}
)";

TEST(Export, TheHeadersFilterReplacesWhatTheLibraryReplaces) {
  const TemporaryFolder folder;
  Calibration c;
  c.covariance.resize(0, 0);
  folder.write("calibration.h", c_header(c));
  folder.write("program.c", filter_program);
  folder.write("program.cpp", filter_program);
  // Noise, a slope and a sine, one channel rounded, spikes: exact in float, so that both types see the same readings.
  std::vector<OutlierFilter::Readings> samples;
  std::string input;
  for (std::size_t i = 0; i < 2000; ++i) {
    OutlierFilter::Readings r;
    for (std::size_t k = 0; k < 6; ++k) {
      const double noise = RandomStream(3, 60 + k).normal(i), spike = i % 97 == 10 + k ? 500 : i % 97 == 40 + k ? -300 : 0;
      const double motion = k == 1 ? 100.0 * static_cast<double>(i % 200) : k == 2 ? 800 * std::sin(0.05 * static_cast<double>(i)) : 0;
      r[k] = static_cast<float>(k == 3 ? std::round(noise + spike) : noise + spike + motion);
      input += fmt::format("{} ", r[k]);
    }
    samples.push_back(r);
    input += "\n";
  }
  folder.write("input", input);
  std::vector<OutlierFilter::Output> expected;
  OutlierFilter filter;
  int replaced = 0;
  for (const auto& r : samples)
    if (const auto out = filter.push(r)) {
      expected.push_back(*out);
      replaced += __builtin_popcount(out->replaced);
    }
  EXPECT_GT(replaced, 120);  // of 247 spikes: not the first ones, and few on the slope and the sine, which hardly show their noise
  struct Build {
    std::string command;
    double tolerance;
  };
  for (const Build& build : {Build{"cc -std=c99 program.c", 0},
                             {"c++ -std=c++98 -Wno-long-long program.cpp", 0},
                             {"cc -std=c99 -DIMULAB_REAL=float program.c", 2e-3}}) {  // float: a rounding of readings up to 20,000
    const CommandResult compiled = run_shell(folder, build.command + header_warnings);
    ASSERT_EQ(compiled.exit_code, 0) << build.command << compiled.errors;
    std::istringstream output(run_shell(folder, "./program < input").output);
    for (const auto& out : expected) {
      int mask = 0;
      ASSERT_TRUE(output >> mask);
      ASSERT_EQ(mask, out.replaced) << build.command;
      for (const double reading : out.readings) {
        double given = 0;
        output >> given;
        ASSERT_NEAR(given, reading, build.tolerance) << build.command;
      }
    }
  }
}

TEST(Export, TheHeaderKnowsTheCalibratedTemperatures) {
  const TemporaryFolder folder;
  Calibration c = every_term();
  folder.write("both.h", c_header(c));
  c.model.accel.temperature->range = {0, 0};  // not given
  folder.write("gyro.h", c_header(c));
  folder.write("program.c", R"(
#include CALIBRATION
#include <stdio.h>
int main(void) {
  const imulab_real in[3] = {0, 35, 70}, hot[3] = {0, 35, 71}, f[3] = {4900, 5000, 5100}, low[3] = {4899, 5000, 5100};
  const imulab_real nan[3] = {0, 35, (imulab_real)(in[0] / in[0])};
  printf("%d%d%d%d", imulab_out_of_range(in, f), imulab_out_of_range(hot, f), imulab_out_of_range(in, low), imulab_out_of_range(nan, f));
  return 0;
}
)");
  for (const auto& [file, expected] : {std::pair{"both", "0111"}, {"gyro", "0010"}}) {
    const CommandResult result =
        run_shell(folder, std::string("cc -std=c99 program.c -DCALIBRATION='\"") + file + ".h\"'" + header_warnings + " && ./program");
    EXPECT_EQ(result.output, expected) << result.errors;
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
