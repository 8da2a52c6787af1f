// imulab noise: from a log at rest to coefficients, and what it refuses.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/still_log.hpp"
#include <array>
#include <cmath>

namespace imulab {
namespace {

using ::testing::HasSubstr;

TEST(NoiseCommand, StatesTheWhiteNoiseAndNoMore) {
  const TemporaryFolder folder;
  write_still_log(folder, 20000, still_readings);
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
  const CommandResult page = run_imulab(folder, "noise session.toml -o page --report page");
  EXPECT_EQ(page.exit_code, 2) << "one would replace the other";
  EXPECT_FALSE(std::filesystem::exists(folder / "page"));
  const CommandResult again = run_imulab(folder, "noise session.toml -o noise.json");
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.errors, HasSubstr("-o noise.json: exists"));
  EXPECT_THAT(run_imulab(folder, "noise session.toml --json --deviation total").output, HasSubstr("\"deviation\": \"total\""));
}

TEST(NoiseCommand, TakesALogWithoutASession) {
  const TemporaryFolder folder;
  write_still_log(folder, 6000, still_readings);
  const CommandResult asked = run_imulab(folder, "noise log.csv");
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.errors, HasSubstr("gyro.unit"));
  const CommandResult result = run_imulab(folder, "noise log.csv --set gyro.unit=rad/s");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("deg/sqrt(h)"));
}

