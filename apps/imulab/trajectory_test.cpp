// `imulab trajectory` as a user types it: the folder it makes comes back to its truth when it is integrated, and what is wrong is named.
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/session/file.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/run_command.hpp"
#include <cmath>

namespace imulab {
namespace {

using ::testing::HasSubstr;

const std::string start = "[start]\nlatitude_deg = 47.4\nlongitude_deg = 8.5\nheight_m = 450\n";

/// A mission from [start] and segments; `head` stands before the first table.
std::string mission(const std::string& segments, const std::string& head = "", const std::string& from = start) {
  return "format = \"imulab.mission/1\"\n" + head + from + segments;
}

std::string segment(const std::string& keys) { return "[[segment]]\n" + keys + "\n"; }

const std::string every_kind =
    segment("kind = \"rest\"\nduration_s = 20\nsway_angle_deg = 0.05\nsway_angle_hz = 2\nsway_m = 0.001\nsway_hz = 5") +
    segment("kind = \"rotate\"\naxis = \"z\"\nangle_deg = -120\nrate_dps = 20") + segment("kind = \"accelerate\"\nto_mps = 60\nduration_s = 20") +
    segment("kind = \"straight\"\nduration_s = 10") + segment("kind = \"climb\"\nangle_deg = 5\nduration_s = 10") +
    segment("kind = \"turn\"\nangle_deg = 90\nrate_dps = 4") + segment("kind = \"turn\"\nangle_deg = -60\nradius_m = 800\nroll_s = 2") +
    segment("kind = \"s_turn\"\nangle_deg = 30\nrate_dps = 4") + segment("kind = \"dive\"\nangle_deg = 5\nduration_s = 10") +
    segment("kind = \"repeat\"\nlast = 3\ntimes = 2") + segment("kind = \"brake\"\nduration_s = 20") + segment("kind = \"rest\"\nduration_s = 5");

NavigationState start_of(const Session& session) {
  const InitialState& i = session.initial.value();
  NavigationState s;
  s.q_nb = Eigen::Quaterniond(attitude_matrix({i.roll, i.pitch, i.heading}));
  s.velocity = {i.velocity_enu[0], i.velocity_enu[1], i.velocity_enu[2]};
  s.latitude = i.latitude, s.longitude = i.longitude, s.height = i.height;
  return s;
}

struct Worst {
  double way = 0, velocity = 0, attitude = 0;  // m, m/s, rad
};

/// The folder's recording integrated with a free vertical channel, against its truth.
Worst integrated(const std::filesystem::path& folder) {
  const Session session = read_session(folder);
  const RecordingReading reading = read_recording(session, session.recordings.at(0));
  EXPECT_TRUE(reading.warnings.empty());
  const Recording& r = reading.recording;
  const Solution truth = read_solution(session_path(session, session.truth_file.value()));
  EXPECT_EQ(truth.time.front(), 0);
  EXPECT_NEAR(truth.time.back(), r.time_s(r.size() - 1), 1e-9);
  Strapdown strapdown(start_of(session));
  Worst worst;
  std::size_t row = 1;
  for (std::size_t i = 0; i < r.size(); ++i) {
    Increment sample;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sample.angle[static_cast<int>(axis)] = r.gyro[axis][i] * r.interval_s;
      sample.velocity[static_cast<int>(axis)] = r.accel[axis][i] * r.interval_s;
    }
    strapdown.step(sample, r.interval_s);
    if (row == truth.size() || std::abs(truth.time[row] - r.time_s(i)) > 1e-6) continue;
    const NavigationState &a = strapdown.state(), &b = truth.states[row++];
    const LocalEarth earth = local_earth(b.latitude, b.height);
    const Eigen::Vector3d way((a.longitude - b.longitude) * earth.transverse_radius * earth.cos_latitude,
                              (a.latitude - b.latitude) * earth.meridian_radius, a.height - b.height);
    worst.way = std::max(worst.way, way.norm());
    worst.velocity = std::max(worst.velocity, (a.velocity - b.velocity).norm());
    worst.attitude = std::max(worst.attitude, a.q_nb.angularDistance(b.q_nb));
  }
  EXPECT_EQ(row, truth.size());
  return worst;
}

TEST(TrajectoryCommand, EveryKindOfSegmentComesBackToItsTruth) {
  const TemporaryFolder folder;
  folder.write("m.toml", mission(every_kind, "truth_rate_hz = 10\n"));
  const CommandResult result = run_imulab(folder, "trajectory m.toml -o out");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  EXPECT_THAT(result.output, HasSubstr("session.toml"));
  EXPECT_THAT(result.output, HasSubstr("at most 60 m/s"));
  const Worst worst = integrated(folder / "out");
  // The integration's own error (0.25 mm here, most of it the sway's coning): docs/theory/strapdown.md.
  EXPECT_LT(worst.way, 1e-3);
  EXPECT_LT(worst.velocity, 1e-5);
  EXPECT_LT(worst.attitude, 1e-8);
}

TEST(TrajectoryCommand, ARecordedTrackComesBackToo) {
  const TemporaryFolder folder;
  folder.write("m.toml", mission(every_kind, "rate_hz = 10\n"));
  folder.write("t.toml",
               "format = \"imulab.mission/1\"\n[imu]\nname = \"flown again\"\n[track]\nfile = \"out/truth.csv\"\n"
               "position_sigma_m = 1e-4\nattitude_sigma_arcsec = 1\n");
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml -o out").exit_code, 0);
  const CommandResult result = run_imulab(folder, "trajectory t.toml -o again");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(read_session(folder / "again").imu.name, "flown again");
  EXPECT_LT(integrated(folder / "again").way, 1e-3);  // a motion like any other
}

TEST(TrajectoryCommand, AVehiclesDriveIsShortToWrite) {
  const TemporaryFolder folder;
  folder.write("m.toml", mission(segment("kind = \"rest\"\nduration_s = 60") + segment("kind = \"accelerate\"\nto_mps = 16.7\nduration_s = 10") +
                                     segment("kind = \"straight\"\nduration_s = 50") + segment("kind = \"turn\"\nangle_deg = 90\nradius_m = 80") +
                                     segment("kind = \"repeat\"\nlast = 2\ntimes = 10") + segment("kind = \"brake\"\nduration_s = 8"),
                                 "carrier = \"vehicle\"\nrate_hz = 20\n"));
  const CommandResult result = run_imulab(folder, "trajectory m.toml -o out");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("largest bank   0 deg"));
  const Solution truth = read_solution(folder / "out/truth.csv");
  // A turn by 90 deg at v/r takes (pi/2) r / v and 3 s more to steer in and out.
  EXPECT_NEAR(truth.time.back(), 60 + 10 + 10 * (50 + 1.5707963 * 80 / 16.7 + 3) + 8, 0.05);
  EXPECT_NEAR(euler_angles(truth.states.back().q_nb.toRotationMatrix()).heading, std::remainder(10 * 1.5707963267948966, 6.283185307179586), 1e-6);
  EXPECT_LT(truth.states.back().velocity.norm(), 0.3);  // within the last sample of standstill
}

