// Names, units and values that a target cannot take are refused or named; every file says at its head what it holds and what not.
#include "imulab/error.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/export_unit.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace imulab::export_test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::ThrowsMessage;

TEST(ExportRefusal, CountsAreNoReadingsForProgramsThatTakeSi) {
  Calibration c = si_unit();
  c.model.accel.raw_unit = "count";
  const ImuNoise noise = some_noise();
  for (const char* target : {"kalibr", "openvins", "px4", "ardupilot", "vectornav"})
    EXPECT_THAT(
        [&] {
          exported(target, {c, &noise});
        },
        ThrowsMessage<Error>(AllOf(HasSubstr("the accelerometers' readings are in counts"), HasSubstr("expected m/s^2"))))
        << target;
  for (const char* target : {"json-matrix", "csv", "c-header", "euroc"}) EXPECT_NO_THROW(exported(target, {c, &noise})) << target;
}

TEST(ExportRefusal, NoiseThatATargetNeedsIsAskedFor) {
  const Calibration c = si_unit();
  for (const char* target : {"kalibr-imu", "kalibr", "openvins", "vins", "euroc", "ros", "ros-filter"})
    EXPECT_THAT([&] { exported(target, {c}); }, ThrowsMessage<Error>(HasSubstr("expected a noise.json"))) << target;
  for (const char* target : {"px4", "ardupilot", "vectornav", "csv", "json-matrix"}) EXPECT_NO_THROW(exported(target, {c})) << target;
  for (const char* target : {"csv", "json-matrix"})
    EXPECT_THAT(export_target(target).left_out({c}), testing::ElementsAre("noise: not known, since no noise.json was given")) << target;
}

TEST(ExportNoise, WithoutALogIsThatOfTheRestsAndSaysSo) {
  Calibration c = si_unit();
  c.rest_noise = RestNoise{{1e-3, 2e-3, 0}, {1e-4, 3e-4, 2e-4}, 0.01, 24, 150};
  for (const char* target : {"kalibr-imu", "kalibr", "openvins", "vins", "euroc", "ros", "ros-filter"}) {
    const std::string text = exported(target, {c});
    EXPECT_THAT(text, HasSubstr("White noise is that of the calibration's 24 rests, 150 s in all")) << target;
    if (std::string_view(target) != "ros") EXPECT_THAT(text, HasSubstr("NOT MEASURED")) << target;  // which has white noise alone
    EXPECT_THAT(export_target(target).warnings({c}), Contains(HasSubstr("not measured"))) << target;
  }
  const std::string kalibr = exported("kalibr-imu", {c});
  EXPECT_THAT(kalibr, HasSubstr("update_rate: 100.0  # Hz"));
  EXPECT_THAT(kalibr, HasSubstr("\naccelerometer_noise_density: 0.002  # m/s^2/sqrt(Hz); x 0.001, y 0.002, z no noise\n"));
  EXPECT_THAT(kalibr, HasSubstr("  # rad/s^2/sqrt(Hz); NOT MEASURED: assumed, 0.1 /s times the white noise; x 1e-05, y 3e-05, z 2e-05\n"));
  EXPECT_THAT(exported("ros-filter", {c}), HasSubstr("B NOT MEASURED and left out"));
  const ImuNoise noise = some_noise();  // a log goes before
  EXPECT_THAT(exported("kalibr-imu", {c, &noise}), Not(HasSubstr("NOT MEASURED")));
  EXPECT_THAT(export_target("kalibr").warnings({c, &noise}), IsEmpty());
  c.rest_noise->gyro.setZero();  // of accelerometers alone
  EXPECT_THAT([&] { exported("kalibr-imu", {c}); }, ThrowsMessage<Error>(HasSubstr("gyros' N has no axis with noise")));
}

