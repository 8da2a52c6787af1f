// The exported header on microcontrollers, in QEMU: what a computer computes, bit by bit. And in the examples for Arduino and Zephyr, compiled
// against stand-ins that declare only the names they use.
#include "imulab/export/c_header.hpp"
#include "imulab/export/c_header_parts.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include "tests/unit_of_every_term.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <vector>

namespace imulab {
namespace {

const std::string firmware_folder = IMULAB_SOURCE "/examples/firmware/";

/// The first of the tools that is not installed; empty: all are.
std::string missing_tool() {
  const TemporaryFolder folder;
  for (const std::string tool : {"arm-none-eabi-gcc", "arm-none-eabi-g++", "qemu-system-arm"})
    if (run_shell(folder, "command -v " + tool).exit_code != 0) return tool;
  return "";
}

struct Board {
  const char *machine, *flags;
};
constexpr Board m4f{"mps2-an386", "-mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard"}, m0{"microbit", "-mcpu=cortex-m0plus -mfloat-abi=soft"};

constexpr int samples = 100;

/// Readings and temperatures as the header takes them, exact in float: noise, motion, spikes, and some that are no numbers.
std::array<double, 12> firmware_sample(int i, bool integers) {
  std::array<double, 12> x;
  for (int k = 0; k < 12; ++k) {
    double value = k < 6   ? 9000 * std::sin(0.3 * i + k) + (i % 37 == 30 + k ? 20000 : 0)
                   : k < 9 ? 35 + 50 * std::sin(0.2 * i + k)
                           : 4987.5 + 150 * std::cos(0.2 * i + k);
    if (integers) value = std::round(k < 6 ? value : value * 65536);
    x[static_cast<std::size_t>(k)] = integers ? value : static_cast<float>(value);
  }
  return x;
}

std::string samples_text() {
  std::string reals, integers;
  for (int i = 0; i < samples; ++i) {
    reals += "{", integers += "{";
    for (const double x : firmware_sample(i, false)) reals += i == 50 && x > 0 ? "__builtin_nan(\"\"), " : fmt::format("{:.17g}, ", x);
    for (const double x : firmware_sample(i, true)) integers += fmt::format("{:.0f}, ", x);
    reals += "},\n", integers += "},\n";
  }
  return fmt::format(
      "enum {{ sample_count = {} }};\nstatic const double samples[{}][12] = {{\n{}}};\nstatic const int32_t fixed_samples[{}][12] = {{\n{}}};\n",
      samples, samples, reals, samples, integers);
}

void write_header(const TemporaryFolder& folder) {
  CHeaderOptions options;
  options.fixed_point = options.q15 = true;
  folder.write("calibration.h", c_header(every_term(), options));
  folder.write("samples.h", samples_text());
}

constexpr const char* files = " -Wall -Wextra -Werror -DCALIBRATION='\"calibration.h\"' -DSAMPLES='\"samples.h\"' -I. ";

std::string on_this_computer(const TemporaryFolder& folder, const std::string& flags) {
  const CommandResult built = run_shell(folder, "cc -O2 " + flags + files + firmware_folder + "cortex_m/check.c -o check");
  EXPECT_EQ(built.exit_code, 0) << built.errors;
  const CommandResult ran = run_shell(folder, "./check");
  EXPECT_EQ(ran.exit_code, 0) << "self-test";
  return ran.output;
}

std::string on_a_board(const TemporaryFolder& folder, const Board& board, const std::string& flags) {
  const std::string sources = firmware_folder + "cortex_m/startup.c " + firmware_folder + "cortex_m/check.c";
  const CommandResult built = run_shell(folder, std::string("arm-none-eabi-gcc -O2 -mthumb -ffreestanding -nostdlib ") + board.flags + " " + flags +
                                                    files + "-T " + firmware_folder + "cortex_m/link.ld " + sources + " -lgcc -o check.elf");
  EXPECT_EQ(built.exit_code, 0) << built.errors;
  const CommandResult ran = run_shell(folder, std::string("timeout 60 qemu-system-arm -M ") + board.machine +
                                                  " -display none -monitor none -serial none -chardev stdio,id=out -semihosting-config "
                                                  "enable=on,target=native,chardev=out -kernel check.elf");
  EXPECT_EQ(ran.exit_code, 0) << "self-test" << ran.errors;
  return ran.output;
}

TEST(ExportFirmware, OnAMicrocontrollerComputesTheSameBits) {
  if (const std::string tool = missing_tool(); !tool.empty()) GTEST_SKIP() << tool << " is not installed";
  const TemporaryFolder folder;
  write_header(folder);
  for (const std::string flags : {"-std=c99", "-std=gnu11 -ffp-contract=off", "-std=c99 -DIMULAB_REAL=float"}) {  // C99: no contraction
    const std::string expected = on_this_computer(folder, flags);
    EXPECT_EQ(std::count(expected.begin(), expected.end(), '\n'), 5 * samples + 1 - 2);
    EXPECT_THAT(expected, testing::AllOf(testing::HasSubstr("nan"), testing::HasSubstr("selftest 00000000 00000000")));
    for (const Board& board : {m4f, m0}) EXPECT_EQ(on_a_board(folder, board, flags), expected) << board.machine << flags;
  }
}

/// The outputs of the lines "compensate" as float.
std::vector<std::array<float, 6>> compensated(const std::string& output) {
  std::vector<std::array<float, 6>> out;
  std::istringstream lines(output);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word != "compensate") continue;
    words >> word;
    out.emplace_back();
    for (float& x : out.back()) {
      words >> word;
      const auto bits = word == "nan" ? 0x7FC00000u : static_cast<std::uint32_t>(std::stoul(word, nullptr, 16));
      std::memcpy(&x, &bits, sizeof x);
    }
  }
  return out;
}