const std::string launch_start = start + "heading_deg = 30\nclimb_deg = 45\n";
const std::string launch = segment("kind = \"accelerate\"\nto_mps = 1000\nduration_s = 5") +
                           segment("kind = \"rotate\"\nat_s = 0.5\naxis = \"y\"\nangle_deg = 1200\nrate_dps = 400") +
                           segment("kind = \"turn\"\nat_s = 2.5\nangle_deg = 20\nrate_dps = 8\nroll_s = 1") +
                           segment("kind = \"pitch\"\nat_s = 3\nangle_deg = -10\nrate_dps = 5\npitch_s = 0.5") +
                           segment("kind = \"brake\"\nat_s = 5\nto_mps = 900\nduration_s = 10") + segment("kind = \"straight\"\nduration_s = 5");

TEST(TrajectoryCommand, ALaunchComesBackToItsTruth) {
  const TemporaryFolder folder;
  folder.write("m.toml", mission(launch, "carrier = \"vehicle\"\nlateral_limit_mps2 = 200\nrate_hz = 200\ntruth_rate_hz = 10\n", launch_start));
  const CommandResult result = run_imulab(folder, "trajectory m.toml -o out");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("4000 samples, 20 s at 200 Hz"));  // the brake ends last: 5 + 10 + 5 s
  const Worst worst = integrated(folder / "out");
  EXPECT_LT(worst.way, 0.01);  // the integration's own error at 400 deg/s and 270 m/s^2
  const NavigationState end = read_solution(folder / "out/truth.csv").states.back();
  EXPECT_NEAR(end.velocity.norm(), 900, 1e-6);  // the file's digits
  EXPECT_NEAR(std::asin(end.velocity.z() / 900), 35 * 3.14159265358979 / 180, 1e-9);
}

