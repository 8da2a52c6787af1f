// Recordings with topics, and recordings that are folders, as verbs take them.
#include <gmock/gmock.h>

#include "tests/mcap_file.hpp"
#include "tests/recorded_session.hpp"
#include "tests/run_command.hpp"
#include <sys/stat.h>

namespace imulab {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// The messages of the hand-held session, of which each part of a bag has some.
std::vector<ImuMessage> hand_held_messages() {
  std::vector<ImuMessage> messages;
  const std::vector<std::string>& lines = hand_held_session().lines;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> row = SessionText::fields(lines[i]);
    ImuMessage m{1'700'000'000'000'000'000 + 10'000'000 * static_cast<std::int64_t>(i), {}};
    for (std::size_t k = 0; k < 6; ++k) m.readings[k] = std::stod(row[k + 1]);
    messages.push_back(m);
  }
  return messages;
}

struct RecordingTopics : testing::Test {
  TemporaryFolder folder;
  const std::vector<ImuMessage> all = hand_held_messages();
};

TEST_F(RecordingTopics, ASplitBagIsOneRecordingOfEveryVerb) {
  std::filesystem::create_directories(folder / "run");
  const auto half = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  folder.write("run/run_0.mcap", mcap_file({{"/imu/data", {all.begin(), half}}}));
  folder.write("run/run_1.mcap", mcap_file({{"/imu/data", {half, all.end()}}}));
  const CommandResult inspected = run_imulab(folder, "inspect run/ -o run.toml --json");
  EXPECT_EQ(inspected.exit_code, 0) << inspected.errors;
  EXPECT_THAT(inspected.output, HasSubstr("\"topic\": \"/imu/data\""));
  EXPECT_THAT(inspected.output, HasSubstr("\"rows\": 14400"));
  for (const char* recording : {"run", "run.toml", "run/run_0.mcap run/run_1.mcap"}) {
    const CommandResult result = run_imulab(folder, std::string("calibrate ") + recording + " --method handheld -o c.json --force");
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_THAT(read_text(folder / "c.json"), HasSubstr("\"topic\": \"/imu/data\""));
  }
  EXPECT_THAT(run_imulab(folder, "export c.json --to openvins").errors,
              HasSubstr("no noise.json was given: the white noise is that of the calibration's rests"));
  EXPECT_THAT(run_imulab(folder, "verify c.json").output, HasSubstr("run_0.mcap+run_1.mcap: unchanged"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "compensate c.json run -o out.csv").output), HasSubstr("out.csv: 14400 samples"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "compensate c.json run -o out.mcap").errors), HasSubstr("run is a bag of several files"));
  EXPECT_EQ(run_imulab(folder, "compensate c.json run -o run/run_0.mcap").exit_code, 2) << "which is an input";
}

TEST_F(RecordingTopics, AreChosenOnEveryVerb) {
  folder.write("two.mcap", mcap_file({{"/a", all}, {"/b", all}}));
  for (const char* verb : {"noise two.mcap", "inspect two.mcap"}) {
    EXPECT_THAT(run_imulab(folder, verb).errors, HasSubstr("expected a topic of /a, /b")) << verb;
    EXPECT_THAT(run_imulab(folder, std::string(verb) + " --topic /b").errors, testing::Not(HasSubstr("expected a topic"))) << verb;
  }
  const CommandResult each = run_imulab(folder, "calibrate two.mcap --method handheld -o c.json --report imus.html");
  EXPECT_EQ(each.exit_code, 0) << each.errors;
  EXPECT_THAT(each.output, AllOf(HasSubstr("IMU 0 of 2: /a"), HasSubstr("IMU 1 of 2: /b"), HasSubstr("2 IMUs: all good")));
  EXPECT_THAT(read_text(folder / "imus.html"), HasSubstr("2 IMUs of two.mcap"));
  EXPECT_THAT(read_text(folder / "c-1.json"), HasSubstr("\"topic\": \"/b\""));
  EXPECT_EQ(run_imulab(folder, "compensate c-0.json two.mcap --topic /a -o out.csv").exit_code, 0);
  EXPECT_EQ(run_imulab(folder, "calibrate two.mcap --method handheld --topic /b -o b.json").exit_code, 0) << "one alone";
  EXPECT_THAT(run_imulab(folder, "calibrate two.mcap --method handheld -o c.json").errors, HasSubstr("c-0.json: exists"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "calibrate two.mcap --method handheld --json").errors), HasSubstr("has 2 IMUs, and --json"));
  hand_held_session().write(folder);
  EXPECT_THAT(on_one_line(run_imulab(folder, "noise session --topic /a").errors), HasSubstr("--topic: chooses a table of a recording"));
}

TEST(OpenStreams, ThatAreNoTextOrSilentEnd) {
  const TemporaryFolder folder;
  EXPECT_THAT(run_imulab(folder, "inspect /dev/zero").errors, HasSubstr("/dev/zero: is not text"));
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(run_imulab(folder, "fleet list --store pipe").errors, HasSubstr("pipe: is a pipe or a device; expected a fleet store"));
  EXPECT_THAT(run_imulab(folder, "inspect pipe").errors, HasSubstr("pipe: nobody writes to this pipe; expected a writer within 5 s"));
}

TEST(Aids, AreNamedAndRefused) {
  const TemporaryFolder folder;
  folder.write("a.pos", "% program   : RTKPOST ver.2.4.3\n%  GPST          latitude(deg) longitude(deg)\n2024/01/01 00:00:00.000 47.1 8.1 400 1 8\n");
  folder.write("b.nmea", "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n$GPRMC,123519,A,4807.038,N\r\n");
  EXPECT_THAT(on_one_line(run_imulab(folder, "inspect a.pos").errors),
              HasSubstr("a.pos: is an aid of kind gnss and no recording; expected the readings of an IMU, and this file beside them"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "inspect b.nmea").errors), HasSubstr("b.nmea: is an aid of kind gnss and no recording"));
  folder.write("session.toml",
               "format = \"imulab.session/1\"\n[[recording]]\nfile = \"b.nmea\"\ntime = { column = 1, unit = \"s\" }\n"
               "gyro = { columns = [1, 2, 3], output = \"rate\", unit = \"rad/s\" }\n"
               "accel = { columns = [1, 2, 3], output = \"rate\", unit = \"g\" }\n");
  EXPECT_THAT(on_one_line(run_imulab(folder, "inspect session.toml").errors), HasSubstr("b.nmea: is a GNSS solution (NMEA 0183), an aid"));
}

}  // namespace
}  // namespace imulab
