// Files for programs that take the device's own readings are for its axes, which need not be those of the body.
#include "imulab/export/device_axes.hpp"

#include "imulab/coefficient.hpp"

#include <Eigen/LU>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include <array>
#include <map>
#include <sstream>
#include <yaml-cpp/yaml.h>

namespace imulab::export_test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Columns along other axes than the body's: accelerometers +y, -x, +z; gyros -z, +x, -y.
struct TurnedUnit {
  Calibration c = si_unit(41);
  Matrix3d P_a, P_g;  // of u_body = P u_device, written out
  TurnedUnit() {
    c.recorded_accel = RecordedAs{"m/s^2", 1, 0, {"+y", "-x", "+z"}};
    c.recorded_gyro = RecordedAs{"deg/s", 16, 0, {"-z", "+x", "-y"}};
    P_a << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    P_g << 0, 1, 0, 0, 0, -1, -1, 0, 0;
  }
};

Matrix3d yaml_matrix(const YAML::Node& node) {
  Matrix3d m;
  for (std::size_t i = 0; i < 9; ++i) m(static_cast<int>(i) / 3, static_cast<int>(i) % 3) = node[i / 3][i % 3].as<double>();
  return m;
}

YAML::Node imu_of(std::string text) {
  if (text.starts_with("%YAML:1.0")) text[0] = '#';
  return YAML::Load(text)["imu0"];
}

std::map<std::string, double> values_of(const std::string& text, char separator, std::size_t name, std::size_t value) {
  std::map<std::string, double> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream fields(line);
    std::vector<std::string> words;
    for (std::string word; std::getline(fields, word, separator);) words.push_back(word);
    out[words.at(name)] = std::stod(words.at(value));
  }
  return out;
}

TEST(ExportAxes, VectorNavsRegistersTakeTheDevicesReadings) {
  TurnedUnit u;
  u.c.model.g_sensitivity.setZero();
  std::istringstream lines(exported("vectornav", {u.c}));
  Matrix3d C[2];
  Vector3d B[2];
  int k = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("$VNWRG,")) continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream values(line.substr(10));
    for (int i = 0; i < 9; ++i) values >> C[k](i / 3, i % 3);
    for (int i = 0; i < 3; ++i) values >> B[k][i];
    ++k;
  }
  ASSERT_EQ(k, 2);
  const RandomStream random(2, "axes");
  Worst worst;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const Reading r = random_reading(u.c.model, random, i);
    const Vector3d a = u.P_a.transpose() * r.raw.accel, w = u.P_g.transpose() * r.raw.gyro;  // as the device gives them
    worst.add({.rate = C[1] * (w - B[1]), .force = C[0] * (a - B[0])}, r.compensated);
  }
  EXPECT_LT(worst.force, 2e-7);  // single precision
  EXPECT_LT(worst.rate, 2e-7);
  EXPECT_THAT(exported("vectornav", {u.c}), HasSubstr("accelerometers in m/s^2, the device's x, y, z along +y, -x, +z of the body."));
  EXPECT_THAT(exported("vectornav", {u.c}), HasSubstr("the recording had 16 counts to one deg/s: convert."));
}

TEST(ExportAxes, KalibrAndOpenVinsTakeTheDevicesReadings) {
  const TurnedUnit u;
  const ImuNoise noise = some_noise();
  const Vector3d b_a = u.P_a.transpose() * bias_of(u.c.model.accel), b_g = u.P_g.transpose() * bias_of(u.c.model.gyro);
  const YAML::Node kalibr = imu_of(exported("kalibr", {u.c, &noise})), openvins = imu_of(exported("openvins", {u.c, &noise}));
  const Matrix3d M_a = yaml_matrix(kalibr["accelerometers"]["M"]), M_g = yaml_matrix(kalibr["gyroscopes"]["M"]),
                 A = yaml_matrix(kalibr["gyroscopes"]["A"]), C_i_b = yaml_matrix(kalibr["T_i_b"]),
                 C_gyro_b = yaml_matrix(kalibr["gyroscopes"]["C_gyro_i"]) * C_i_b;
  const Matrix3d Da = yaml_matrix(openvins["Ta"]).inverse(), Dw = yaml_matrix(openvins["Tw"]).inverse(), Tg = yaml_matrix(openvins["Tg"]),
                 R_GYROtoIMU = yaml_matrix(openvins["R_IMUtoGYRO"]).transpose();
  const RandomStream random(3, "axes");
  Worst of_kalibr, of_openvins;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const Reading r = random_reading(u.c.model, random, i);
    const Vector3d a = u.P_a.transpose() * r.raw.accel - b_a, w = u.P_g.transpose() * r.raw.gyro - b_g;
    const Vector3d a_b = (M_a * C_i_b).inverse() * a;
    of_kalibr.add({.rate = (M_g * C_gyro_b).inverse() * (w - A * (C_gyro_b * a_b)), .force = a_b}, r.compensated);
    const Vector3d a_I = Da * a;
    of_openvins.add({.rate = R_GYROtoIMU * Dw * (w - Tg * a_I), .force = a_I},
                    {.rate = C_i_b * r.compensated.rate, .force = C_i_b * r.compensated.force});  // the same IMU frame
  }
  for (const Worst& worst : {of_kalibr, of_openvins}) {
    EXPECT_LT(worst.force, double_rounding);
    EXPECT_LT(worst.rate, double_rounding);
  }
}