TEST(TrajectoryCommand, AUnitGetsWarmOnItsWay) {
  const TemporaryFolder folder;
  const std::string warm = "[[temperature]]\ntime_s = 0\ndegC = 20\n[[temperature]]\ntime_s = 20\ndegC = 60\n";
  const std::string readings = "[gyro_temperature]\nunit = \"raw\"\nat_25_degC = 5000\nper_K = -2\nnoise = 0.1\n";
  Calibration unit;
  unit.model.accel.thermal.col(1).setConstant(0.01);
  unit.model.accel.temperature = ThermalReading{"degC", 25, {0, 70}};
  unit.model.gyro.thermal.col(1).setConstant(1e-5);
  unit.model.gyro.temperature = ThermalReading{"raw", 5000, {4900, 5100}};
  unit.covariance.resize(0, 0);
  folder.write("unit.json", calibration_text(unit));
  const std::string head = "carrier = \"vehicle\"\nlateral_limit_mps2 = 200\nrate_hz = 200\n";
  folder.write("m.toml", mission(launch, head, launch_start) + warm + readings);
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml --unit unit.json -o out").exit_code, 0);
  const Session session = read_session(folder / "out");
  const Recording r = read_recording(session, session.recordings.at(0)).recording;
  EXPECT_EQ(session.recordings[0].accel_temperature.value().columns.size(), 1u);  // one column for three equal ones
  EXPECT_EQ(session.recordings[0].gyro_temperature.value().columns.size(), 3u);
  EXPECT_NEAR(r.accel_temperature[0].back(), 60, 0.01);
  EXPECT_NEAR(r.gyro_temperature[0].back(), 5000 - 2 * 35, 0.6);  // six sigmas of the noise
  EXPECT_THAT(run_imulab(folder, "navigate unit.json out").output, HasSubstr("errors at 20.000 s"));
  folder.write("cold.toml", mission(launch, head, launch_start));
  EXPECT_THAT(run_imulab(folder, "trajectory cold.toml --unit unit.json -o cold").errors,
              HasSubstr("the IMU's gyros have thermal terms; expected a temperature profile"));
}

TEST(TrajectoryCommand, AnIdealDriveCanBeAlignedOnItsRest) {
  const TemporaryFolder folder;
  folder.write("m.toml", mission(segment("kind = \"rest\"\nduration_s = 180") + segment("kind = \"accelerate\"\nto_mps = 16.6667\nduration_s = 10") +
                                     segment("kind = \"straight\"\nduration_s = 300") + segment("kind = \"turn\"\nangle_deg = 90\nrate_dps = 10") +
                                     segment("kind = \"repeat\"\nlast = 2\ntimes = 3") + segment("kind = \"brake\"\nduration_s = 10"),
                                 "carrier = \"vehicle\"\nrate_hz = 20\n"));
  ASSERT_EQ(run_imulab(folder, "trajectory m.toml -o out").exit_code, 0);
  const CommandResult result = run_imulab(folder, "navigate none out --align --json");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto j = nlohmann::json::parse(result.output);
  EXPECT_NEAR(j["alignment"]["begin_s"].get<double>(), 0.5, 0.1);  // half a second inside its ends
  EXPECT_NEAR(j["alignment"]["end_s"].get<double>(), 179.5, 0.3);
  // Alignment takes the vertical for the ellipsoid's normal at the rest: 3.6e-6 m/s^2 of gravity at 450 m, 0.08 arcsec.
  for (const auto& angle : j["alignment"]["roll_pitch_heading_deg"]) EXPECT_NEAR(angle.get<double>(), 0, 5e-5);
}

