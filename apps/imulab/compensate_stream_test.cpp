// imulab compensate CALIBRATION - --session SESSION: the same rows as of a file, as they come, in memory that does not grow.
#include "imulab/core/random.hpp"
#include "imulab/files.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fcntl.h>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string stream_entry(const std::string& file, const std::string& gyro = R"(output = "rate", unit = "deg/s")",
                         const std::string& more = "rate_hz = 100.0\n") {
  return "[[recording]]\nfile = \"" + file + "\"\n" + more + R"(time = { column = "t", unit = "s" }
gyro = { columns = ["gx", "gy", "gz"], )" +
         gyro + R"( }
accel = { columns = ["ax", "ay", "az"], output = "rate", unit = "g", limits = [-4, 4] }
gyro_temperature = { columns = ["T"], unit = "degC" }
)";
}

const char* const stream_session_head = "format = \"imulab.session/1\"\n[imu]\nname = \"unit\"\n[site]\nlatitude_deg = 40.0\n";

Calibration bent_calibration() {
  Calibration c;
  c.model.gyro.matrix << 1.01, 0.02, -0.01, 0.03, 0.99, 0.01, -0.02, 0.01, 1.02;
  c.model.accel.offset << 0.05, -0.03, 0.01;
  c.model.accel.cubic << 1e-5, 2e-5, -1e-5;
  c.model.g_sensitivity(0, 1) = 1e-4;
  c.model.gyro.temperature = ThermalReading{"degC", 20, {0, 70}};
  c.model.gyro.thermal(0, 1) = 1e-4;
  return c;
}

/// Rows with spikes, saturated readings, temperatures that leave the range, and here and there a comment or a row again.
std::string rows(std::size_t n) {
  std::string text = "# logger 3\nt,gx,gy,gz,ax,ay,az,T\n";
  const RandomStream random(5, 1);
  for (std::size_t i = 0; i < n; ++i) {
    const double spike = i % 173 == 100 ? 50 : 0, hot = i % 500 == 250 ? 75 : 20 + 0.01 * static_cast<double>(i % 1000);
    const std::string row =
        fmt::format("{:.2f},{:.3f},{:.3f},{:.3f},{:.4f},{:.4f},{},{:.2f}\n", 0.01 * static_cast<double>(i), 10 + random.normal(6 * i) + spike,
                    random.normal(6 * i + 1), random.normal(6 * i + 2), 0.01 * random.normal(6 * i + 3), 0.02,
                    i % 311 == 5 ? "4.5"
                    : i % 7 == 0 ? "1.0000"
                                 : "0.9999",
                    hot);
    text += row;
    if (i % 700 == 3) text += "# note\n\n" + row;
  }
  return text;
}

/// The table without its flags column.
std::string without_flags(const std::string& text) {
  std::string out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) out += line.substr(0, line.rfind(',')) + "\n";
  return out;
}

TEST(CompensateStream, GivesTheRowsOfTheFileBitForBit) {
  const TemporaryFolder folder;
  folder.write("session.toml", stream_session_head + stream_entry("recording.csv"));
  folder.write("recording.csv", rows(3000));  // some blocks of 64 KiB
  folder.write("calibration.json", calibration_text(bent_calibration()));
  for (const std::string option : {"", " --reject-outliers"}) {
    ASSERT_EQ(run_imulab(folder, "compensate calibration.json . -o file.csv" + option).exit_code, 0);
    const CommandResult stream = run_imulab(folder, "compensate calibration.json - --session . -o - < recording.csv" + option);
    EXPECT_EQ(stream.exit_code, 0) << stream.errors;
    EXPECT_EQ(stream.output, read_text(folder / "file.csv"));
    EXPECT_THAT(stream.errors, HasSubstr("standard input: 5 rows equal to the row before dropped"));
    EXPECT_THAT(stream.errors, HasSubstr("standard input: 10 samples at a limit"));
    EXPECT_THAT(stream.errors, HasSubstr("standard input: 6 of 3000 samples are outside the calibrated temperatures"));
    const CommandResult to_file = run_imulab(folder, "compensate calibration.json - --session session.toml -o stream.csv < recording.csv" + option);
    EXPECT_EQ(to_file.exit_code, 0);
    EXPECT_EQ(read_text(folder / "stream.csv"), stream.output);
    // 17 spikes come after the noise is known; of the saturated readings, which are spikes of 3.5 g, all ten but the one at 5.
    EXPECT_EQ(on_one_line(to_file.output),
              option.empty() ? "stream.csv: 3000 samples, 10 saturated, 6 outside the calibrated temperatures"
                             : "stream.csv: 3000 samples, 10 saturated, 6 outside the calibrated temperatures, 26 with an outlier replaced");
  }
}

