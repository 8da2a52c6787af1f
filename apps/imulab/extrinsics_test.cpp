#include "imulab/core/random.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/mcap_file.hpp"
#include "tests/recorded_session.hpp"
#include "tests/run_command.hpp"

namespace imulab {
namespace {

using testing::AllOf, testing::HasSubstr, testing::Not;

/// Two IMUs of one body that felt the hand-held session: the second is turned by 90 deg about z, and its clock is 30 ms ahead.
struct TwoImus : testing::Test {
  static std::vector<ImuMessage> messages(bool turned, double noise = 0) {
    std::vector<ImuMessage> out;
    const RandomStream random(1, "right");
    std::uint64_t drawn = 0;
    const std::vector<std::string>& lines = hand_held_session().lines;
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const std::vector<std::string> row = SessionText::fields(lines[i]);
      ImuMessage m{1'700'000'000'000'000'000 + 10'000'000 * static_cast<std::int64_t>(i) + (turned ? 30'000'000 : 0), {}};
      for (std::size_t k = 0; k < 6; ++k) m.readings[k] = std::stod(row[k + 1]);
      if (turned)
        for (const std::size_t first : {0U, 3U}) std::swap(m.readings[first], m.readings[first + 1]), m.readings[first + 1] = -m.readings[first + 1];
      for (double& x : m.readings) x += noise * random.normal(drawn++);
      out.push_back(m);
    }
    return out;
  }

  /// A session of two files that names their IMUs.
  void write_session() const {
    std::string text = "format = \"imulab.session/1\"\n[site]\nlatitude_deg = 47.4\nheight_m = 440\n";
    for (const char* topic : {"/left", "/right"})
      text += std::string("[[recording]]\nfile = \"") + (topic + 1) + ".mcap\"\ntopic = \"" + topic + "\"\nimu = \"" + (topic + 1) +
              "\"\nrate_hz = 100\ntime = { column = \"header.stamp\", unit = \"ns\" }\n"
              "gyro = { columns = [\"angular_velocity.x\", \"angular_velocity.y\", \"angular_velocity.z\"], output = \"rate\", unit = \"rad/s\" }\n"
              "accel = { columns = [\"linear_acceleration.x\", \"linear_acceleration.y\", \"linear_acceleration.z\"], output = \"rate\", unit = "
              "\"m/s^2\" }\n";
    folder.write("two.toml", text);
    folder.write("left.mcap", mcap_file({{"/left", messages(false)}}));
    folder.write("right.mcap", mcap_file({{"/right", messages(true)}}));
  }

  TwoImus() { folder.write("two.mcap", mcap_file({{"/left", messages(false)}, {"/right", messages(true)}})); }
  TemporaryFolder folder;
};

TEST_F(TwoImus, AreFoundInOneLogAndExported) {
  const CommandResult found = run_imulab(folder, "extrinsics two.mcap -o e.json --report e.html -v");
  EXPECT_THAT(found.output, AllOf(HasSubstr("/right relative to /left"), HasSubstr("rotation vector"), HasSubstr("written: e.json"))) << found.errors;
  const std::string json = read_text(folder / "e.json");
  EXPECT_THAT(json, AllOf(HasSubstr("\"format\": \"imulab.extrinsics/1\""), HasSubstr("\"covariance\""), HasSubstr("\"not_shown\"")));
  EXPECT_THAT(read_text(folder / "e.html"), HasSubstr("2 IMUs on one body"));
  EXPECT_EQ(run_imulab(folder, "report e.json -o again.html").exit_code, 0);
  EXPECT_THAT(run_imulab(folder, "export e.json --to kalibr").output, AllOf(HasSubstr("imu1:  # /right\n  T_i_b:"), HasSubstr("time_offset: -0.0")));
  EXPECT_THAT(run_imulab(folder, "export e.json --to ros").output,
              AllOf(HasSubstr("static_transform_publisher"), HasSubstr("--frame-id left --child-frame-id right")));
  EXPECT_THAT(run_imulab(folder, "export e.json --to urdf").output, HasSubstr("<joint name=\"left_to_right\" type=\"fixed\">"));
  EXPECT_THAT(run_imulab(folder, "export e.json --to csv").output, HasSubstr("left,right,clock_offset,0.0"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "export e.json --to px4").errors), HasSubstr("holds no extrinsics; expected one of kalibr, openvins"));
}