TEST(TrajectoryCommand, IsListed) {
  const TemporaryFolder folder;
  EXPECT_THAT(run_imulab(folder, "--help").output, HasSubstr("trajectory"));
}

struct MissionCase {
  std::string text, message;
};

void expect_mission_refused(const TemporaryFolder& folder, const MissionCase& c) {
  SCOPED_TRACE(c.text);
  folder.write("m.toml", c.text);
  const CommandResult result = run_imulab(folder, "trajectory m.toml -o out");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.output, "");
  EXPECT_THAT(result.errors, HasSubstr("imulab: " + c.message));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) EXPECT_FALSE(entry.path().filename().string().starts_with("out"));
}

TEST(TrajectoryBadInput, SegmentsAreRefusedWithTheirLine) {
  const std::string fast = start + "speed_mps = 80\n";
  const auto at_80 = [&](const std::string& keys, const std::string& head = "") { return mission(segment(keys), head, fast); };
  const TemporaryFolder folder;
  for (const MissionCase& c : std::vector<MissionCase>{
           {mission(segment("kind = \"loop\"\nduration_s = 5")), "m.toml:7: segment.kind: \"loop\" is not allowed; expected one of rest, straight"},
           {mission(segment("kind = \"rest\"")), "m.toml:6: segment.duration_s: is missing"},
           {mission(segment("kind = \"rest\"\nduration = 5")), "m.toml:8: segment.duration: is not a known key; did you mean duration_s?"},
           {mission(segment("duration_s = 5")), "m.toml:6: segment.kind: is missing"},
           {mission(segment("kind = \"rest\"\nduration_s = -5")), "m.toml:8: segment.duration_s: -5 is out of range; expected more than 0"},
           {mission(segment("kind = \"rest\"\nduration_s = 1e-20")), "m.toml:7: segment.kind: lasts 1e-20 s, expected a microsecond at least"},
           {mission(segment("kind = \"rest\"\nduration_s = nan")), "m.toml:8: segment.duration_s: is not finite"},
           {mission(segment("kind = \"rest\"\nduration_s = \"5\"")), "m.toml:8: segment.duration_s: is text; expected a number"},
           {mission(segment("kind = \"rest\"\nduration_s = 5\nsway_m = 1")), "m.toml:6: segment.sway_hz: is missing; expected sway_m and sway_hz"},
           {at_80("kind = \"rest\"\nduration_s = 5"), "m.toml:8: segment.kind: rest at 80.000 m/s: expected standstill"},
           {at_80("kind = \"turn\"\nangle_deg = 90\nrate_dps = 13"),
            "m.toml:8: segment.kind: turn of 13.000 deg/s at 80.00 m/s: needs a bank of 61.6 deg, expected at most 60 deg; the tightest turn at this "
            "speed is 12.165 deg/s, a radius of 376.8 m"},
           {at_80("kind = \"turn\"\nangle_deg = 90\nradius_m = 376"), "m.toml:8: segment.kind: turn of 12.191 deg/s at 80.00 m/s: needs a bank"},
           {at_80("kind = \"s_turn\"\nangle_deg = 90\nrate_dps = 5", "bank_limit_deg = 30\n"), "m.toml:9: segment.kind: turn of 5.000 deg/s"},
           {at_80("kind = \"turn\"\nangle_deg = 90\nradius_m = 1000", "carrier = \"vehicle\"\n"),
            "m.toml:9: segment.kind: turn of 4.584 deg/s at 80"},
           {at_80("kind = \"turn\"\nangle_deg = 5\nrate_dps = 2"), "m.toml:8: segment.kind: turn by 5.000 deg at 2.000 deg/s: expected at least 3"},
           {at_80("kind = \"turn\"\nangle_deg = 90"), "m.toml:7: segment.rate_dps: is missing; expected rate_dps or radius_m"},
           {at_80("kind = \"turn\"\nrate_dps = 3"), "m.toml:7: segment.angle_deg: is missing"},
           {at_80("kind = \"turn\"\nangle_deg = 90\nrate_dps = 3\nradius_m = 900"), "m.toml:11: segment.radius_m: cannot be combined with rate_dps"},
           {at_80("kind = \"turn\"\nangle_deg = 0\nrate_dps = 3"), "m.toml:9: segment.angle_deg: is 0; expected a turn"},
           {at_80("kind = \"accelerate\"\nto_mps = 70\nduration_s = 5"), "m.toml:8: segment.kind: accelerate from 80 to 70 m/s"},
           {at_80("kind = \"brake\"\nto_mps = 90\nduration_s = 5"), "m.toml:8: segment.kind: brake from 80 to 90 m/s"},
           {at_80("kind = \"climb\"\nangle_deg = 95\nduration_s = 5"),
            "m.toml:9: segment.angle_deg: 95 is out of range; expected more than 0, at most 80"},
           {at_80("kind = \"rotate\"\naxis = \"w\"\nangle_deg = 5\nrate_dps = 5"), "m.toml:9: segment.axis: \"w\" is not allowed"},
           {at_80("kind = \"repeat\"\nlast = 1\ntimes = 2"), "m.toml:9: segment.last: 1 segments, but there are 0 before this one"},
           {mission(segment("kind = \"turn\"\nangle_deg = 90\nradius_m = 50")), "m.toml:7: segment.kind: turn of radius 50 m at no speed"},
           {mission(segment("kind = \"climb\"\nangle_deg = 5\nduration_s = 5")), "m.toml:7: segment.kind: climb at no speed"},
           {at_80("kind = \"straight\"\nduration_s = 5\nat_s = 1"), "m.toml:8: segment.kind: at_s: no previous segment; expected one"},
           {at_80("kind = \"straight\"\nduration_s = 5") + segment("kind = \"rotate\"\naxis = \"y\"\nangle_deg = 5\nrate_dps = 5\nat_s = -1"),
            "m.toml:15: segment.at_s: -1 is out of range"},
           {at_80("kind = \"accelerate\"\nto_mps = 90\nduration_s = 5") + segment("kind = \"brake\"\nat_s = 4\nduration_s = 5"),
            "m.toml:12: segment.kind: at_s: two changes of speed at the same time"},
           {at_80("kind = \"rotate\"\naxis = \"x\"\nangle_deg = 5\nrate_dps = 5") +
                segment("kind = \"rotate\"\nat_s = 0\naxis = \"y\"\nangle_deg = 5\nrate_dps = 5"),
            "m.toml:13: segment.kind: rotations of the IMU at the same time: expected one axis"},
           {mission(segment("kind = \"rest\"\nduration_s = 5") + segment("kind = \"rotate\"\nat_s = 0\naxis = \"y\"\nangle_deg = 5\nrate_dps = 5")),
            "m.toml:10: segment.kind: a rest cannot overlap another segment"},
           {at_80("kind = \"pitch\"\nangle_deg = 5\nrate_dps = 50"),
            "m.toml:8: segment.kind: pitch by 5.000 deg at 50.000 deg/s: expected at least 1"},
           {mission(segment("kind = \"straight\"\nduration_s = 5")), "m.toml:7: segment.kind: straight at speed 0"},
           {mission(segment("kind = \"accelerate\"\nto_mps = 9\nduration_s = 5") + segment("kind = \"repeat\"\nlast = 1\ntimes = 2")),
            "m.toml:12: segment.last: the last 1 segments change the speed by 9 m/s"},
           {mission(segment("kind = \"rest\"\nduration_s = 1") + segment("kind = \"repeat\"\nlast = 1\ntimes = 2.5")),
            "m.toml:12: segment.times: 2.5 is not a whole number; expected one"},
           {mission(segment("kind = \"rest\"\nduration_s = 1") + segment("kind = \"repeat\"\nlast = 1\ntimes = 100000") +
                    segment("kind = \"repeat\"\nlast = 100000\ntimes = 2")),
            "m.toml:16: segment.times: makes more than 100000 segments"},
       })
    expect_mission_refused(folder, c);
}

