// The exported compensation in integers is as exact as the header says.
#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/export/c_header.hpp"
#include "imulab/export/c_header_parts.hpp"
#include "imulab/outlier_filter.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/unit_of_every_term.hpp"
#include <algorithm>
#include <cmath>
#include <regex>
#include <vector>

namespace imulab {
namespace {

constexpr const char* fixed_point_program = R"(
#include "calibration.h"
#include <stdio.h>
int main(void) {
  long v[12];
  DATA x[12], force[3], rate[3];
  int k;
  for (;;) {
    for (k = 0; k < 12; ++k) {
      if (scanf("%ld", &v[k]) != 1) return 0;
      x[k] = (DATA)v[k];
    }
    COMPENSATE(x, x + 3, x + 6, x + 9, force, rate);
    printf("%ld %ld %ld %ld %ld %ld\n", (long)force[0], (long)force[1], (long)force[2], (long)rate[0], (long)rate[1], (long)rate[2]);
  }
}
)";

/// As flags of the compiler: which of the two programs it makes.
constexpr const char *with_32 = " -DDATA=int32_t -DCOMPENSATE=imulab_compensate_fixed",
                     *with_q15 = " -DDATA=int16_t -DCOMPENSATE=imulab_compensate_q15";

int bits(const std::string& header, const std::string& name) {
  std::smatch found;
  if (!std::regex_search(header, found, std::regex("#define IMULAB_(?:FIXED|Q15)_" + name + "_BITS (-?[0-9]+)"))) throw std::runtime_error(name);
  return std::stoi(found[1]);
}

struct Errors {
  double force = 0, rate = 0;
};

Errors stated(const std::string& header) {
  std::smatch found;
  if (!std::regex_search(header, found, std::regex("Largest error within the ranges, against the exact model: (\\S+) m/s\\^2, (\\S+) rad/s")))
    throw std::runtime_error("no error is stated");
  return {std::stod(found[1]), std::stod(found[2])};
}

/// The end of a range, in integers: readings, and |T - T0|.
struct Ranges {
  double accel, gyro, accel_temperature[2], gyro_temperature[2];
};

/// Corners of the ranges, then readings anywhere in them.
std::array<double, 12> sample(const Ranges& r, std::uint64_t i) {
  std::array<double, 12> x;
  for (std::size_t k = 0; k < 12; ++k) {
    const double u = i < 4096 ? static_cast<double>(i >> k & 1) : RandomStream(7, 40 + k).uniform(i);
    const auto between = [u](double low, double high) { return low + u * (high - low); };
    x[k] = std::floor(k < 3   ? between(-r.accel, r.accel)
                      : k < 6 ? between(-r.gyro, r.gyro)
                      : k < 9 ? between(r.accel_temperature[0], r.accel_temperature[1])
                              : between(r.gyro_temperature[0], r.gyro_temperature[1]));
  }
  return x;
}

Errors measured(const TemporaryFolder& folder, const Calibration& c, const CHeaderOptions& options, const Ranges& ranges) {
  const std::string header = c_header(c, options);
  folder.write("calibration.h", header);
  folder.write("program.c", fixed_point_program);
  const CommandResult compiled = run_shell(
      folder, std::string("cc -std=c99 -fsanitize=undefined -fno-sanitize-recover program.c") + header_warnings + (options.q15 ? with_q15 : with_32));
  if (compiled.exit_code != 0) throw std::runtime_error(compiled.errors);
  const std::array<int, 4> in_bits{bits(header, "ACCEL"), bits(header, "GYRO"), bits(header, "ACCEL_TEMPERATURE"), bits(header, "GYRO_TEMPERATURE")};
  constexpr std::uint64_t samples = 4096 + 20000;
  std::string input;
  for (std::uint64_t i = 0; i < samples; ++i)
    for (const double x : sample(ranges, i)) input += fmt::format("{:.0f}\n", x);
  folder.write("input", input);
  const CommandResult ran = run_shell(folder, "./program < input > output");
  EXPECT_EQ(ran.exit_code, 0) << ran.errors;  // no overflow: the sanitizer ends the program
  std::istringstream output(read_text(folder / "output"));
  const firmware::Input accel = firmware::input_of(c, options, Triad::accel), gyro = firmware::input_of(c, options, Triad::gyro);
  const double force_unit = std::ldexp(1.0, -bits(header, "FORCE")), rate_unit = std::ldexp(1.0, -bits(header, "RATE"));
  Errors worst;
  for (std::uint64_t i = 0; i < samples; ++i) {
    std::array<double, 12> x = sample(ranges, i);
    for (std::size_t k = 0; k < 12; ++k) x[k] = std::ldexp(x[k], -in_bits[k / 3]);
    const Motion exact = compensate(c.model, firmware::raw_sample(c.model, accel, gyro, x));
    Vector3d force, rate;
    output >> force[0] >> force[1] >> force[2] >> rate[0] >> rate[1] >> rate[2];
    worst.force = std::max(worst.force, (force * force_unit - exact.force).cwiseAbs().maxCoeff());
    worst.rate = std::max(worst.rate, (rate * rate_unit - exact.rate).cwiseAbs().maxCoeff());
  }
  EXPECT_TRUE(output);
  return worst;
}

void expect_as_stated(const Calibration& c, CHeaderOptions options, const Ranges& ranges, bool q15 = false) {
  const TemporaryFolder folder;
  (q15 ? options.q15 : options.fixed_point) = true;
  const Errors said = stated(c_header(c, options)), found = measured(folder, c, options, ranges);
  EXPECT_LE(found.force, said.force);
  EXPECT_LE(found.rate, said.rate);
  EXPECT_GE(3 * found.force, said.force) << found.force;
  EXPECT_GE(3 * found.rate, said.rate) << found.rate;
  testing::Test::RecordProperty("error",
                                fmt::format("force {:.3g} of {:.3g}, rate {:.3g} of {:.3g}", found.force, said.force, found.rate, said.rate));
}

TEST(ExportFixedPoint, IsAsExactAsItSaysOfCountsWithEveryTerm) {
  // 16 bits; the calibrated temperatures
  const double t = 65536;
  expect_as_stated(every_term(), {}, {32768, 32768, {0, 70 * t}, {4900 * t, 5100 * t}});
}

TEST(ExportFixedPoint, IsAsExactAsItSaysOfReadingsInUnitsAlongOtherAxes) {
  Calibration c = every_term_in_si();
  c.model.accel.thermal.setZero(), c.model.gyro.temperature->reference = 4987.123456;
  c.recorded_accel = RecordedAs{"g", 1, 0, {"+y", "-x", "+z"}};
  c.recorded_gyro = RecordedAs{"deg/s", 1, 0, {"-z", "-x", "+y"}};
  CHeaderOptions options;
  options.accel_range = 8, options.gyro_range = 500;
  const double t = 65536;
  // 8 g 2^27 = 2^30; 500 deg/s 2^21 < 2^30
  expect_as_stated(c, options, {std::ldexp(8, 27), std::ldexp(500, 21), {0, 70 * t}, {4900 * t, 5100 * t}});
}

TEST(ExportFixedPoint, IsAsExactAsItSaysOfALinearUnit) {
  Calibration c;
  c.covariance.resize(0, 0);
  c.model.accel.matrix << 1.01, 0.003, -0.002, 0.001, 0.99, 0.004, 0.0005, -0.003, 1.002;
  c.model.accel.offset = {0.3, -0.2, 0.1};
  c.recorded_accel = RecordedAs{"g", 2048, 0};
  c.recorded_gyro = RecordedAs{"deg/s", 16.4, 0};
  expect_as_stated(c, {}, {32768, 32768, {0, 0}, {0, 0}});
}

TEST(ExportFixedPoint, OfQ15IsAsExactAsItSays) {
  // 16 bits; temperatures to a 2^8th degree, and to a quarter of a thermal reading about 5000
  expect_as_stated(every_term(), {}, {32767, 32767, {0, 70 * 256}, {4900 * 4, 5100 * 4}}, true);
  Calibration c;
  c.covariance.resize(0, 0);
  c.model.accel.matrix << 1.01, 0.003, -0.002, 0.001, 0.99, 0.004, 0.0005, -0.003, 1.002;
  c.model.accel.offset = {0.3, -0.2, 0.1};
  c.model.g_sensitivity << 1e-4, -2e-4, 3e-4, 1e-4, 0, 1e-4, -1e-4, 2e-4, 0;
  c.recorded_accel = RecordedAs{"g", 1, 0, {"+y", "-x", "+z"}};
  c.recorded_gyro = RecordedAs{"deg/s", 16.4, 0};
  CHeaderOptions options;
  options.accel_range = 8;
  expect_as_stated(c, options, {std::ldexp(8, 11), 32767, {0, 0}, {0, 0}}, true);
  // 24 bits: the driver shifts its counts to the right.
  Calibration fine;
  fine.covariance.resize(0, 0);
  fine.model.accel.raw_unit = fine.model.gyro.raw_unit = "count";
  fine.model.accel.matrix *= 2e-5, fine.model.gyro.matrix *= 4e-6;
  options = {};
  options.accel_range = options.gyro_range = 1 << 23;
  expect_as_stated(fine, options, {16384, 16384, {0, 0}, {0, 0}}, true);
}

TEST(ExportFixedPoint, OfQ15RefusesADriftThatItsWordsCannotHold) {
  Calibration c = every_term();
  c.model.accel.thermal(0, 1) = 200;  // counts a degree: 9000 over 45 degrees of 32768
  CHeaderOptions options;
  options.fixed_point = true;
  EXPECT_NO_THROW(c_header(c, options));
  options.q15 = true;
  EXPECT_THAT([&] { c_header(c, options); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("larger than the range of the readings leaves (16 bits)")));
  options.accel_range = 1 << 18;  // the driver shifts its readings
  EXPECT_NO_THROW(c_header(c, options));
}

/// Any model that a sensor might have: scales, offsets, bends, drifts and ranges over decades.
TEST(ExportFixedPoint, OfAnyModelNeverOverflowsAndKeepsItsBound) {  // ctest: once
  const RandomStream random(11, "models in integers");
  std::uint64_t draw = 0;
  const auto any = [&] { return 2 * random.uniform(draw++) - 1; };
  const auto decades = [&](double low, double high) { return low * std::pow(high / low, random.uniform(draw++)); };
  const TemporaryFolder folder;
  for (int model = 0; model < 24; ++model) {
    const bool q15 = model >= 12;
    Calibration c;
    c.covariance.resize(0, 0);
    CHeaderOptions options;
    (q15 ? options.q15 : options.fixed_point) = true;
    Ranges ranges{};
    for (TriadModel* t : {&c.model.accel, &c.model.gyro}) {
      const double range = std::floor(decades(100, q15 ? 32767 : 1e9)), full = decades(t == &c.model.accel ? 60 : 1, 300),
                   scale = full / range;  // counts, SI; accelerometers have room for gravity
      t->raw_unit = "count";
      t->matrix.setIdentity();
      for (Eigen::Index i = 0; i < 9; ++i) t->matrix(i) = scale * (t->matrix(i) * decades(0.3, 3) + 0.1 * any());
      for (Eigen::Index i = 0; i < 3; ++i) {
        t->offset[i] = full * any();
        t->quadratic[i] = model % 3 == 0 ? 0 : full / range / range * decades(1e-6, 0.3) * any();
        t->cubic[i] = model % 4 == 0 ? 0 : full / std::pow(range, 3) * decades(1e-6, 0.3) * any();
        const double drift = range / (q15 ? 30 : 3);
        if (model % 2 == 0)
          for (int order = 1; order <= 3; ++order) t->thermal(i, order) = drift * std::pow(0.01, order) * decades(1e-6, 1) * any();
      }
      for (Eigen::Index i = 0; i < 9 && model % 4 == 0; ++i)
        t->matrix_thermal1(i) = decades(1e-7, 1e-3) * any(), t->matrix_thermal2(i) = decades(1e-9, 1e-5) * any();
      t->temperature = ThermalReading{"degC", 30 * any(), {-40, 85}};
      (t == &c.model.accel ? options.accel_range : options.gyro_range) = range;
      (t == &c.model.accel ? ranges.accel : ranges.gyro) = range;
      auto& temperature = t == &c.model.accel ? ranges.accel_temperature : ranges.gyro_temperature;
      const double zero = t->temperature->reference, far = 1.5 * std::max(zero + 40, 85 - zero) - 1e-4;
      const double step = q15 ? std::exp2(-std::floor(std::log2(32767 / (std::abs(zero) + far + 1e-4)))) : 1.0 / 65536;
      if (model % 2 == 0) temperature[0] = std::floor(-40 / step), temperature[1] = std::ceil(85 / step);
    }
    for (Eigen::Index i = 0; i < 9; ++i) c.model.g_sensitivity(i) = decades(1e-6, 1e-2) * any();
    const Errors said = stated(c_header(c, options)), found = measured(folder, c, options, ranges);
    EXPECT_LE(found.force, said.force) << model;
    EXPECT_LE(found.rate, said.rate) << model;
    EXPECT_GE(3 * found.force, said.force) << model;
    EXPECT_GE(3 * found.rate, said.rate) << model;
    folder.write("selftest.c", "#include \"calibration.h\"\nint main(void) { return SELFTEST() + imulab_selftest(); }\n");
    EXPECT_EQ(run_shell(folder, std::string("cc -O2 -DSELFTEST=imulab_selftest_") + (q15 ? "q15" : "fixed") + " selftest.c -o selftest && ./selftest")
                  .exit_code,
              0)
        << model;
  }
}

TEST(ExportFixedPoint, TheUsualRangeSuitsTheCounts) {
  CHeaderOptions options;
  options.fixed_point = true;
  Calibration c = every_term();  // 2e-3 m/s^2 and rad/s a count: 16 bits are 65 m/s^2
  EXPECT_THAT(c_header(c, options),
              testing::HasSubstr("accelerometers: counts, up to 32768 either way\n *      gyros: counts, up to 32768 either way"));
  c = Calibration{};
  c.covariance.resize(0, 0);
  c.model.accel.raw_unit = c.model.gyro.raw_unit = "count";
  c.model.accel.matrix *= 1e-5, c.model.gyro.matrix *= 1e-6;  // 24 bits: 16 g are 15.7 million counts
  const std::string header = c_header(c, options);
  EXPECT_THAT(header,
              testing::HasSubstr("accelerometers: counts, up to 1.56906e+07 either way\n *      gyros: counts, up to 3.49066e+07 either way"));
}

constexpr const char* fixed_point_filter_program = R"(
#include "calibration.h"
#include <stdio.h>
static void show(int replaced, const int32_t* x) {
  int k;
  printf("%d", replaced);
  for (k = 0; k < 6; ++k) printf(" %ld", (long)x[k]);
  printf("\n");
}
int main(void) {
  imulab_filter_fixed filter;
  long v[6];
  int32_t x[6];
  int k;
  imulab_filter_fixed_init(&filter);
  while (scanf("%ld %ld %ld %ld %ld %ld", v, v + 1, v + 2, v + 3, v + 4, v + 5) == 6) {
    for (k = 0; k < 6; ++k) x[k] = (int32_t)v[k];
    if ((k = imulab_filter_fixed_push(&filter, x, x)) >= 0) show(k, x);
  }
  while (imulab_filter_fixed_flush(&filter, x) >= 0) show(0, x);
  return 0;
}
)";