TEST(ExportAxes, AutopilotsParametersAreAlongTheDevicesAxes) {
  TurnedUnit u;
  u.c.recorded_gyro->axes = u.c.recorded_accel->axes;
  u.c.model.accel.matrix = Vector3d(0.9, 1.0, 1.1).asDiagonal();
  u.c.model.accel.offset = -u.c.model.accel.matrix * Vector3d(0.1, 0.2, 0.3);  // biases of the readings along x, y, z of the body
  const auto px4 = values_of(exported("px4", {u.c}), '\t', 2, 3), ardupilot = values_of(exported("ardupilot", {u.c}), ',', 0, 1);
  // The device's x is the body's +y, its y the body's -x.
  for (const auto& [axis, scale, offset] : {std::tuple{'X', 1.0, 0.2}, {'Y', 0.9, -0.1}, {'Z', 1.1, 0.3}}) {
    EXPECT_NEAR(px4.at(fmt::format("CAL_ACC0_{}SCALE", axis)), scale, 1e-6) << axis;
    EXPECT_NEAR(px4.at(fmt::format("CAL_ACC0_{}OFF", axis)), offset, 1e-6) << axis;
    EXPECT_NEAR(ardupilot.at(fmt::format("INS_ACCSCAL_{}", axis)), scale, 1e-6) << axis;
    EXPECT_NEAR(ardupilot.at(fmt::format("INS_ACCOFFS_{}", axis)), offset, 1e-6) << axis;
  }
  const Vector3d b = bias_of(u.c.model.gyro);
  EXPECT_NEAR(px4.at("CAL_GYRO0_XOFF"), b.y(), 1e-7);
  EXPECT_NEAR(px4.at("CAL_GYRO0_YOFF"), -b.x(), 1e-7);
  EXPECT_THAT(export_target("px4").warnings({u.c}), IsEmpty());
  u.c.recorded_gyro->axes = RecordedAs{}.axes;
  for (const char* target : {"px4", "ardupilot"})
    EXPECT_THAT(export_target(target).warnings({u.c}), testing::Contains(HasSubstr("recorded along different axes"))) << target;
}

TEST(ExportAxes, TheDriftTurnsWithTheReadings) {
  Calibration c = thermal_unit(42);
  c.model.accel.quadratic = {1e-5, 2e-5, 3e-5};
  c.model.accel.cubic = {1e-6, 2e-6, 3e-6};
  TurnedUnit u;
  const export_io::DeviceAxes axes{u.P_a, u.P_g};
  const SensorModel turned = export_io::along_device_axes(c.model, axes);
  const RandomStream random(4, "axes");
  for (std::uint64_t i = 0; i < 100; ++i) {
    const Reading r = random_reading(c.model, random, i, 7, -9);
    RawSample device = r.raw;
    device.accel = u.P_a.transpose() * r.raw.accel;
    device.gyro = u.P_g.transpose() * r.raw.gyro;
    const Motion m = compensate(turned, device);
    EXPECT_LT((u.P_a * m.force - r.compensated.force).norm(), 1e-12 * 60);  // forces up to some 60 m/s^2
    EXPECT_LT((u.P_g * m.rate - r.compensated.rate).norm(), 1e-12 * 10);
  }
}

TEST(ExportAxes, FilesOfNoiseAloneSayThatTheReadingsMustBeTurned) {
  const TurnedUnit u;
  EXPECT_THAT(export_target("euroc").left_out({u.c}), testing::Contains(HasSubstr("the device's axes, which are not x, y, z of the body")));
  EXPECT_THAT(exported("json-matrix", {u.c}), HasSubstr("\"-x\""));
  EXPECT_THAT(exported("csv", {u.c}), HasSubstr("# gyro: recorded in deg/s, columns along -z +x -y of the body"));
}

}  // namespace
}  // namespace imulab::export_test