TEST(TrajectoryBadInput, AMissionIsRefusedWithItsLine) {
  const std::string rest = segment("kind = \"rest\"\nduration_s = 5"), format = "format = \"imulab.mission/1\"\n";
  const auto lasting = [](const std::string& s, const std::string& head = "") {
    return mission(segment("kind = \"rest\"\nduration_s = " + s), head);
  };
  const TemporaryFolder folder;
  for (const MissionCase& c : std::vector<MissionCase>{
           {"format = \"imulab.mission/2\"\n" + start + rest, "m.toml:1: format: \"imulab.mission/2\" is a format this version does not know"},
           {"format = \"imulab.session/1\"\n" + start + rest, "m.toml:1: format: \"imulab.session/1\" is not a mission"},
           {start + rest, "m.toml:1: format: is missing"},
           {format + rest, "m.toml:1: start: is missing"},
           {mission(""), "m.toml:1: segment: is missing; expected [[segment]] tables, or a [track]"},
           {mission("", "segment = []\n"), "m.toml:2: segment: is empty"},
           {mission(rest, "", "[start]\nlatitude_deg = 90\nlongitude_deg = 0\nheight_m = 0\n"), "m.toml:3: start.latitude_deg: is at or near a pole"},
           {mission(rest, "", "[start]\nlatitude_deg = 91\nlongitude_deg = 0\nheight_m = 0\n"), "m.toml:3: start.latitude_deg: 91 is out of range"},
           {mission(rest, "", "[start]\nlongitude_deg = 0\nheight_m = 0\n"), "m.toml:2: start.latitude_deg: is missing"},
           {mission(segment("kind = \"straight\"\nduration_s = 900"), "rate_hz = 1\n",
                    "[start]\nlatitude_deg = 89.8\nlongitude_deg = 0\nheight_m = 0\nspeed_mps = 200\n"),
            "m.toml: segment 1: latitude 89.9"},
           {mission(rest, "rate_hz = -100\n"), "m.toml:2: rate_hz: -100 is out of range"},
           {mission(rest, "rate_hz = 0.1\n"), "m.toml: 5 s at 0.1 Hz: expected one sample at least"},
           {mission(rest, "truth_rate_hz = 30\n"), "m.toml:2: truth_rate_hz: does not divide rate_hz"},
           {mission(rest, "truth_rate_hz = 200\n"), "m.toml:2: truth_rate_hz: does not divide rate_hz"},
           {mission(rest, "carrier = \"ship\"\n"), "m.toml:2: carrier: \"ship\" is not allowed; expected one of aircraft, vehicle"},
           {mission(rest + "[wind]\nspeed = 4\n"), "m.toml:9: wind: is not a known key"},
           {lasting("31536000"), "m.toml: 3.1536e+07 s at 100 Hz are 3153600000 samples, files of 851.5 GB: expected at most 10000000 samples"},
           {lasting("1e300"), "m.toml:8: segment.duration_s: 1e+300 is out of range; expected 1e-30 to 1e+30"},
           {mission(rest, "rate_hz = 1e-300\n"), "m.toml:2: rate_hz: 1e-300 is out of range; expected 0.001 to 1000000"},
           {lasting("2e6", "rate_hz = 1\n"), "m.toml: 2e+06 s: expected at most 1e+06 s"},
           {mission(rest, "", start + "climb_deg = 90\n"), "m.toml:6: start.climb_deg: 90 is out of range"},
           {mission(rest + "[gyro_temperature]\nnoise = 1\n"), "m.toml:9: gyro_temperature: is given without [[temperature]]"},
           // Keys after a missing one are not read as if it were there.
           {format + rest + "[gyro_temperature]\nunit = \"degC\"\n", "m.toml:1: start: is missing"},
           {start + rest + "[gyro_temperature]\nunit = \"degC\"\n", "m.toml:1: format: is missing"},
           {"fromat = \"imulab.mission/1\"\n" + start + rest + "[gyro_temperature]\nunit = \"degC\"\n",
            "m.toml:1: fromat: is not a known key; did you mean format?"},
           {mission(rest + "[[temperature]]\ntime_s = 5\ndegC = 1\n[[temperature]]\ntime_s = 5\ndegC = 2\n"),
            "m.toml:13: temperature.time_s: is not after the previous point"},
           {mission(rest + "[[temperature]]\ntime_s = 5\n"), "m.toml:9: temperature.degC: is missing"},
           {mission(rest + "[[temperature]]\ntime_s = 5\ndegC = 2\n[accel_temperature]\nunit = \"raw\"\n"),
            "m.toml:12: accel_temperature.per_K: is missing"},
           {"format = ", "m.toml:1: "},
       })
    expect_mission_refused(folder, c);
}

