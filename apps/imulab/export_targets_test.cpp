// `imulab export` to every target: what it writes, says and refuses.
#include "imulab/core/random.hpp"
#include "imulab/exchange.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/results/noise.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include "tests/run_command.hpp"
#include <cmath>
#include <filesystem>

namespace imulab {
namespace {

/// A calibration in SI and the noise of a simulated log at rest, as files.
void write_unit(const TemporaryFolder& folder) {
  folder.write("calibration.json", calibration_text(export_test::thermal_unit()));
  NoiseAnalysis analysis;
  analysis.recording = "rest.csv";
  analysis.interval_s = 0.01;
  for (const char* name : {"gyro.x", "gyro.y", "gyro.z", "accel.x", "accel.y", "accel.z"}) {
    std::vector<double> readings(4096);
    RandomStream(1, name).normals(0, readings);
    NoiseAxis axis;
    axis.name = name;
    axis.unit = name[0] == 'g' ? "rad/s" : "m/s^2";
    axis.fit = fit_noise(readings, 0.01, {.bound = BoundOptions{.horizon_s = 10}});
    analysis.axes.push_back(axis);
  }
  folder.write("noise.json", noise_json(analysis));
}

TEST(ExportCommand, WritesEveryTargetThatItCan) {
  const TemporaryFolder folder;
  write_unit(folder);
  const CommandResult result = run_imulab(folder, "export calibration.json --to all -o out");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  for (const ExportTarget& target : export_targets()) {
    const bool needs_noise = result.errors.find(fmt::format("{} is not written: ", target.name)) != std::string::npos;
    EXPECT_EQ(std::filesystem::exists(folder / "out" / std::string(target.file)), !needs_noise) << target.name;
  }
  EXPECT_THAT(result.errors, testing::HasSubstr("kalibr is not written: needs the noise of the IMU; expected --noise noise.json"));
  EXPECT_THAT(result.output, testing::HasSubstr("out/px4.params\n"));
  EXPECT_EQ(run_imulab(folder, "export calibration.json --to all").exit_code, 2);
  EXPECT_EQ(run_imulab(folder, "export calibration.json --to all -o calibration.json").exit_code, 2);
  const CommandResult json = run_imulab(folder, "export calibration.json --to all -o out --json --force");
  EXPECT_THAT(json.output, testing::HasSubstr("\"target\": \"vectornav\""));
  const CommandResult all = run_imulab(folder, "export calibration.json --noise noise.json --to all -o out --force");
  EXPECT_EQ(all.exit_code, 0) << all.errors;
  for (const ExportTarget& target : export_targets()) EXPECT_TRUE(std::filesystem::exists(folder / "out" / std::string(target.file))) << target.name;
}

TEST(ExportCommand, WritesBothModelsOfOpenVinsAndKeepsFilesThatExist) {
  const TemporaryFolder folder;
  write_unit(folder);
  ASSERT_EQ(run_imulab(folder, "export calibration.json --noise noise.json --to all -o out").exit_code, 0);
  EXPECT_THAT(read_text(folder / "out/kalibr_imu_chain.yaml"), testing::HasSubstr("model: \"kalibr\""));
  EXPECT_THAT(read_text(folder / "out/kalibr_imu_chain_rpng.yaml"), testing::HasSubstr("model: \"rpng\""));
  const CommandResult again = run_imulab(folder, "export calibration.json --noise noise.json --to all -o out");
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.errors, testing::HasSubstr("exists; expected a new file, or --force to replace it"));
  EXPECT_EQ(run_imulab(folder, "export calibration.json --noise noise.json --to all --model rpng -o rpng").exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "rpng/kalibr_imu_chain_rpng.yaml"));
}

TEST(ExportCommand, WritesANoiseLogAloneForTargetsOfNoise) {
  const TemporaryFolder folder;
  write_unit(folder);
  const CommandResult imu = run_imulab(folder, "export none --noise noise.json --to kalibr-imu");
  EXPECT_EQ(imu.exit_code, 0) << imu.errors;
  EXPECT_THAT(imu.output, testing::HasSubstr("\ngyroscope_noise_density: "));
  EXPECT_THAT(imu.errors, testing::Not(testing::HasSubstr("whole calibration")));
  for (const char* words : {"--to kalibr-imu", "--noise noise.json --to csv", "--noise noise.json --to all -o out"})
    EXPECT_THAT(run_imulab(folder, std::string("export none ") + words).errors, testing::HasSubstr("there are only targets of noise"));
}