TEST(ExportFixedPoint, TheFilterReplacesWhatTheLibraryReplaces) {
  const TemporaryFolder folder;
  CHeaderOptions options;
  options.fixed_point = true;
  folder.write("calibration.h", c_header(every_term(), options));
  folder.write("program.c", fixed_point_filter_program);
  ASSERT_EQ(run_shell(folder, std::string("cc -std=c99 -fsanitize=undefined -fno-sanitize-recover program.c") + header_warnings).exit_code, 0);
  // Counts: noise of some, of one half (rounded), slopes, sines, and the largest that 32 bits hold.
  std::string input;
  std::vector<OutlierFilter::Output> expected;
  OutlierFilter filter;
  int replaced = 0;
  for (std::size_t i = 0; i < 3000; ++i) {
    OutlierFilter::Readings r;
    for (std::size_t k = 0; k < 6; ++k) {
      const double noise = RandomStream(4, 60 + k).normal(i), t = static_cast<double>(i);
      const double spike = i % 97 == 10 + k ? 700 : i % 97 == 40 + k ? -900 : 0;
      const double motion = k == 1               ? 100 * std::fmod(t, 200)
                            : k == 2             ? 800 * std::sin(0.05 * t)
                            : k == 4 && i > 2500 ? (i % 300 < 150 ? 1 : -1) * 2147480000.0
                                                 : 0;
      r[k] = std::round((k == 3 ? 0.5 : 10) * noise + spike + motion);
      input += fmt::format("{:.0f} ", r[k]);
    }
    input += "\n";
    if (const auto out = filter.push(r)) expected.push_back(*out), replaced += __builtin_popcount(out->replaced);
  }
  while (const auto out = filter.rest()) expected.push_back(*out);
  EXPECT_GT(replaced, 200);
  folder.write("input", input);
  const CommandResult ran = run_shell(folder, "./program < input");
  EXPECT_EQ(ran.exit_code, 0) << ran.errors;
  std::istringstream output(ran.output);
  for (const OutlierFilter::Output& out : expected) {
    int mask = 0;
    ASSERT_TRUE(output >> mask);
    ASSERT_EQ(mask, out.replaced);
    for (const double reading : out.readings) {
      double given = 0;
      output >> given;
      ASSERT_EQ(given, std::floor(reading));
    }
  }
}

TEST(ExportFixedPoint, TakesTheEndOfARangeBeyondIt) {
  const TemporaryFolder folder;
  CHeaderOptions options;
  options.fixed_point = true;
  folder.write("calibration.h", c_header(every_term(), options));
  folder.write("program.c", fixed_point_program);
  ASSERT_EQ(run_shell(folder, std::string("cc -std=c99 -fsanitize=undefined -fno-sanitize-recover program.c") + header_warnings + with_32).exit_code,
            0);
  const auto out = [&](const std::string& triad, const std::string& temperature) {
    std::string line;
    for (const std::string& x : {triad, temperature}) line += x + " " + x + " " + x + " " + x + " " + x + " " + x + " ";
    folder.write("input", line);
    return run_shell(folder, "./program < input").output;
  };
  EXPECT_EQ(out("2147483647", "2147483647"), out("32768", "2147483647"));
  EXPECT_EQ(out("-2147483648", "-2147483648"), out("-32768", "-2147483648"));
  EXPECT_NE(out("-32768", "0"), out("32768", "0"));
}

}  // namespace
}  // namespace imulab