TEST(TrajectoryBadInput, ATrackIsRefusedWithItsLine) {
  const std::string header = "t,latitude_deg,longitude_deg,height_m,ve,vn,vu,roll_deg,pitch_deg,heading_deg\n";
  const auto row = [](double t, double latitude, const std::string& roll = "0") {
    return std::to_string(t) + "," + std::to_string(latitude) + ",8,400,0,0,0," + roll + ",0,0\n";
  };
  const auto file = [](const std::string& more = "") { return "format = \"imulab.mission/1\"\n[track]\nfile = \"track.csv\"\n" + more; };
  const std::string good = header + row(0, 47) + row(1, 47.001) + row(2, 47.002) + row(3, 47.003);
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& track, const std::string& text, const std::string& message) {
    folder.write("track.csv", track);
    expect_mission_refused(folder, {text, message});
  };
  expect(good, file("position_sigma_m = -1\n"), "m.toml:4: track.position_sigma_m: -1 is out of range");
  expect(good, file() + start, "m.toml:4: start: cannot be combined with [track]");
  expect(good, file() + start + segment("kind = \"rest\"\nduration_s = 5"),
         "m.toml:2: track: cannot be combined with [[segment]]; expected one of them");
  expect(good, "format = \"imulab.mission/1\"\n[track]\nfile = \"no.csv\"\n", "no.csv: cannot be opened");
  expect(header + row(0, 47) + row(1, 47.001), file(), "m.toml: track: 2 rows, expected at least 4");
  expect(header, file(), "track.csv: has a header but no rows");
  expect(good + row(4, 47.004, "nan"), file(), "track.csv:6: roll_deg: nan is not a reading; expected a finite number");
  expect(good + row(3, 47.004), file(), "track.csv:6: t: 3 s is on two rows");
  expect(good + row(2, 47.004), file(), "track.csv:6: t: time runs backwards");
  expect(good + row(4, 89.95), file(), "m.toml: track at 4.000 s: latitude 89.95");
  expect(good + row(4, 47.004, "120"), file(), "m.toml: track at 4.000 s: the attitude is 120 deg from the row before");
  expect(good + row(1e9, 47.004), file(), "m.toml: 1e+09 s at 100 Hz are ");
}

TEST(TrajectoryBadInput, AFolderThatHoldsSomethingIsLeftAlone) {
  const TemporaryFolder folder;
  folder.write("m.toml", mission(segment("kind = \"rest\"\nduration_s = 1")));
  std::filesystem::create_directory(folder / "out");
  folder.write("out/mine.txt", "x");
  const CommandResult result = run_imulab(folder, "trajectory m.toml -o out");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.errors, HasSubstr("imulab: -o out: exists; expected a new or an empty folder"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/mine.txt"));
}

}  // namespace
}  // namespace imulab