TEST(ExportCommand, FailsWhereATargetOfAllCouldNotBeWritten) {
  const TemporaryFolder folder;
  Calibration c = export_test::si_unit();
  c.model.gyro.raw_unit = "count";
  folder.write("counts.json", calibration_text(c));
  const CommandResult result = run_imulab(folder, "export counts.json --to all -o out --allow-undetermined");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors,
              testing::HasSubstr("counts.json: 6 of 9 targets could not be written: dlio, fusion, realsense, px4, ardupilot, vectornav"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/calibration.csv"));
}

TEST(ExportCommand, TheHeaderNamesTheFileThatWasRead) {
  const TemporaryFolder folder;
  Calibration c = export_test::si_unit();
  c.quality.unobservable = {"gyro.g_sensitivity.xx"};
  c.model.lever_arm << 0.01, 0, 0, 0, 0.03, 0, 0, 0, 0.02;
  folder.write("calibration.json", calibration_text(c) + "\n\n");  // not as imulab writes it
  const CommandResult header = run_imulab(folder, "export calibration.json --to c-header");
  ASSERT_EQ(header.exit_code, 0) << header.errors;
  EXPECT_THAT(header.output, testing::HasSubstr("from the calibration file with SHA-256 " + sha256(read_text(folder / "calibration.json")) + "."));
  for (const char* text : {" * NOT DETERMINED by the data, a starting value that compensates nothing: gyro.g_sensitivity.xx\n",
                           " * rate  = offset + matrix V + quadratic V^2 + cubic V^3 + g_sensitivity force\n", " * Not held: lever arms: "})
    EXPECT_THAT(header.output, testing::HasSubstr(text));
  EXPECT_THAT(export_test::exported("c-header", {c}), testing::HasSubstr("from the calibration that imulab writes with SHA-256 "));
}

TEST(ExportCommand, SaysWhatIsLostAndWarnsOfRanges) {
  const TemporaryFolder folder;
  Calibration c = export_test::si_unit();
  c.model.accel.matrix(0, 0) = 1.3;
  folder.write("calibration.json", calibration_text(c));
  const CommandResult result = run_imulab(folder, "export calibration.json --to ardupilot -o a.param --json");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.errors,
              testing::HasSubstr("imulab: warning: calibration.json: INS_ACCSCAL_X is 1.3: outside 0.8 to 1.2, which ArduPilot accepts"));
  EXPECT_THAT(result.errors, testing::HasSubstr("imulab: warning: calibration.json: not held by ardupilot: gyros' g-sensitivity: up to "));
  EXPECT_THAT(result.output, testing::HasSubstr("accelerometers' off-diagonal terms: up to "));
}

TEST(ExportCommand, RefusesOptionsThatATargetHasNot) {
  const TemporaryFolder folder;
  write_unit(folder);
  EXPECT_THAT(run_imulab(folder, "export calibration.json --to px4 --noise noise.json").errors,
              testing::HasSubstr("--noise: px4 has none; expected one of the targets kalibr-imu, kalibr, "));
  for (const char* options :
       {"--to px4 --model rpng", "--to kalibr --variance-matched", "--to vectornav --instance 1", "--to ardupilot --stream-rate 100"})
    EXPECT_EQ(run_imulab(folder, std::string("export calibration.json ") + options).exit_code, 2) << options;
  EXPECT_EQ(run_imulab(folder, "export calibration.json --to ardupilot --instance 2").exit_code, 0);
}

TEST(ExportCommand, KeepsItsInputs) {
  const TemporaryFolder folder;
  write_unit(folder);
  EXPECT_EQ(run_imulab(folder, "export calibration.json --to px4 -o calibration.json").exit_code, 2);
  EXPECT_EQ(run_imulab(folder, "export calibration.json --to px4 --noise noise.json -o noise.json").exit_code, 2);
  EXPECT_EQ(run_imulab(folder, "export calibration.json --to csv --noise noise.json -o noise.json").exit_code, 2);
  EXPECT_EQ(run_imulab(folder, "export calibration.json --to csv --noise noise.json -o table.csv").exit_code, 0);
  const CommandResult counts = [&] {
    Calibration c = export_test::si_unit();
    c.model.gyro.raw_unit = "count";
    folder.write("counts.json", calibration_text(c));
    return run_imulab(folder, "export counts.json --to px4 -o px4.params --allow-undetermined");
  }();
  EXPECT_EQ(counts.exit_code, 2);
  EXPECT_THAT(counts.errors, testing::HasSubstr("counts.json: the gyros' readings are in counts; expected rad/s"));
  EXPECT_FALSE(std::filesystem::exists(folder / "px4.params"));
}

TEST(ExportCommand, RefusesACalibrationThatTheDataDidNotDetermine) {
  const TemporaryFolder folder;
  Calibration c = export_test::si_unit();
  c.quality.unobservable = {"accel.offset.x"};
  folder.write("calibration.json", calibration_text(c));
  EXPECT_EQ(run_imulab(folder, "export calibration.json --to px4").exit_code, 1);
  EXPECT_EQ(run_imulab(folder, "export calibration.json --to px4 --allow-undetermined").exit_code, 0);
}

void write_targets(const TemporaryFolder& folder) {
  const Calibration c = export_test::si_unit();
  const ImuNoise noise = export_test::some_noise();
  for (const char* target : {"kalibr-imu", "kalibr", "openvins", "vins", "euroc", "ros", "ros-filter", "orb-slam3", "lio-sam", "fast-lio", "dlio"})
    folder.write(std::string(target) + ".yaml", export_test::exported(target, {c, &noise}));
}

