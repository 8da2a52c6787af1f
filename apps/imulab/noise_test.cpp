// imulab noise: from a log at rest to coefficients, and what it refuses.
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <cmath>
#include <functional>

namespace imulab {
namespace {

using ::testing::HasSubstr;

using Row = std::function<std::array<double, 6>(int i)>;

/// A number between -1 and 1 that looks random: Weyl's sequence, mixed.
double noise(int i, int axis) {
  const double x = std::sin(12.9898 * i + 78.233 * axis) * 43758.5453;
  return 2 * (x - std::floor(x)) - 1;
}

std::array<double, 6> still(int i) {
  std::array<double, 6> row{};
  for (int k = 0; k < 6; ++k) row[static_cast<std::size_t>(k)] = (k < 3 ? 1e-3 : 0.01) * noise(i, k) + (k == 5 ? 9.8 : 0);
  return row;
}

void write_log(const TemporaryFolder& folder, int samples, const Row& row, int skip_from = -1, int skip = 0) {
  std::ostringstream text;
  text.precision(12);
  text << "t,gx,gy,gz,ax,ay,az\n";
  for (int i = 1; i <= samples; ++i) {
    text << 0.01 * (i + (skip_from >= 0 && i > skip_from ? skip : 0));
    for (const double value : row(i)) text << ',' << value;
    text << '\n';
  }
  folder.write("log.csv", text.str());
  folder.write("session.toml",
               "format = \"imulab.session/1\"\n[imu]\nname = \"test\"\n[site]\nlatitude_deg = 47.0\n[rig]\nkind = \"none\"\n"
               "[[recording]]\nfile = \"log.csv\"\nrate_hz = 100\ntime = { column = \"t\", unit = \"s\" }\n"
               "gyro = { columns = [\"gx\", \"gy\", \"gz\"], output = \"rate\", unit = \"rad/s\" }\n"
               "accel = { columns = [\"ax\", \"ay\", \"az\"], output = \"rate\", unit = \"m/s^2\" }\n");
}

TEST(NoiseCommand, StatesTheWhiteNoiseAndNoMore) {
  const TemporaryFolder folder;
  write_log(folder, 20000, still);
  const CommandResult result = run_imulab(folder, "noise session.toml -o noise.json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("at rest: 0 to 200 s, 20000 samples; 0 of 200 s were cut"));
  EXPECT_THAT(result.output, HasSubstr("gyro.x   K           -  below "));
  EXPECT_THAT(result.output, HasSubstr("written: noise.json"));
  // Uniform between -1 and 1: sigma 1 / sqrt(3); at 100 Hz N is a tenth of it, 5.774e-5 rad/s/sqrt(Hz) = 0.1985 deg/sqrt(h).
  EXPECT_THAT(result.output, testing::ContainsRegex("gyro.x   N +0\\.(19|20)"));
  const std::string json = read_text(folder / "noise.json");
  for (const char* key : {"\"format\": \"imulab.noise/1\"", "\"name\": \"accel.z\"", "\"tau\": [", "\"edf\": [", "\"lower\": [",
                          "\"determined\": false", "\"value\": null", "\"accepted\": true"})
    EXPECT_THAT(json, HasSubstr(key));
  EXPECT_EQ(run_imulab(folder, "noise session.toml --json").output, json);
  EXPECT_EQ(run_imulab(folder, "noise session.toml --json --threads 1").output, json);
  const CommandResult again = run_imulab(folder, "noise session.toml -o noise.json");
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.errors, HasSubstr("-o noise.json: exists"));
  EXPECT_THAT(run_imulab(folder, "noise session.toml --json --deviation total").output, HasSubstr("\"deviation\": \"total\""));
}

TEST(NoiseCommand, TakesALogWithoutASession) {
  const TemporaryFolder folder;
  write_log(folder, 6000, still);
  const CommandResult asked = run_imulab(folder, "noise log.csv");
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.errors, HasSubstr("gyro.unit"));
  const CommandResult result = run_imulab(folder, "noise log.csv --set gyro.unit=rad/s");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("deg/sqrt(h)"));
}

TEST(NoiseCommand, CutsKnocksAndGaps) {
  const TemporaryFolder folder;
  write_log(
      folder, 20000,
      [](int i) {
        std::array<double, 6> row = still(i);
        if (i > 4000 && i < 4200)
          for (double& value : row) value += 0.5 * std::sin(0.3 * i);  // somebody walks into the table
        return row;
      },
      15000, 500);
  const CommandResult result = run_imulab(folder, "noise session.toml");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const std::string text = on_one_line(result.output);
  EXPECT_THAT(text, HasSubstr("of motion or knocks"));
  EXPECT_THAT(text, HasSubstr("gaps in the recording: 1; the part used has none"));
  EXPECT_THAT(text, testing::ContainsRegex("at rest: 4[12][0-9.]* to 150 s"));
}

struct Refusal {
  const char* name;
  int samples;
  Row row;
  const char* message;
};

TEST(NoiseCommand, RefusesWhatShowsNoNoise) {
  const std::vector<Refusal> refusals{
      {"three seconds", 300, still, "has 3 s, 300 samples: too short to see noise; expected at least 30 s and 1024 samples at rest"},
      {"motion throughout", 6000,
       [](int i) {
         std::array<double, 6> row = still(i);
         for (std::size_t k = 0; k < 6; ++k) row[k] += (1 + 0.5 * std::sin(0.0137 * i)) * std::sin(0.05 * i + static_cast<double>(k));
         return row;
       },
       "expected at least 30 s and 1024 samples at rest"},
      {"a constant axis", 6000,
       [](int i) {
         std::array<double, 6> row = still(i);
         row[1] = 0.001;
         return row;
       },
       "no noise to be seen on gyro.y; expected readings that vary"},
      {"all constant", 6000, [](int) { return std::array<double, 6>{0, 0, 0, 0, 0, 9.8}; }, "no noise to be seen on gyro.x, gyro.y, gyro.z, accel.x"},
      {"a saturated axis", 6000,
       [](int i) {
         std::array<double, 6> row = still(i);
         row[3] = std::min(row[3], 0.004);
         return row;
       },
       "samples are saturated (accel.x): the noise is cut off there"}};
  for (const Refusal& r : refusals) {
    const TemporaryFolder folder;
    write_log(folder, r.samples, r.row);
    const CommandResult result = run_imulab(folder, "noise session.toml");
    EXPECT_EQ(result.exit_code, 1) << r.name << result.errors;
    EXPECT_THAT(result.errors, HasSubstr(r.message)) << r.name;
  }
}

}  // namespace
}  // namespace imulab