TEST(ExportRefusal, NoiseWithoutValueOrBoundIsNamed) {
  const Calibration c = si_unit();
  ImuNoise noise = some_noise();
  noise.accel[2]->N = undetermined(std::numeric_limits<double>::infinity());
  EXPECT_THAT(
      [&] {
        exported("euroc", {c, &noise});
      },
      ThrowsMessage<Error>(HasSubstr("accelerometers' N of axis z has neither a value nor an upper bound")));
  noise.accel[2].reset();  // a constant axis has no noise: the others count
  EXPECT_THAT(exported("euroc", {c, &noise}), HasSubstr("z no noise"));
  noise.accel[0].reset(), noise.accel[1].reset();
  EXPECT_THAT([&] { exported("euroc", {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("no axis with noise")));
  noise = some_noise();
  noise.gyro_unit = "count";
  EXPECT_THAT([&] { exported("euroc", {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("in counts")));
  noise = some_noise();
  noise.interval_s = 0;
  EXPECT_THAT([&] { exported("euroc", {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("expected a rate")));
}

TEST(ExportRefusal, SingularAndLeftHandedMatricesAndNumbersThatAreNotFinite) {
  const ImuNoise noise = some_noise();
  for (const char* target : {"kalibr", "openvins", "px4", "ardupilot", "vectornav", "json-matrix", "csv"}) {
    Calibration c = si_unit();
    c.model.gyro.matrix.row(1).setZero();
    EXPECT_THAT([&] { exported(target, {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("gyro.matrix: is singular"))) << target;
    c = si_unit();
    c.model.accel.offset.x() = std::nan("");
    EXPECT_THAT([&] { exported(target, {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("not finite"))) << target;
  }
  Calibration c = si_unit();
  c.model.gyro.matrix.row(1) *= -1;
  for (const char* target : {"kalibr", "openvins"})
    EXPECT_THAT([&] { exported(target, {c, &noise}); }, ThrowsMessage<Error>(HasSubstr("the gyros' axes form a left-handed triad"))) << target;
}

TEST(ExportRefusal, NumbersThatSinglePrecisionCannotHold) {
  for (const char* target : {"px4", "ardupilot", "vectornav"}) {
    Calibration c = si_unit();
    c.model.accel.offset.y() = 1e300;
    EXPECT_THAT([&] { exported(target, {c}); }, ThrowsMessage<Error>(HasSubstr("too large for single precision"))) << target;
  }
}

TEST(ExportRefusal, ModelsAndInstancesThatAreNone) {
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  ExportInput input{c, &noise};
  input.options.imu_model = "nonsense";
  EXPECT_THAT([&] { exported("openvins", input); }, ThrowsMessage<Error>(HasSubstr("expected kalibr or rpng")));
  input.options.instance = 3;
  EXPECT_NO_THROW(exported("px4", input));
  EXPECT_THAT([&] { exported("ardupilot", input); }, ThrowsMessage<Error>(HasSubstr("expected 0, 1 or 2")));
}

TEST(ExportWarning, TemperaturesThatArduPilotDoesNotAccept) {
  Calibration c = thermal_unit();
  for (TriadModel* m : {&c.model.accel, &c.model.gyro}) m->temperature->range = {-75, 95};
  EXPECT_THAT(export_target("ardupilot").warnings({c}), testing::IsSupersetOf({"INS_TCAL1_TMIN is -75: outside -70 to 80, which ArduPilot accepts",
                                                                               "INS_TCAL1_TMAX is 95: outside -70 to 80, which ArduPilot accepts"}));
}

TEST(ExportWarning, NumbersOutsideATargetsRangeAreNamed) {
  Calibration c = si_unit();
  c.model.accel.matrix = Vector3d(1.25, 1, 3.5).asDiagonal();
  c.model.accel.offset = {0, 4, 0};
  const auto px4 = export_target("px4").warnings({c}), ardupilot = export_target("ardupilot").warnings({c});
  EXPECT_THAT(px4, testing::ElementsAre("CAL_ACC0_ZSCALE is 3.5: outside 0.1 to 3, which PX4 accepts"));
  EXPECT_THAT(ardupilot, testing::UnorderedElementsAre("INS_ACCSCAL_X is 1.25: outside 0.8 to 1.2, which ArduPilot accepts",
                                                       "INS_ACCSCAL_Z is 3.5: outside 0.8 to 1.2, which ArduPilot accepts",
                                                       "INS_ACCOFFS_Y is -4: outside -3.5 to 3.5, which ArduPilot accepts"));
  EXPECT_THAT(export_target("px4").warnings({si_unit()}), IsEmpty());
}

// Noise that was typed by hand is not said to come from a log.
TEST(ExportNoise, OfNoLogNamesNone) {
  ImuNoise typed = some_noise();
  typed.recording.clear();
  const std::string text = export_target("kalibr").text({thermal_unit(), &typed});
  EXPECT_THAT(text, HasSubstr("Noise: as given; no log is named to which it was fitted."));
  EXPECT_THAT(text, testing::Not(HasSubstr("\"\"")));
}

/// The text that a program reads: all but comments.
std::string without_comments(std::string text) {
  if (text.starts_with("<!--")) text.erase(0, text.find("-->"));
  std::istringstream lines(text);
  std::string out;
  for (std::string line; std::getline(lines, line);)
    if (!line.starts_with('#') && !line.starts_with("//") && !(line.starts_with('%') && !line.starts_with("%YAML"))) out += line + "\n";
  return out;
}

TEST(ExportRefusal, NoNameBreaksOutOfAComment) {
  const std::string hostile =
      "a\n--> <x> imu0: {model: x}\r\nb \"*/ # : ' \u2028 \x85 \x1b[31m $VNWRG,25,0\n1\t1\tCAL_ACC0_XOFF\t9\t9\n" + std::string(100000, 'x');
  const ImuNoise good_noise = some_noise();
  ImuNoise noise = some_noise();
  noise.recording = hostile;
  const Calibration good = thermal_unit();
  Calibration c = thermal_unit();
  c.imu = c.method = c.created = c.software = c.serial = hostile;
  for (const ExportTarget& target : export_targets()) {
    if (target.name == "c-header") continue;  // has no lines of this form: apps/imulab/export_test.cpp
    const std::string text = target.text({c, &noise});
    if (target.name == "json-matrix" || target.name == "realsense" || target.name == "filter") {
      EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), [&] {
        const std::string t = target.text({good, &good_noise});
        return std::count(t.begin(), t.end(), '\n');
      }());
      continue;
    }
    EXPECT_EQ(without_comments(text), without_comments(target.text({good, &good_noise}))) << target.name;
    for (const char byte : text) ASSERT_TRUE(byte == '\n' || byte == '\r' || byte == '\t' || (byte >= ' ' && byte <= '~')) << target.name;
    EXPECT_LT(text.size(), 20000u) << target.name;
  }
}

TEST(ExportTargets, EveryFileSaysWhatItHoldsAtItsHead) {
  const ImuNoise noise = some_noise();
  const Calibration c = thermal_unit();
  for (const ExportTarget& target : export_targets()) {
    const std::string text = target.text({c, &noise});
    if (target.name == "c-header") continue;
    for (const std::string& lost : target.left_out({c, &noise})) EXPECT_THAT(text, HasSubstr(lost)) << target.name;
    if (target.name == "json-matrix" || target.name == "realsense" || target.name == "filter") continue;  // with quotation marks as JSON has them
    EXPECT_THAT(text, HasSubstr(" Calibration of \"unit\", method truth, 2026-11-20T12:00:00Z, for ")) << target.name;
  }
}

TEST(ExportTargets, EveryFileListsWhatTheDataDidNotDetermine) {
  const ImuNoise noise = some_noise();
  Calibration c = thermal_unit();
  c.quality.unobservable = {"accel.offset.x", "gyro.g_sensitivity.zz"};
  for (const ExportTarget& target : export_targets()) {
    const std::string text = target.text({c, &noise});
    for (const std::string& name : c.quality.unobservable) EXPECT_THAT(text, HasSubstr(name)) << target.name;
    EXPECT_THAT(text, AnyOf(HasSubstr("NOT DETERMINED by the data"), HasSubstr("\"not_determined\": [\n"))) << target.name;
    EXPECT_THAT(target.text({thermal_unit(), &noise}), Not(HasSubstr("NOT DETERMINED"))) << target.name;
  }
}

TEST(ExportTargets, EveryFileListsTheNoiseThatItLeavesOut) {
  ImuNoise noise = some_noise();
  noise.accel[0]->B = determined(3e-4);
  noise.gyro[2]->R = determined(7e-9);
  noise.gyro[1]->markov = {{determined(5e-6), determined(120)}};
  const Calibration c = thermal_unit();
  for (const char* target : {"kalibr-imu", "kalibr", "openvins", "vins", "euroc", "ros", "ros-filter"}) {
    const auto lost = export_target(target).left_out({c, &noise});
    EXPECT_THAT(lost, Contains("noise: accelerometers' B, bias instability [m/s^2]: x 0.0003, y not determined, z not determined")) << target;
    EXPECT_THAT(lost, Contains("noise: gyros' R, ramp [rad/s^2]: x not determined, y not determined, z 7e-09")) << target;
    EXPECT_THAT(lost, Contains("noise: gyros' Gauss-Markov processes: y 5e-06 rad/s with 120 s")) << target;
    const bool holds_random_walk = !std::string_view(target).starts_with("ros");
    EXPECT_EQ(std::any_of(lost.begin(), lost.end(), [](const std::string& s) { return s.find("' K, random walk") != std::string::npos; }),
              !holds_random_walk)
        << target;
  }
  const std::string table = exported("csv", {c, &noise}), json = exported("json-matrix", {c, &noise});
  for (const char* row : {"\nnoise.accel.x.B,0.0003,", "\nnoise.accel.x.B.lower,0.000294,,m/s^2\n", "\nnoise.gyro.z.R,7.0e-09,",
                          "\nnoise.gyro.y.K.upper,4.0e-06,", "\nnoise.gyro.y.markov1.time,120.0,1.2,s\n"})
    EXPECT_THAT(table, HasSubstr(row));
  const auto gyro_y = nlohmann::json::parse(json)["noise"]["gyros"]["axes"][1];
  EXPECT_EQ(gyro_y["markov"][0]["time_s"]["value"], 120);
  EXPECT_EQ(gyro_y["K"]["determined"], false);
  EXPECT_TRUE(gyro_y["K"]["value"].is_null());
  EXPECT_EQ(gyro_y["K"]["interval"][1], 4e-6);
}

TEST(ExportRefusal, ASpreadsheetRunsNoCommentOfATable) {
  Calibration c = si_unit();
  c.imu = "a, =cmd; @cmd,+cmd";
  const std::string table = exported("csv", {c});
  for (const char* shown : {",' =cmd;", ";' @cmd,", ",'+cmd"}) EXPECT_THAT(table, HasSubstr(shown));
  c.imu = "a\",\"=1+1";  // a cell in quotes
  EXPECT_THAT(exported("csv", {c}), HasSubstr("Calibration of \"a\",'\"=1+1\","));
}

}  // namespace
}  // namespace imulab::export_test