TEST(ExportFirmware, WithFusedOperationsDiffersByRoundingOnly) {
  if (const std::string tool = missing_tool(); !tool.empty()) GTEST_SKIP() << tool << " is not installed";
  const TemporaryFolder folder;
  write_header(folder);
  const std::string plain = on_this_computer(folder, "-std=c99 -DIMULAB_REAL=float"),
                    fused = on_a_board(folder, m4f, "-std=gnu11 -DIMULAB_REAL=float");
  EXPECT_NE(plain, fused) << "nothing is fused: this tests nothing";
  const auto a = compensated(plain), b = compensated(fused);
  ASSERT_EQ(a.size(), static_cast<std::size_t>(samples));
  ASSERT_EQ(a.size(), b.size());
  // Full scale of a row is the sum of its terms, below 40 m/s^2 and rad/s: 10,000 counts of up to 2.6e-3, a third of that from the drift. 2 ulp.
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k) {
      ASSERT_EQ(std::isnan(a[i][k]), std::isnan(b[i][k]));
      EXPECT_FALSE(std::abs(a[i][k] - b[i][k]) > 2 * 40 * 1.2e-7) << a[i][k] << " " << b[i][k];
    }
}

TEST(ExportFirmware, TheCostsOfTheDocumentationCanBeMeasured) {  // ctest: long
  if (const std::string tool = missing_tool(); !tool.empty()) GTEST_SKIP() << tool << " is not installed";
  const TemporaryFolder folder;
  write_header(folder);
  const CommandResult measured = run_shell(folder, "sh " + firmware_folder + "cortex_m/measure.sh calibration.h");
  EXPECT_EQ(measured.exit_code, 0) << measured.errors;
  std::istringstream lines(measured.output);
  std::map<std::string, std::array<int, 4>> costs;
  for (std::string line; std::getline(lines, line);) {
    std::array<char, 40> processor, function, numbers;
    std::array<int, 4> cost;
    if (std::sscanf(line.c_str(), "| %39s | %39s | %39s | %d | %d | %d | %d |", processor.data(), function.data(), numbers.data(), &cost[0], &cost[1],
                    &cost[2], &cost[3]) == 7)
      costs[fmt::format("{} {} {}", processor.data(), function.data(), numbers.data())] = cost;
  }
  EXPECT_EQ(costs.size(), 14u) << measured.output;
  for (const auto& [what, cost] : costs)
    for (const int number : cost) EXPECT_GT(number, 0) << what;
  // No instruction takes less than a cycle; of this code few take more than two. Of the filter another call is counted, with other branches.
  for (const auto& [what, cost] : costs) {
    EXPECT_GE(cost[3], 0.9 * cost[2]) << what;
    EXPECT_LE(cost[3], 2 * cost[2]) << what;
  }
  // A unit for floating point saves a factor; integers do too where there is none.
  EXPECT_LT(5 * costs["Cortex-M4F `imulab_compensate` float"][2], costs["Cortex-M4F `imulab_compensate` double"][2]);
  EXPECT_LT(2 * costs["Cortex-M0+ `imulab_compensate_fixed` int32"][2], costs["Cortex-M0+ `imulab_compensate` float"][2]);
  EXPECT_LT(2 * costs["Cortex-M0+ `imulab_compensate_q15` int16"][2], costs["Cortex-M0+ `imulab_compensate_fixed` int32"][2]);
}