TEST(CompensateStream, IncrementsNeedADeclaredRate) {
  const TemporaryFolder folder;
  const std::string increments = R"(output = "increment", unit = "deg")";
  folder.write("session.toml", stream_session_head + stream_entry("recording.csv", increments));
  folder.write("no_rate.toml", stream_session_head + stream_entry("recording.csv", increments, ""));
  folder.write("wrong_rate.toml", stream_session_head + stream_entry("recording.csv", increments, "rate_hz = 200.0\n"));
  folder.write("recording.csv", rows(400));
  folder.write("calibration.json", calibration_text(bent_calibration()));
  ASSERT_EQ(run_imulab(folder, "compensate calibration.json . -o file.csv").exit_code, 0);
  EXPECT_EQ(run_imulab(folder, "compensate calibration.json - --session . -o - < recording.csv").output, read_text(folder / "file.csv"));
  const CommandResult refused = run_imulab(folder, "compensate calibration.json - --session no_rate.toml -o - < recording.csv");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(refused.output, "");
  EXPECT_EQ(refused.errors,
            "imulab: standard input: increments need rate_hz; expected it in the session, since the median interval is known only at the end\n");
  EXPECT_THAT(run_imulab(folder, "compensate calibration.json - --session wrong_rate.toml -o - < recording.csv").errors,
              HasSubstr("standard input: rate_hz = 200 is declared, but the stamps do not say so"));
}

TEST(CompensateStream, ARowGoesOutAsSoonAsItCan) {
  const TemporaryFolder folder;
  folder.write("session.toml", stream_session_head + stream_entry("recording.csv"));
  folder.write("calibration.json", calibration_text(bent_calibration()));
  const std::string command = "'" + command_path() + "' compensate calibration.json - --session . -o - ";
  // The writer goes on only when it has read the answer: a row that waited for more rows would wait for ever.
  const std::string talk = R"(mkfifo in out && (timeout 20 )" + command + R"(OPTION < in > out &) && exec 3> in 4< out &&
echo t,gx,gy,gz,ax,ay,az,T >&3 && for i in 1 2 3 4 5; do echo 0.0$i,1,2,3,0,0,1,20 >&3; [ $i -gt DELAY ] || continue;
[ $i -gt $((DELAY + 1)) ] || read -r header <&4; read -r row <&4; echo "$i ${row%%,*}"; done; exec 3>&-; rm in out)";
  const auto with = [&](const std::string& option, const std::string& delay) {
    std::string text = talk;
    for (const auto& [name, value] : {std::pair{std::string("OPTION"), option}, {std::string("DELAY"), delay}})
      for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) text.replace(at, name.size(), value);
    return run_shell(folder, text).output;
  };
  EXPECT_EQ(with("", "0"), "1 0.01\n2 0.02\n3 0.03\n4 0.04\n5 0.05\n");
  EXPECT_EQ(with("--reject-outliers", "2"), "3 0.01\n4 0.02\n5 0.03\n");
}

