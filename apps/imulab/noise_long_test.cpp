// imulab noise of logs whose columns do not fit into the memory that they may take.
#include <gmock/gmock.h>

#include "tests/still_log.hpp"
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace imulab {
namespace {

using ::testing::HasSubstr;

struct Peak {
  int exit_code = -1;
  double bytes = 0;  ///< of resident memory, mapped files included
};

Peak peak_of_imulab(const TemporaryFolder& folder, const std::vector<std::string>& arguments) {
  const std::string command = command_path();
  const pid_t child = fork();
  if (child == 0) {
    std::vector<char*> argv{const_cast<char*>(command.c_str())};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    if (chdir(folder.path().c_str()) != 0 || std::freopen("/dev/null", "w", stdout) == nullptr) _exit(127);
    execv(command.c_str(), argv.data());
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, 1024.0 * static_cast<double>(usage.ru_maxrss)};
}

/// Rows of six readings at 1 kHz behind their stamps, as NumPy saves them.
void write_npy(const std::filesystem::path& file, std::size_t rows) {
  std::string head = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", 7), }";
  head.resize(117, ' ');
  std::ofstream out(file, std::ios::binary);
  out << "\x93NUMPY\x01" << '\0' << 'v' << '\0' << head << '\n';
  std::uint64_t state = 1;
  std::vector<std::array<double, 7>> block;
  for (std::size_t i = 0; i < rows; ++i) {
    std::array<double, 7> row{1e-3 * static_cast<double>(i + 1)};
    for (std::size_t k = 1; k < 7; ++k) {
      state = state * 6364136223846793005u + 1442695040888963407u;
      row[k] = 1e-3 * (std::ldexp(static_cast<double>(state >> 11), -53) - 0.5) + (k == 6 ? 9.8 : 0);
    }
    block.push_back(row);
    if (block.size() < 8192 && i + 1 < rows) continue;
    out.write(reinterpret_cast<const char*>(block.data()), static_cast<std::streamsize>(block.size() * sizeof(row)));
    block.clear();
  }
}

TEST(NoiseCommand, ALongLogInFilesGivesTheSameAsInMemory) {  // ctest: long
  const TemporaryFolder folder;
  // More than one piece of text, with knocks, spikes, a gap, lost samples that are filled in, and a temperature.
  std::ostringstream text;
  text.precision(10);
  text << "t,gx,gy,gz,ax,ay,az,T\n";
  for (int i = 1; i <= 250000; ++i) {
    if (i % 20011 == 0 || (i > 60000 && i < 60050)) continue;
    text << 0.01 * i;
    const bool knock = i > 30000 && i < 30100;
    const double spike = i % 31013 == 0 ? 5 : 0;
    for (const double value : still_readings(i)) text << ',' << value + (knock ? std::sin(0.3 * i) : spike);
    text << ',' << 25 + 1e-5 * i << '\n';
  }
  write_still_log(folder, 2, still_readings);
  folder.write("log.csv", text.str());
  std::ofstream(folder / "session.toml", std::ios::app) << "gyro_temperature = { columns = [\"T\"], unit = \"degC\" }\n"
                                                           "accel_temperature = { columns = [\"T\"], unit = \"degC\" }\n";
  for (const char* options : {"", " --remove-temperature", " --deviation total", " --report page.html --force"}) {
    const CommandResult memory = run_imulab(folder, std::string("noise session.toml --json") + options);
    const std::string page = *options != '\0' && std::string(options).find("page") != std::string::npos ? read_text(folder / "page.html") : "";
    const CommandResult files = run_imulab(folder, std::string("noise session.toml --json --in-memory 1") + options);
    ASSERT_EQ(memory.exit_code, 0) << memory.errors;
    EXPECT_EQ(files.exit_code, 0) << files.errors;
    EXPECT_EQ(files.output, memory.output) << options;
    EXPECT_EQ(files.errors, memory.errors) << options;
    if (!page.empty()) {
      EXPECT_EQ(read_text(folder / "page.html"), page);
    }
  }
  // Eight spikes, and four samples at the edges of the knock, which is cut.
  EXPECT_THAT(run_imulab(folder, "noise session.toml --in-memory 1").output,
              testing::AllOf(HasSubstr("lost samples were filled in"), HasSubstr("spikes replaced in the recording: 12 samples")));
}

TEST(NoiseCommand, ALongLogThatMovesIsRefusedAsInMemory) {
  const TemporaryFolder folder;
  write_still_log(folder, 40000, [](int i) {
    std::array<double, 6> row = still_readings(i);
    for (double& value : row) value += std::sin(0.05 * i);
    return row;
  });
  const CommandResult memory = run_imulab(folder, "noise session.toml"), files = run_imulab(folder, "noise session.toml --in-memory 1");
  EXPECT_EQ(memory.exit_code, 1);
  EXPECT_EQ(files.exit_code, 1);
  EXPECT_EQ(files.errors, memory.errors);
}

TEST(NoiseCommand, ALongLogTakesTheMemoryOfOneAxis) {
  if (under_sanitizers()) GTEST_SKIP() << "they need memory of their own";
  const TemporaryFolder folder;
  constexpr std::size_t rows = 5'000'000;
  write_npy(folder / "log.npy", rows);
  folder.write("session.toml",
               "format = \"imulab.session/1\"\n[imu]\nname = \"test\"\n[site]\nlatitude_deg = 47.0\n[rig]\nkind = \"none\"\n"
               "[[recording]]\nfile = \"log.npy\"\ntime = { column = 1, unit = \"s\" }\n"
               "gyro = { columns = [2, 3, 4], output = \"rate\", unit = \"rad/s\" }\n"
               "accel = { columns = [5, 6, 7], output = \"rate\", unit = \"m/s^2\" }\n");
  const Peak peak = peak_of_imulab(folder, {"noise", "session.toml", "--in-memory", "100", "-o", "noise.json"});
  ASSERT_EQ(peak.exit_code, 0);
  EXPECT_THAT(read_text(folder / "noise.json"), HasSubstr("\"samples\": 5000000"));
  // One axis, and what does not grow with the log: the program, its libraries, a piece of the file, sums of a twentieth of a second (measured 77 MB).
  EXPECT_LT(peak.bytes, 8.0 * rows + 120e6);
  // The columns alone are 280 MB.
}

}  // namespace
}  // namespace imulab