/// An identity that takes the readings of the examples.
CHeaderOptions in_si() {
  CHeaderOptions options;
  options.accel = RecordedAs{"m/s^2"}, options.gyro = RecordedAs{"rad/s"};
  return options;
}

TEST(ExportFirmware, TheExampleForArduinoRuns) {
  const TemporaryFolder folder;
  Calibration c;
  c.covariance.resize(0, 0);
  CHeaderOptions options;
  options.accel = RecordedAs{"g", 16384}, options.gyro = RecordedAs{"deg/s", 131};
  folder.write("imu_calibration.h", c_header(c, options));
  folder.write("main.cpp", "#include <Arduino.h>\n#include \"" + firmware_folder +
                               "arduino/arduino.ino\"\nint main() { setup(); loop(); return 0; }\n");  // as its builder does
  const std::string flags = " -std=c++17 -O2 -Wall -Wextra -Werror -I. -I" + firmware_folder + "stand_in main.cpp ";
  const CommandResult built = run_shell(folder, "c++" + flags + "-o program && ./program");
  EXPECT_EQ(built.exit_code, 0) << built.errors;
  // 1, 2, 3 counts of 16384 a g; 5, 6, 7 of 131 a deg/s
  EXPECT_EQ(built.output, "0.00060\t0.00120\t0.00180\t0.00067\t0.00080\t0.00093\n");
  if (const std::string tool = missing_tool(); !tool.empty()) GTEST_SKIP() << "not for a Cortex-M0+: " << tool << " is not installed";
  const CommandResult board = run_shell(folder, std::string("arm-none-eabi-g++ -ffreestanding -mthumb ") + m0.flags + flags + "-c -o program.o");
  EXPECT_EQ(board.exit_code, 0) << board.errors;
}

TEST(ExportFirmware, TheExampleForZephyrRuns) {
  const TemporaryFolder folder;
  Calibration c;
  c.covariance.resize(0, 0);
  folder.write("imu_calibration.h", c_header(c, in_si()));
  const std::string flags = " -std=c11 -O2 -Wall -Wextra -Werror -I. -I" + firmware_folder + "stand_in " + firmware_folder + "zephyr/src/main.c ";
  const CommandResult built = run_shell(folder, "cc" + flags + "-o program");
  EXPECT_EQ(built.exit_code, 0) << built.errors;
  const std::string line = "1000000 2000000 3000000 um/s^2\n";
  EXPECT_EQ(run_shell(folder, "./program").output, line + line);
}

}  // namespace
}  // namespace imulab