TEST(CompensateStream, SaysWhereTheInputIsWrongAndLeavesTheRowsBefore) {
  const TemporaryFolder folder;
  folder.write("session.toml", stream_session_head + stream_entry("recording.csv"));
  folder.write("several.toml", stream_session_head + stream_entry("a.csv") + stream_entry("b.csv"));
  std::string apart = stream_session_head + stream_entry("a.csv");
  folder.write("apart.toml", apart.replace(apart.find("accel = { "), 10, "accel = { file = \"accel.csv\", "));
  folder.write("calibration.json", calibration_text(bent_calibration()));
  const std::string good = "t,gx,gy,gz,ax,ay,az,T\n0.01,1,2,3,0,0,1,20\n0.02,1,2,3,0,0,1,20\n";
  folder.write("text", good + "0.03,1,x,3,0,0,1,20\n");
  folder.write("backwards", good + "0.01,1,2,3,0,0,1,20\n");
  folder.write("last", good + "0.03,1,x,3,0,0,1,20");  // without an end of the line
  folder.write("rows.csv", good);
  folder.write("ragged", good + "0.03,1,2\n");
  folder.write("columns", "t,gx,gy,gz,ax,ay\n0.01,1,2,3,4,5\n");
  folder.write("header", "t,gx,gy,gz,ax,ay,az,T\n");
  folder.write("empty", "");
  folder.write("long", good + std::string(2'000'000, '1'));
  folder.write("binary", std::string(100, '\0'));
  struct Case {
    const char *arguments, *message;
    std::size_t lines;
  };
  for (const Case& c :
       {Case{"- --session . -o - < text", "standard input:4: gy: \"x\" is not a number", 3},
        Case{"- --session . -o - < last", "standard input:4: gy: \"x\" is not a number", 3},
        Case{"- --session . -o - --reject-outliers < text", "standard input:4: gy: \"x\" is not a number", 3},
        Case{"- --session . -o rows.csv < rows.csv", "-o rows.csv: would overwrite the file of standard input", 0},
        Case{"- --session . -o - < backwards", "standard input:4: t: time runs backwards: 0.01 s after 0.02 s", 3},
        Case{"- --session . -o - < ragged", "standard input:4: 3 fields; expected 8 as in the header", 3},
        Case{"- --session . -o - < columns", "standard input: column az is not there; expected one of t, gx, gy, gz, ax, ay", 0},
        Case{"- --session . -o - < header", "standard input: has a header but no rows; expected rows of numbers", 0},
        Case{"- --session . -o - < empty", "standard input: is empty; expected rows of numbers", 0},
        Case{"- --session . -o - < long", "standard input:4: more than 1048576 bytes without a row", 3},
        Case{"- --session . -o - < binary", "standard input: is not text", 0}, Case{"- --session . -o - <&-", "standard input: cannot be read", 0},
        Case{"- -o - < text", "the columns of standard input are not known; expected --session", 0},
        Case{". --session . -o out", "--session and --recording belong to standard input", 0},
        Case{"- --session several.toml -o - < text", "--recording: several.toml: has several recordings; expected one of a.csv, b.csv", 0},
        Case{"- --session several.toml --recording c.csv -o - < text", "--recording: several.toml: has no recording c.csv; did you mean a.csv?", 0},
        Case{"- --session apart.toml -o - < text", "standard input: the session has a triad in a file of its own (accel.csv)", 0},
        Case{"- --session . -o out < text", "-o out: expected a .csv file, or - for standard output", 0},
        Case{"- --session . -o calibration.csv/out.csv < text", "-o calibration.csv/out.csv: cannot be written", 0}}) {
    const CommandResult result = run_imulab(folder, std::string("compensate calibration.json ") + c.arguments);
    EXPECT_EQ(result.exit_code, 2) << c.arguments;
    EXPECT_THAT(result.errors, StartsWith(std::string("imulab: ") + c.message)) << c.arguments;
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), static_cast<std::ptrdiff_t>(c.lines)) << c.arguments << "\n"
                                                                                                                  << result.output;
  }
  EXPECT_EQ(run_imulab(folder, "compensate calibration.json - --session several.toml --recording b.csv -o - < columns").exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  const CommandResult kept = run_imulab(folder, "compensate calibration.json - --session . -o recording.csv < text");
  EXPECT_EQ(kept.exit_code, 2);
  EXPECT_EQ(without_flags(read_text(folder / "recording.csv")).substr(0, 21), "t,gx,gy,gz,ax,ay,az\n0");
  EXPECT_THAT(run_imulab(folder, "compensate calibration.json - --session . -o recording.csv < text").errors, HasSubstr("would overwrite"));
}

/// The most memory that compensating `n` rows as a stream takes [KiB]. Until the child becomes the command it counts this process's memory, too: the
/// rows are written elsewhere.
long peak_memory(const TemporaryFolder& folder, std::size_t n) {
  run_shell(
      folder,
      R"(awk 'BEGIN { print "t,gx,gy,gz,ax,ay,az,T"
for (i = 1; i <= )" +
          std::to_string(n) +
          R"(; ++i) printf "%.2f,%.3f,%.3f,%.3f,%.4f,0.02,1.0000,20.00\n", i / 100, 10 * sin(i), cos(i), sin(2 * i), cos(3 * i) }' > rows.csv)");
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string command = "cd '" + folder.path().string() + "' && ASAN_OPTIONS=quarantine_size_mb=1 exec '" + command_path() +
                                "' compensate calibration.json - --session . --reject-outliers -o - < rows.csv > /dev/null 2>&1";
    ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  return usage.ru_maxrss;
}

TEST(CompensateStream, MemoryDoesNotGrowWithTheLength) {
  const TemporaryFolder folder;
  folder.write("session.toml", stream_session_head + stream_entry("recording.csv"));
  folder.write("calibration.json", calibration_text(bent_calibration()));
  const long few = peak_memory(folder, 20'000), many = peak_memory(folder, 600'000);
  EXPECT_LT(many - few, 4000);  // 580,000 rows more are 30 MB of text and more of columns: a tenth of it is what an allocator may differ by
}