/// Kalibr's parser.
TEST(ExportCommand, PyYamlReadsTheFiles) {
  const TemporaryFolder folder;
  write_targets(folder);
  folder.write("check.py", R"(
import yaml
def numbers(x):
    if isinstance(x, dict): return sum((numbers(v) for k, v in x.items() if k not in ("rostopic", "model", "sensor_type", "comment")), [])
    if isinstance(x, list): return sum((numbers(v) for v in x), [])
    assert isinstance(x, (int, float)), x
    return [x]
for name in ("kalibr-imu", "kalibr", "euroc", "ros"):
    assert len(numbers(yaml.safe_load(open(name + ".yaml")))) >= 5, name
for name, count in (("lio-sam", 4), ("fast-lio", 4), ("dlio", 18)):
    assert len(numbers(yaml.safe_load(open(name + ".yaml")))) == count, name
assert all(isinstance(x, (bool, float)) for x in yaml.safe_load(open("ros-filter.yaml"))["/**"]["ros__parameters"].values())
)");
  const CommandResult result = run_shell(folder, "/usr/bin/python3 check.py");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
}

/// A parser of XML for Gazebo's, and compilers for GTSAM's and Fusion's, which get declarations in place of these libraries.
TEST(ExportCommand, XmlParserAndCompilersTakeTheFiles) {
  const TemporaryFolder folder;
  const Calibration c = export_test::si_unit();
  const ImuNoise noise = export_test::some_noise();
  folder.write("imu.sdf", export_test::exported("gazebo", {c, &noise}));
  folder.write("gtsam_imu.hpp", export_test::exported("gtsam", {c, &noise}));
  folder.write("fusion_imu.h", export_test::exported("fusion", {c}));
  std::filesystem::create_directories(folder / "gtsam/navigation");
  folder.write("gtsam/navigation/CombinedImuFactor.h", R"(
namespace gtsam {
struct Matrix3 {};
struct Vector3 { Vector3(double, double, double) {} Matrix3 asDiagonal() const { return {}; } };
struct PreintegrationCombinedParams {
  void setAccelerometerCovariance(const Matrix3&) {} void setGyroscopeCovariance(const Matrix3&) {}
  void setBiasAccCovariance(const Matrix3&) {} void setBiasOmegaCovariance(const Matrix3&) {}
};
})");
  folder.write("Fusion.h", R"(
typedef union { float array[3]; struct { float x, y, z; } axis; } FusionVector;
typedef union { float array[9]; struct { float xx, xy, xz, yx, yy, yz, zx, zy, zz; } element; } FusionMatrix;
)");
  folder.write("a.cpp", "#include \"gtsam_imu.hpp\"\nint main() { gtsam::PreintegrationCombinedParams p; setImuNoise(p); }\n");
  folder.write("a.c",
               "#include \"fusion_imu.h\"\nint main(void) { return gyroscopeMisalignment.element.xx == 0 && accelerometerOffset.axis.x == 0; }\n");
  const CommandResult result =
      run_shell(folder, R"(/usr/bin/python3 -c 'import xml.etree.ElementTree as e; print(len(list(e.parse("imu.sdf").iter("stddev"))))')"
                        " && c++ -std=c++17 -I. -fsyntax-only a.cpp && cc -std=c99 -I. -fsyntax-only a.c");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_EQ(result.output, "6\n");
}

/// The parser of OpenVINS, VINS and ORB-SLAM3, where this machine has it: it needs more than a hundred packages.
TEST(ExportCommand, OpenCvReadsTheFiles) {
  const TemporaryFolder folder;
  if (run_shell(folder, "/usr/bin/python3 -c 'import cv2'").exit_code != 0) GTEST_SKIP() << "without OpenCV";
  write_targets(folder);
  folder.write("check.py", R"(
import cv2
vins = cv2.FileStorage("vins.yaml", cv2.FILE_STORAGE_READ)
print("%.17g" % vins.getNode("acc_n").real())
chain = cv2.FileStorage("openvins.yaml", cv2.FILE_STORAGE_READ)
imu = chain.getNode("imu0")
print("%.17g" % imu.getNode("Tw").at(2).at(1).real(), imu.getNode("model").string())
orb = cv2.FileStorage("orb-slam3.yaml", cv2.FILE_STORAGE_READ)
assert orb.getNode("IMU.NoiseGyro").isReal() and orb.getNode("IMU.Frequency").real() == 200
)");
  const CommandResult result = run_shell(folder, "/usr/bin/python3 check.py");
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_NEAR(std::stod(result.output), 1.5e-3 * std::sqrt(200.0), 1e-17);
  EXPECT_THAT(result.output, testing::HasSubstr(" kalibr\n"));
}

}  // namespace
}  // namespace imulab