TEST_F(TwoImus, OneOfThemTellsWhatItsMotionWouldShow) {
  write_session();
  const CommandResult found = run_imulab(folder, "extrinsics left.mcap");
  folder.write("p.json", run_imulab(folder, "extrinsics left.mcap --json").output);
  EXPECT_THAT(run_imulab(folder, "extrinsics left.mcap -o q.json").errors, HasSubstr("--output, --report: belong to several IMUs"));
  EXPECT_THAT(on_one_line(found.output),
              AllOf(HasSubstr("predicted for another IMU relative to left: rotation to"), HasSubstr("u of the lever arm")));
  EXPECT_THAT(read_text(folder / "p.json"), HasSubstr("\"code\": \"mounting-predicted\""));
  EXPECT_THAT(read_text(folder / "p.json"), HasSubstr("\"clock_offset_s\": null")) << "nothing is measured";
  EXPECT_EQ(run_imulab(folder, "export p.json --to ros").exit_code, 2);

  hand_held_session().write(folder);
  const std::string rows = "head -n 3000 session/recording.csv | '" + command_path() + "' live - --session session --method extrinsics ";
  const CommandResult live = run_shell(folder, rows);
  EXPECT_THAT(live.output, AllOf(HasSubstr("   10.00 s  predicted for another IMU"), HasSubstr("   15.00 s  predicted"))) << live.errors;
  EXPECT_THAT(run_shell(folder, rows + "--json").output, HasSubstr("\"standard_uncertainty\":["));
  EXPECT_THAT(run_shell(folder, rows + "-o c.json").errors, HasSubstr("--output, --require, --rest: belong to a calibration"));
  const CommandResult still =
      run_shell(folder, "head -n 300 session/recording.csv | '" + command_path() + "' live - --session session --method extrinsics");
  EXPECT_EQ(still.exit_code, 1);
  EXPECT_THAT(still.output + still.errors, HasSubstr("its motion shows no mounting; expected 5 s or more"));
}

TEST_F(TwoImus, AreNamedInASession) {
  write_session();
  const CommandResult found = run_imulab(folder, "extrinsics two.toml --grade tactical --calibration none --calibration none");
  EXPECT_THAT(found.output, HasSubstr("right relative to left")) << found.errors;
  const CommandResult each = run_imulab(folder, "calibrate two.toml --method handheld -o c.json");
  EXPECT_EQ(each.exit_code, 0) << each.errors;
  EXPECT_THAT(each.output, AllOf(HasSubstr("IMU 0 of 2: left"), HasSubstr("2 IMUs: all good")));
  EXPECT_THAT(read_text(folder / "c-1.json"),
              AllOf(HasSubstr("\"imu\": \"right\""), HasSubstr("not estimated jointly with the others: the motion explains their noise")));
  folder.write("right.mcap", mcap_file({{"/right", messages(true, 0.005)}}));
  const CommandResult jointly = run_imulab(folder, "calibrate two.toml --method handheld -o c.json --force -v");
  EXPECT_THAT(on_one_line(jointly.output), AllOf(HasSubstr("with the motion in common with left, standard uncertainties are 0."),
                                                 HasSubstr("2 IMUs, estimated jointly: all good")));
  folder.write("half.toml", read_text(folder / "two.toml").replace(read_text(folder / "two.toml").find("imu = \"left\""), 12, ""));
  EXPECT_THAT(on_one_line(run_imulab(folder, "calibrate half.toml --method handheld").errors), HasSubstr("some recordings name their IMU"));
}