/// The output of a stream that is fed a row every half millisecond.
struct Delays {
  std::vector<double> ms;  ///< from the write of a row to its arrival, sorted
  std::size_t written = 0;
  bool in_order = true;
};

Delays delays_at_2_kHz(const TemporaryFolder& folder, const std::string& program, std::size_t count) {
  using Clock = std::chrono::steady_clock;
  std::array<int, 2> in{}, out{};
  if (::pipe2(in.data(), O_CLOEXEC) != 0 || ::pipe2(out.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  const std::string command = "cd '" + folder.path().string() + "' && exec " + program;
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(in[0], STDIN_FILENO), ::dup2(out[1], STDOUT_FILENO);
    ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    ::_exit(127);
  }
  ::close(in[0]), ::close(out[1]);
  std::vector<Clock::time_point> written(count);
  std::thread writer([&] {
    const std::string header = "t,gx,gy,gz,ax,ay,az,T\n";
    bool open = ::write(in[1], header.data(), header.size()) > 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // until the command has started
    auto due = Clock::now();
    for (std::size_t i = 0; open && i < count; ++i) {
      std::this_thread::sleep_until(due += std::chrono::microseconds(500));
      const std::string row = fmt::format("{:.4f},{:.3f},2.125,-3.250,0.0123,-0.0456,0.9990,25.50\n", 5e-4 * static_cast<double>(i),
                                          0.001 * static_cast<double>(i % 977));
      written[i] = Clock::now();
      open = ::write(in[1], row.data(), row.size()) == static_cast<ssize_t>(row.size());
    }
    ::close(in[1]);
  });
  std::vector<std::pair<std::string, Clock::time_point>> arrived;  // stamps; judged when the writer is done
  std::string text;
  std::array<char, 1 << 16> block{};
  for (ssize_t n = 0; (n = ::read(out[0], block.data(), block.size())) > 0;) {
    const auto now = Clock::now();
    text.append(block.data(), static_cast<std::size_t>(n));
    std::size_t begin = 0;
    for (std::size_t end = text.find('\n'); end != std::string::npos; begin = end + 1, end = text.find('\n', begin))
      if (text[begin] != 't') arrived.emplace_back(text.substr(begin, text.find(',', begin) - begin), now);
    text.erase(0, begin);
  }
  writer.join();
  ::close(out[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  Delays delays;
  delays.written = count;
  for (std::size_t i = 0; i < std::min(count, arrived.size()); ++i) {
    delays.in_order = delays.in_order && std::abs(std::stod(arrived[i].first) - 5e-4 * static_cast<double>(i)) < 1e-9;
    delays.ms.push_back(std::chrono::duration<double, std::milli>(arrived[i].second - written[i]).count());
  }
  delays.in_order = delays.in_order && arrived.size() == count && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  std::sort(delays.ms.begin(), delays.ms.end());
  return delays;
}

TEST(CompensateStream, ASteadyTwoKilohertzIsLateByLessThanTenMilliseconds) {  // ctest: once
  const TemporaryFolder folder;
  folder.write("session.toml", stream_session_head + stream_entry("recording.csv", R"(output = "rate", unit = "deg/s")", "rate_hz = 2000.0\n"));
  folder.write("calibration.json", calibration_text(bent_calibration()));
  for (const std::string option : {"", "--reject-outliers"}) {
    // 99 of 100 rows within 10 ms, where the filter's two samples are one. What `cat` in its place is late by is the machine's: twice that is
    // granted, and one quiet run in three is enough. Rows that wait for a block of many, a quarter of a second on average, fail all three.
    const std::string program = "'" + command_path() + "' compensate calibration.json - --session . -o - " + option;
    double late = HUGE_VAL, most = 0;
    for (int run = 0; run < 3 && !(late < most); ++run) {
      const Delays of_machine = delays_at_2_kHz(folder, "cat", 2000), delays = delays_at_2_kHz(folder, program, 2000);
      ASSERT_TRUE(delays.in_order) << delays.ms.size() << " of " << delays.written << " rows came " << option;
      const auto nearly_all = [](const Delays& d) { return d.ms[d.ms.size() * 99 / 100]; };
      late = nearly_all(delays), most = std::min(100.0, 10 + 2 * nearly_all(of_machine));
      RecordProperty("delay" + option, fmt::format("median {:.3f} ms, 99 % {:.3f} ms, worst {:.3f} ms", delays.ms[1000], late, delays.ms.back()));
    }
    EXPECT_LT(late, most) << option;
  }
}

}  // namespace
}  // namespace imulab