TEST(NoiseCommand, CutsKnocksAndGaps) {
  const TemporaryFolder folder;
  write_still_log(
      folder, 20000,
      [](int i) {
        std::array<double, 6> row = still_readings(i);
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

/// Turned by 10 degrees about the vertical in 10 s: too slow for the detection of rests.
ReadingsAt turned_slowly_at(double begin_s) {
  return [begin_s](int i) {
    std::array<double, 6> row = still_readings(i);
    if (const double t = 0.01 * i - begin_s; t > 0 && t < 10) row[2] += 0.0175 * (1 - std::cos(0.2 * M_PI * t));
    return row;
  };
}

TEST(NoiseCommand, CutsSlowMotion) {
  const TemporaryFolder folder;
  write_still_log(folder, 10000, turned_slowly_at(20));
  const CommandResult result = run_imulab(folder, "noise session.toml");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  const std::string text = on_one_line(result.output);
  EXPECT_THAT(text, HasSubstr("slow motion was cut"));
  EXPECT_THAT(text, testing::ContainsRegex("at rest: (29|3[01])[0-9.]* to 100 s"));
  write_still_log(folder, 4000, turned_slowly_at(15));
  const CommandResult short_one = run_imulab(folder, "noise session.toml");
  EXPECT_EQ(short_one.exit_code, 1);
  EXPECT_THAT(on_one_line(short_one.errors), HasSubstr("s of it without gaps and slow motion; expected at least 30 s"));
}

struct Refusal {
  const char* name;
  int samples;
  ReadingsAt row;
  const char* message;
};

TEST(NoiseCommand, RefusesWhatShowsNoNoise) {
  const std::vector<Refusal> refusals{
      {"three seconds", 300, still_readings, "has 3 s, 300 samples: too short to see noise; expected at least 30 s and 1024 samples at rest"},
      {"motion throughout", 6000,
       [](int i) {
         std::array<double, 6> row = still_readings(i);
         for (std::size_t k = 0; k < 6; ++k) row[k] += (1 + 0.5 * std::sin(0.0137 * i)) * std::sin(0.05 * i + static_cast<double>(k));
         return row;
       },
       "expected at least 30 s and 1024 samples at rest"},
      {"a constant axis", 6000,
       [](int i) {
         std::array<double, 6> row = still_readings(i);
         row[1] = 0.001;
         return row;
       },
       "no noise to be seen on gyro.y; expected readings that vary"},
      {"all constant", 6000, [](int) { return std::array<double, 6>{0, 0, 0, 0, 0, 9.8}; }, "no noise to be seen on gyro.x, gyro.y, gyro.z, accel.x"},
      {"a saturated axis", 6000,
       [](int i) {
         std::array<double, 6> row = still_readings(i);
         row[3] = std::min(row[3], 0.004);
         return row;
       },
       "samples are saturated (accel.x): the noise is cut off there"}};
  for (const Refusal& r : refusals) {
    const TemporaryFolder folder;
    write_still_log(folder, r.samples, r.row);
    const CommandResult result = run_imulab(folder, "noise session.toml");
    EXPECT_EQ(result.exit_code, 1) << r.name << result.errors;
    EXPECT_THAT(result.errors, HasSubstr(r.message)) << r.name;
  }
}

TEST(NoiseCommand, LeavesOutARowWithoutANumberAndRefusesMany) {
  for (const int many : {1, 200}) {
    const TemporaryFolder folder;
    write_still_log(folder, 6000, [&](int i) {
      std::array<double, 6> row = still_readings(i);
      if (i >= 3000 && i < 3000 + many) row[2] = NAN;
      return row;
    });
    const CommandResult result = run_imulab(folder, "noise session.toml");
    EXPECT_EQ(result.exit_code, many == 1 ? 0 : 2) << result.errors;
    EXPECT_THAT(result.errors, HasSubstr(many == 1 ? "1 line left out (nothing is measured there), the first line 3001: gz: nan is not a reading"
                                                   : "log.csv:3001: gz: nan is not a reading; expected a finite number; so in 200 rows"));
    const CommandResult bare = run_imulab(folder, "noise log.csv --set gyro.unit=rad/s");
    EXPECT_EQ(bare.exit_code, many == 1 ? 0 : 2);
    if (many > 1) EXPECT_THAT(bare.errors, HasSubstr("has no finite number in 200 of 6000 rows, first in line 3001: no more than 1 row in 100"));
  }
}

TEST(NoiseCommand, RefusesARateThatChanges) {
  const TemporaryFolder folder;
  const auto result_of = [&](double first_s, double second_s, int first, int rows) {
    std::string text = "t,gx,gy,gz,ax,ay,az\n";
    for (int i = 1; i <= rows; ++i) {
      text += fmt::format("{:.3f}", i <= first ? first_s * i : first_s * first + second_s * (i - first));
      for (const double value : still_readings(i)) text += "," + std::to_string(value);
      text += "\n";
    }
    folder.write("log.csv", text);
    return run_imulab(folder, "noise log.csv --set gyro.unit=rad/s");
  };
  for (const auto& [first_s, second_s] : {std::pair{0.01, 0.02}, {0.01, 0.011}}) {
    const CommandResult result = result_of(first_s, second_s, 4000, 8000);
    EXPECT_EQ(result.exit_code, 1) << result.output;
    EXPECT_THAT(result.errors, HasSubstr("the rate changes: 100, 100, 100, 100, "));
  }
  // More than half of it at 100 Hz: the rest is gaps.
  EXPECT_THAT(on_one_line(result_of(0.01, 0.02, 5000, 8000).output), HasSubstr("at rest: 0 to 50 s, 5000 samples"));
}

/// 400 Hz to a millisecond advance by 2 and by 3 ms; 800 Hz by 1 and by 2 ms, and 200 Hz by 5 ms.
TEST(NoiseCommand, StampsThatAreRoundedAreThoseOfAnEvenClock) {  // ctest: once
  const TemporaryFolder folder;
  const auto density = [&](double rate_hz, int digits, const std::string& session) {
    std::string text = "t,gx,gy,gz,ax,ay,az\n";
    for (int i = 1; i <= 60000; ++i) {
      text += fmt::format("{:.{}f}", i / rate_hz, digits);
      for (const double value : still_readings(i)) text += "," + std::to_string(value);
      text += "\n";
    }
    folder.write("log.csv", text);
    const CommandResult result = run_imulab(folder, "noise log.csv --set gyro.unit=rad/s --json" + session);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    if (digits == 3 && rate_hz != 200)
      EXPECT_THAT(result.errors,
                  HasSubstr(fmt::format("the stamps are rounded to 0.001 s; an even clock of {:g} s ({:g} Hz) fits them", 1 / rate_hz, rate_hz)));
    else
      EXPECT_THAT(result.errors, testing::Not(HasSubstr("rounded")));
    return nlohmann::json::parse(result.output).at("axes").at(0).at("coefficients").at("N").at("value").get<double>();
  };
  for (const double rate_hz : {200.0, 400.0, 800.0})  // the clock's rate to 1e-6 of the mean: as of exact stamps
    EXPECT_NEAR(density(rate_hz, 3, "") / density(rate_hz, 6, ""), 1, 1e-4) << rate_hz;
}

/// A serial line's stamps: late by up to 4 ms, so that their usual difference is not the sensor's interval.
TEST(NoiseCommand, StampsThatScatterAreThoseOfAnEvenClock) {
  const TemporaryFolder folder;
  std::string text = "t,gx,gy,gz,ax,ay,az\n";
  for (int i = 1; i <= 20000; ++i) {
    text += fmt::format("{:.6f}", 0.01 * i + (i % 4 == 0 ? 0.004 : i % 4 * 0.00025));
    for (const double value : still_readings(i)) text += "," + std::to_string(value);
    text += "\n";
  }
  folder.write("log.csv", text);
  const CommandResult result = run_imulab(folder, "noise log.csv --set gyro.unit=rad/s");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(on_one_line(result.output), HasSubstr("about an even clock of 10 ms, which is used in their place"));
}

TEST(NoiseCommand, TakesTheTemperatureAway) {
  const TemporaryFolder folder;
  std::ostringstream text;
  text.precision(12);
  text << "t,gx,gy,gz,ax,ay,az,T\n";
  for (int i = 1; i <= 20000; ++i) {
    const double warm = 20 + 5 * (1 - std::exp(-i / 8000.0));
    text << 0.01 * i;
    const std::array<double, 6> row = still_readings(i);
    for (std::size_t k = 0; k < 6; ++k) text << ',' << row[k] + (k < 3 ? 1e-3 : 1e-2) * (warm - 20);
    text << ',' << warm + 0.01 * repeated_noise(i, 7) << '\n';
  }
  folder.write("log.csv", text.str());
  const std::string session =
      "format = \"imulab.session/1\"\n[imu]\nname = \"test\"\n[site]\nlatitude_deg = 47.0\n[rig]\nkind = \"none\"\n"
      "[[recording]]\nfile = \"log.csv\"\nrate_hz = 100\ntime = { column = \"t\", unit = \"s\" }\n"
      "gyro = { columns = [\"gx\", \"gy\", \"gz\"], output = \"rate\", unit = \"rad/s\" }\n"
      "accel = { columns = [\"ax\", \"ay\", \"az\"], output = \"rate\", unit = \"m/s^2\" }\n";
  const std::string thermometers =
      "gyro_temperature = { columns = [\"T\"], unit = \"degC\" }\naccel_temperature = { columns = [\"T\"], unit = \"degC\" }\n";
  folder.write("warm.toml", session + thermometers + "[[step]]\nkind = \"hold\"\nduration_s = 200\n");
  folder.write("bare.toml", session + "[[step]]\nkind = \"hold\"\nduration_s = 200\n");
  const CommandResult as_is = run_imulab(folder, "noise warm.toml");
  EXPECT_THAT(on_one_line(as_is.errors), HasSubstr("temperature changed by 4.")) << as_is.errors;
  const CommandResult without = run_imulab(folder, "noise warm.toml --remove-temperature");
  EXPECT_EQ(without.exit_code, 0) << without.errors;
  EXPECT_THAT(on_one_line(without.output),
              testing::ContainsRegex("gyro.x: a parabola of the temperature was removed, 0.00(099[0-9]|1|100[0-9]) rad/s per degree"))
      << "one sigma of the slope is 0.3 %";
  EXPECT_THAT(without.output, HasSubstr("gyro.x   K           -  below ")) << "the drift of 5 mrad/s was the temperature's";
  EXPECT_THAT(without.output, testing::Not(HasSubstr("Markov"))) << "nor is anything else left";
  const CommandResult none = run_imulab(folder, "noise bare.toml --remove-temperature");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.errors, HasSubstr("has no gyro temperature to remove"));
}

TEST(NoiseCommand, PutsSeveralLogsTogether) {
  const TemporaryFolder folder;
  write_still_log(folder, 6000, still_readings);
  ASSERT_EQ(run_imulab(folder, "noise session.toml -o one.json").exit_code, 0);
  const CommandResult result = run_imulab(folder, "noise session.toml session.toml -o two.json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("2 logs\n"));
  const std::string json = read_text(folder / "two.json");
  for (const char* key : {"\"recording\": \"2 logs\"", "\"spread\": 0", "\"logs\": 2", "\"worst_log\": 0"}) EXPECT_THAT(json, HasSubstr(key));
  EXPECT_EQ(run_imulab(folder, "noise session.toml session.toml --report page.html").exit_code, 0);
  EXPECT_NE(read_text(folder / "page.html").find("<h1>2 logs</h1>"), std::string::npos);
}

/// The result of simulate: a unit of the noise that an analysis found has that noise in its own analysis.
TEST(NoiseCommand, ItsNumbersComeBackFromASimulation) {
  const TemporaryFolder folder;
  write_still_log(folder, 20000, still_readings);
  ASSERT_EQ(run_imulab(folder, "noise session.toml -o noise.json").exit_code, 0);
  const std::string procedure =
      "format = \"imulab.session/1\"\n[imu]\nname = \"test\"\nNOISE[site]\nlatitude_deg = 47.0\nheight_m = 0.0\n[rig]\nkind = \"none\"\n"
      "[[step]]\nkind = \"hold\"\nduration_s = 200\n";
  const auto with = [&](const std::string& noise) { return std::string(procedure).replace(procedure.find("NOISE"), 5, noise); };
  folder.write("procedure.toml", with(""));
  folder.write("declared.toml", with("grade = \"mems\"\nnoise = \"noise.json\"\n"));
  folder.write("unknown.toml", with("noise = \"pink\"\n"));
  folder.write("missing.toml", with("noise = \"none.json\"\n"));
  ASSERT_EQ(run_imulab(folder, "simulate procedure.toml --grade noise.json -o again").exit_code, 0);
  const CommandResult again = run_imulab(folder, "noise again");
  // 5.774e-5 rad/s/sqrt(Hz) = 0.1985 deg/sqrt(h), and 5.774e-4 m/s^2/sqrt(Hz) = 58.9 ug/sqrt(Hz); 20000 samples tell 0.5 %.
  EXPECT_THAT(again.output, testing::ContainsRegex("gyro.x   N +0\\.(19|20)")) << again.errors;
  EXPECT_THAT(again.output, testing::ContainsRegex("accel.x  N +(5[789]|60)\\."));
  const CommandResult declared = run_imulab(folder, "simulate declared.toml -o declared");
  ASSERT_EQ(declared.exit_code, 0) << declared.errors;
  EXPECT_THAT(read_text(folder / "declared" / "session.toml"), HasSubstr("gyro_noise_density = 5."));
  EXPECT_THAT(run_imulab(folder, "simulate unknown.toml -o x").errors, HasSubstr("imu.noise: \"pink\" is not allowed; expected white, full"));
  EXPECT_THAT(run_imulab(folder, "simulate missing.toml -o x").errors, HasSubstr("none.json"));
}

}  // namespace
}  // namespace imulab