TEST_F(TwoImus, OneIsTheReferenceOfTheOther) {
  write_session();
  const CommandResult made = run_imulab(
      folder, "calibrate two.toml --method reference --reference left --calibration tactical -o r.json --report r.html --curves offsets.csv");
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  EXPECT_THAT(read_text(folder / "offsets.csv"), HasSubstr("t,gyro.offset.x,gyro.offset.x.sigma"));
  EXPECT_THAT(read_text(folder / "r.html"), HasSubstr("Offsets over time"));
  const nlohmann::json found = nlohmann::json::parse(read_text(folder / "r.json"));
  EXPECT_EQ(found["imu"], "right");
  EXPECT_EQ(found["options"]["reference"], "left");
  EXPECT_GT(found["quality"]["degrees_of_freedom"], 60) << "seconds";
  for (std::size_t i = 0; i < 3; ++i) {  // both have the same readings but for their axes
    EXPECT_NEAR(found["model"]["gyro"]["matrix"][i][i].get<double>(), 1, 4 * found["standard_uncertainty"]["gyro"]["matrix"][i][i].get<double>());
    EXPECT_NEAR(found["model"]["accel"]["offset"][i].get<double>(), 0, 4 * found["standard_uncertainty"]["accel"]["offset"][i].get<double>());
    EXPECT_LT(found["standard_uncertainty"]["gyro"]["matrix"][i][i].get<double>(), 2e-3);
  }
  const auto refused = [&](const std::string& options) { return on_one_line(run_imulab(folder, "calibrate two.toml --method " + options).errors); };
  EXPECT_THAT(refused("reference"), HasSubstr("--reference: is missing; expected the better IMU"));
  EXPECT_THAT(refused("reference --reference up"), HasSubstr("--reference: up: two.toml has no IMU of this name"));
  EXPECT_THAT(refused("reference --reference left --calibration toy.json"), HasSubstr("toy.json: cannot be opened"));
  EXPECT_THAT(refused("handheld --reference left"), HasSubstr("--reference: only the method reference has one"));
  EXPECT_THAT(refused("handheld --calibration tactical"), HasSubstr("--calibration: only the method reference has a reference"));
}

TEST_F(TwoImus, HostileNamesEndNoComment) {
  run_imulab(folder, "extrinsics two.mcap -o e.json");
  std::string json = read_text(folder / "e.json");
  for (std::size_t at = 0; (at = json.find("\"/right\"", at)) != std::string::npos; at += 8) json.replace(at, 8, R"("a-->\nrm -rf b")");
  json.replace(json.find("\"not_shown\": []"), 15, R"("not_shown": ["x-->\nrm -rf c"])");
  json.insert(json.find("\"headline\": \"") + 13, std::string(400, '-'));
  folder.write("hostile.json", json);
  const std::string urdf = run_imulab(folder, "export hostile.json --to urdf").output,
                    ros = run_imulab(folder, "export hostile.json --to ros").output;
  EXPECT_EQ(urdf.find("-->"), urdf.rfind("-->")) << urdf;
  EXPECT_THAT(ros, AllOf(HasSubstr("# "), Not(HasSubstr("\nrm")))) << ros;
  for (std::size_t at = 0; (at = json.find(R"("a-->\nrm -rf b")", at)) != std::string::npos;) json.replace(at, 16, "\"\"");
  folder.write("unnamed.json", json);
  EXPECT_THAT(run_imulab(folder, "export unnamed.json --to ros").output, HasSubstr("--child-frame-id imu\n"));
  EXPECT_THAT(on_one_line(run_imulab(folder, "export e.json --to kalibr --topic /x").errors), HasSubstr("--topic: belongs to calibrations"));
}

TEST_F(TwoImus, WrongOptionsAreNamed) {
  EXPECT_THAT(run_imulab(folder, "extrinsics two.mcap two.mcap").errors, HasSubstr("two.mcap: /left: two IMUs have this name"));
  folder.write("open.json", R"({"format": "imulab.calibration/1", "quality": {"unobservable": ["accel.offset.x"]}, "model": {}})");
  EXPECT_NE(run_imulab(folder, "extrinsics two.mcap --calibration open.json --calibration none").exit_code, 0);
  EXPECT_THAT(on_one_line(run_imulab(folder, "extrinsics two.mcap --calibration none").errors),
              HasSubstr("given 1 times; expected one for each of 2 IMUs, in the order of /left, /right"));
  EXPECT_THAT(run_imulab(folder, "extrinsics two.mcap --grade toy").errors, HasSubstr("toy"));
  EXPECT_EQ(run_imulab(folder, "extrinsics nothing.csv").exit_code, 2);
}

}  // namespace
}  // namespace imulab
