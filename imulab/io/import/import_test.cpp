// Files of other programs become calibrations that do what those programs' equations do; what was exported comes back; damage is named by file and
// line.
#include "imulab/core/error.hpp"
#include "imulab/io/calibration/file.hpp"
#include "imulab/io/import/calibration.hpp"
#include "imulab/model/coefficient.hpp"

#include <Eigen/LU>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include "tests/run_command.hpp"
#include <functional>

namespace imulab::export_test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

Imported import(const std::string& text, const ImportOptions& options = {}) { return import_calibration_text(text, "file", options); }

/// Largest difference of two models over random readings, relative to the motion's size.
double difference(const SensorModel& a, const SensorModel& b, double low = 0, double high = 0) {
  const RandomStream random(31, "import");
  double worst = 0;
  for (std::uint64_t i = 0; i < 10000; ++i) {
    const double tau = low + (high - low) * random.uniform(i);
    Reading r = random_reading(a, random, 1000000 + i, tau, tau);
    const auto shift = [](const TriadModel& x, const TriadModel& y) {
      return x.temperature && y.temperature ? x.temperature->reference - y.temperature->reference : 0;
    };
    r.raw.accel_tau.array() += shift(a.accel, b.accel);
    r.raw.gyro_tau.array() += shift(a.gyro, b.gyro);
    const Motion m = compensate(b, r.raw);
    worst = std::max({worst, (m.force - r.compensated.force).norm() / (1 + r.compensated.force.norm()),
                      (m.rate - r.compensated.rate).norm() / (1 + r.compensated.rate.norm())});
  }
  return worst;
}

constexpr double rounding = 1e-12;  // some tens of operations in double

TEST(Import, WhatWasExportedComesBack) {
  const ImuNoise noise = some_noise();
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    Calibration c = si_unit(seed);
    Calibration without_bias = c;
    without_bias.model.accel.offset.setZero();
    without_bias.model.gyro.offset.setZero();
    const Imported kalibr = import(exported("kalibr", {c, &noise}));
    EXPECT_EQ(kalibr.format, "Kalibr");
    EXPECT_LT(difference(without_bias.model, kalibr.calibration.model), rounding);
    EXPECT_THAT(kalibr.warnings, Contains(HasSubstr("holds no biases")));
    // OpenVINS' file does not tell the body frame: up to its rotation, in the accelerometers' frame
    for (const char* model : {"kalibr", "rpng"}) {
      ExportInput input{c, &noise};
      input.options.imu_model = model;
      const Imported openvins = import(exported("openvins", input));
      EXPECT_EQ(openvins.format, "OpenVINS");
      SensorModel m = openvins.calibration.model;
      const Matrix3d R = c.model.accel.matrix * m.accel.matrix.inverse();
      EXPECT_LT((R * R.transpose() - Matrix3d::Identity()).norm(), rounding);
      m.accel.matrix = R * m.accel.matrix;
      m.gyro.matrix = R * m.gyro.matrix;
      m.g_sensitivity = R * m.g_sensitivity * R.transpose();
      EXPECT_LT(difference(without_bias.model, m), rounding) << model;
    }
    const Imported json = import(exported("json-matrix", {c}));
    EXPECT_EQ(json.format, "json-matrix");
    EXPECT_LT(difference(c.model, json.calibration.model), rounding);
    EXPECT_THAT(json.warnings, IsEmpty());
    c.model.g_sensitivity.setZero();
    const Imported vectornav = import(exported("vectornav", {c}));
    EXPECT_EQ(vectornav.format, "VectorNav");
    EXPECT_LT(difference(c.model, vectornav.calibration.model), 2e-7);  // its numbers are in single precision
  }
}

TEST(Import, EveryTermOfJsonMatricesComesBack) {
  Calibration c = thermal_unit(4, "K", 273.15);
  c.model.accel.raw_unit = c.model.gyro.raw_unit = "count";
  c.model.accel.quadratic = {1e-5, 2e-5, -1e-5};
  c.model.gyro.cubic = {1e-4, 2e-4, -1e-4};
  c.model.lever_arm << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  const Calibration back = import(exported("json-matrix", {c})).calibration;
  EXPECT_LT(difference(c.model, back.model, -20, 40), rounding);
  EXPECT_EQ(back.model.accel.temperature, c.model.accel.temperature);
  EXPECT_EQ(back.model.gyro.raw_unit, "count");
  EXPECT_EQ(back.model.lever_arm, c.model.lever_arm);
}

TEST(Import, AutopilotsParametersComeBack) {
  for (const int instance : {0, 1}) {
    Calibration c = thermal_unit(5);
    c.model.accel.matrix = Vector3d(1.01, 0.98, 1.003).asDiagonal();
    c.model.gyro.matrix.setIdentity();
    c.model.g_sensitivity.setZero();
    ExportInput input{c};
    input.options.instance = instance;
    for (const auto& [target, format] : {std::pair{"px4", "PX4"}, {"ardupilot", "ArduPilot"}}) {
      ImportOptions options;
      options.instance = instance;
      const Imported back = import(exported(target, input), options);
      EXPECT_EQ(back.format, format);
      EXPECT_THAT(back.warnings, IsEmpty());
      EXPECT_LT(difference(c.model, back.calibration.model, -27.5, 37.5), 1e-6) << target;  // parameters in single precision
      EXPECT_EQ(back.calibration.model.accel.temperature->range, c.model.accel.temperature->range) << target;
    }
  }
}

TEST(Import, TermsOfThirdOrderAreLeftOutAndSaid) {
  std::string text = exported("px4", {thermal_unit()});
  const std::string name = "TC_A0_X3_1\t0.0";
  ASSERT_NE(text.find(name), std::string::npos);
  text.replace(text.find(name), name.size(), "TC_A0_X3_1\t1e-6");
  EXPECT_THAT(import(text).warnings,
              testing::ElementsAre("accelerometers: the thermal terms of third order are left out: up to 0.053 m/s^2 over -5 to 60 degC"));
}

TEST(Import, ImuTksFilesAreReadByItsEquation) {
  const std::string accel = "          1  -0.0021 0.0035\n 0 1 -0.0019\n0 0 1\n\n0.0004 0 0\n0 0.00041 0\n0 0 0.00042\n\n33123\n33276.4\n32360.5\n\n";
  const TemporaryFolder folder;
  folder.write("gyro.calib", "1 0.001 0.002\n0.003 1 0.004\n0.005 0.006 1\n0.0002 0 0\n0 0.00021 0\n0 0 0.00022\n32768\n32760\n32750\n");
  ImportOptions options;
  options.gyro_file = folder / "gyro.calib";
  const Imported imported = import(accel, options);
  EXPECT_EQ(imported.format, "imu_tk");
  const SensorModel& m = imported.calibration.model;
  EXPECT_EQ(m.accel.raw_unit, "count");
  // Kyle-ak/imu_tk, include/imu_tk/calibration.h, CalibratedTriad_::unbiasNormalize: X' = T K (X - B)
  Matrix3d T, T_g;
  T << 1, -0.0021, 0.0035, 0, 1, -0.0019, 0, 0, 1;
  T_g << 1, 0.001, 0.002, 0.003, 1, 0.004, 0.005, 0.006, 1;
  const Matrix3d K = Vector3d(0.0004, 0.00041, 0.00042).asDiagonal(), K_g = Vector3d(0.0002, 0.00021, 0.00022).asDiagonal();
  const RawSample raw{{30000, 35000, 31000}, {32000, 33000, 34000}};
  const Motion found = compensate(m, raw);
  EXPECT_LT((found.force - T * K * (raw.accel - Vector3d(33123, 33276.4, 32360.5))).norm(), 1e-12 * 30);  // offsets of 13 m/s^2 cancel
  EXPECT_LT((found.rate - T_g * K_g * (raw.gyro - Vector3d(32768, 32760, 32750))).norm(), 1e-12 * 30);
  // The accelerometers alone
  const Imported alone = import(accel);
  EXPECT_THAT(alone.warnings, Contains(HasSubstr("--gyro names their file")));
  EXPECT_EQ(alone.calibration.model.gyro.matrix, Matrix3d(Matrix3d::Identity()));
}

constexpr const char* imucal_text = R"({"acc_unit": "m/s^2", "gyr_unit": "deg/s", "from_acc_unit": "g", "from_gyr_unit": "deg/s", "comment": null,
 "K_a": [[0.1, 0, 0], [0, 0.102, 0], [0, 0, 0.104]], "R_a": [[1, 0.01, 0], [0, 1, 0.02], [0.03, 0, 1]], "b_a": [0.05, -0.06, 0.04],
 "K_g": [[1.01, 0, 0], [0, 0.99, 0], [0, 0, 1.02]], "R_g": [[1, 0, 0.01], [0.02, 1, 0], [0, 0.03, 1]],
 "K_ga": [[0.01, 0.02, 0.03], [0.04, 0.05, 0.06], [0.07, 0.08, 0.09]], "b_g": [0.5, -0.6, 0.7], "cal_type": "Ferraris", "_format_version": "2.0.0"})";

TEST(Import, ImucalsFilesAreReadByItsEquation) {
  const Imported imported = import(imucal_text);
  EXPECT_EQ(imported.format, "imucal");
  EXPECT_THAT(imported.warnings, IsEmpty());
  const Matrix3d K_a = Vector3d(0.1, 0.102, 0.104).asDiagonal(), K_g = Vector3d(1.01, 0.99, 1.02).asDiagonal();
  Matrix3d R_a, R_g, K_ga;
  R_a << 1, 0.01, 0, 0, 1, 0.02, 0.03, 0, 1;
  R_g << 1, 0, 0.01, 0.02, 1, 0, 0, 0.03, 1;
  K_ga << 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09;
  const Vector3d g(0.3, -0.5, 0.9), dps(100, -50, 20);  // readings in the file's units
  // mad-lab-fau/imucal, imucal/ferraris_calibration_info.py, _calibrate_acc and _calibrate_gyr
  const Vector3d acc = R_a.inverse() * K_a.inverse() * (g - Vector3d(0.05, -0.06, 0.04));
  const Vector3d gyr = R_g.inverse() * K_g.inverse() * (dps - (K_ga * acc + Vector3d(0.5, -0.6, 0.7)));
  const Motion found = compensate(imported.calibration.model, {unit::g * g, unit::deg * dps});
  EXPECT_LT((found.force - acc).norm(), 1e-12);
  EXPECT_LT((found.rate - unit::deg * gyr).norm(), 1e-12);
  std::string text = imucal_text;
  text.replace(text.find("\"from_acc_unit\": \"g\""), 20, "\"from_acc_unit\": \"a.u.\"");
  EXPECT_EQ(import(text).calibration.model.accel.raw_unit, "count");
  text.replace(text.find("\"from_gyr_unit\": \"deg/s\""), 24, "\"from_gyr_unit\": null");
  EXPECT_THAT(import(text).warnings, Contains(HasSubstr("from_gyr_unit is not given")));
}

constexpr const char* psins_text =
    "Kg = [\r\n\t1.01e+00 \t2.0e-03 \t-1.0e-03\r\n\t3.0e-03 \t9.9e-01 \t4.0e-03\r\n\t-5.0e-03 \t6.0e-03 \t1.02e+00\r\n\t];\r\n"
    "eb = [\r\n\t1.0e+01 \t-2.0e+01 \t3.0e+01\r\n\t]; \t% deg/h\r\n"
    "Ka = [\r\n\t9.9e-01 \t0.0e+00 \t0.0e+00\r\n\t1.0e-03 \t1.01e+00 \t0.0e+00\r\n\t2.0e-03 \t3.0e-03 \t1.005e+00\r\n\t];\r\n"
    "db = [\r\n\t1.0e+03 \t-2.0e+03 \t3.0e+03\r\n\t]; \t% ug\r\n"
    "Ka2 = [\r\n\t0.0e+00 \t0.0e+00 \t0.0e+00\r\n\t]; \t% ug/g^2\r\n"
    "rx = [\r\n\t0.0e+00 \t0.0e+00 \t0.0e+00\r\n\t]; \t% cm\r\n"
    "tGA = [\r\n\t0.0e+00\r\n\t]; \t% ms\r\n"
    "gSens = [\r\n\t1.0e+01 \t2.0e+01 \t3.0e+01\r\n\t4.0e+01 \t5.0e+01 \t6.0e+01\r\n\t7.0e+01 \t8.0e+01 \t9.0e+01\r\n\t];\r\n";

TEST(Import, PsinsFilesAreReadByItsEquation) {
  const Imported imported = import(psins_text);
  EXPECT_EQ(imported.format, "PSINS");
  EXPECT_THAT(imported.warnings, IsEmpty());
  EXPECT_EQ(imported.calibration.frame, "accelerometers");
  Matrix3d Kg, Ka, gSens;
  Kg << 1.01, 2e-3, -1e-3, 3e-3, 0.99, 4e-3, -5e-3, 6e-3, 1.02;
  Ka << 0.99, 0, 0, 1e-3, 1.01, 0, 2e-3, 3e-3, 1.005;
  gSens << 10, 20, 30, 40, 50, 60, 70, 80, 90;
  const Vector3d eb = Vector3d(10, -20, 30) * unit::deg_per_h, db = Vector3d(1000, -2000, 3000) * unit::ug;
  const Vector3d fm(3, -5, 8), wm(0.5, -1, 2);
  // PSINS, imuclbt.m by imuadderr.m with imuerr = -clbt: drift gets imu(:,4:6) gSens' before Ka, then imu = K imu + drift
  const Vector3d f = Ka * fm - db, w = Kg * wm - eb - gSens * (unit::deg_per_h / unit::g) * fm;
  const Motion found = compensate(imported.calibration.model, {fm, wm});
  EXPECT_LT((found.force - f).norm(), 1e-12);
  EXPECT_LT((found.rate - w).norm(), 1e-12);
}

TEST(Import, AMatrixAndABiasAreTakenAsTheyStand) {
  const Imported one = import("# C, then b\n1.01 0 0\n0.002, 0.99, 0\n0 0 1;\n0.1 -0.2 +0.3\n");
  EXPECT_EQ(one.format, "matrix and bias");
  EXPECT_EQ(one.calibration.frame, "accelerometers");
  EXPECT_EQ(one.calibration.model.accel.raw_unit, "m/s^2");
  EXPECT_LT((compensate(one.calibration.model, {{1.1, 0.8, 9}, {0, 0, 0}}).force - Vector3d(1.01, 0.992, 8.7)).norm(), 1e-14);
  const Imported two = import("1 0 0 0 1 0 0 0 1 0 0 0\n2e-4 1e-6 0 0 2e-4 0 0 0 2e-4 10 20 30\n");
  EXPECT_EQ(two.calibration.model.gyro.raw_unit, "count");
  EXPECT_THAT(two.warnings, Contains(HasSubstr("taken as counts, because their scale is 0.0002")));
  ImportOptions si;
  si.raw = "si";
  EXPECT_EQ(import("1 0 0 0 1 0 0 0 1 0 0 0\n2e-4 1e-6 0 0 2e-4 0 0 0 2e-4 10 20 30\n", si).calibration.model.gyro.raw_unit, "rad/s");
}

constexpr const char* chain = R"(%YAML:1.0
---
imu0:
  T_i_b: !!opencv-matrix
    rows: 4
    cols: 4
    dt: d
    data: [0., -1., 0., 0., 1., 0., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.]
  accelerometer_noise_density: 2.0e-3
  gyroscope_noise_density: 1.7e-04
  accelerometers: {M: !!opencv-matrix {rows: 3, cols: 3, dt: d, data: [2., 0., 0., 0., 1., 0., 0., 0., 1.]}}
  gyroscopes:
    M: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    A: [0, 0, 0, 0, 0, 0, 0, 0, 0]
    C_gyro_i: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
)";

TEST(Import, OpenCvsYamlIsRead) {
  const Imported imported = import(chain);
  EXPECT_EQ(imported.format, "Kalibr");
  // a_b = C_i_b^T M^-1 a_m
  EXPECT_LT((compensate(imported.calibration.model, {{2, 3, 4}, {0, 0, 0}}).force - Vector3d(3, -1, 4)).norm(), 1e-15);
}

TEST(Import, NoiseAloneChangesNothingAndSaysSo) {
  const ImuNoise noise = some_noise();
  const Calibration c = si_unit();
  for (const char* target : {"kalibr-imu", "euroc"}) {
    const Imported imported = import(exported(target, {c, &noise}));
    EXPECT_THAT(imported.warnings, Contains(HasSubstr("holds noise and no matrices"))) << target;
    EXPECT_EQ(imported.calibration.model.accel.matrix, Matrix3d(Matrix3d::Identity()));
  }
}

TEST(Import, OpenVinsIgnoresATriangleAndSoDoesImport) {
  const Imported imported =
      import("imu0:\n  model: \"kalibr\"\n  Tw: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n  Ta: [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]\n");
  EXPECT_EQ(imported.calibration.model.accel.matrix, Matrix3d(Matrix3d::Identity()));
  EXPECT_THAT(imported.warnings, Contains(HasSubstr("Ta: its upper triangle is left out")));
}

TEST(Import, TheCalibrationIsOneWithoutUncertainties) {
  const Imported imported = import(psins_text);
  const Calibration back = parse_calibration(calibration_text(imported.calibration), "calibration.json");
  EXPECT_THAT(back.estimated, IsEmpty());
  EXPECT_THAT(unusable(back), IsEmpty());
  EXPECT_EQ(back.quality.verdict, "doubtful");
  EXPECT_EQ(back.options.at("format"), "PSINS");
  EXPECT_LT(difference(imported.calibration.model, back.model), 1e-300);
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

std::string error_of(const std::string& text, const ImportOptions& options = {}) {
  try {
    import(text, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Import, DamageIsNamedByFileAndLine) {
  const ImuNoise noise = some_noise();
  const Calibration thermal = thermal_unit(), plain = si_unit();
  const std::string px4 = exported("px4", {thermal}), ardupilot = exported("ardupilot", {thermal}), vectornav = exported("vectornav", {plain}),
                    json = exported("json-matrix", {plain}), yaml = chain;
  struct Damage {
    std::string text, message;
  };
  const Damage cases[] = {
      {"", "file: is empty; expected a calibration"},
      {" \n\t\n", "file: is empty"},
      {"hello", "file: is in no format that import knows; expected one of json-matrix"},
      {"{}", "file: is in no format"},
      {calibration_text(plain), "file: is a calibration of imulab already"},
      {std::string((std::size_t{1} << 20) + 1, '1'), "file: is longer than a MiB"},
      {replaced(yaml, "M: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "M: [[1, 0, 0], [0, 1, 0]]"),
       "file:13: imu0.gyroscopes.M: expected 3 rows of 3 numbers"},
      {replaced(yaml, "M: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "M: [[1, 0], [0, 1, 0], [0, 0, 1]]"), "file:13: imu0.gyroscopes.M: expected 3 rows"},
      {replaced(yaml, "M: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "M: 3"), "file:13: imu0.gyroscopes.M: expected 3 rows"},
      {replaced(yaml, "M: [[1, 0, 0]", "M: [[.nan, 0, 0]"), "file:13: imu0.gyroscopes.M[0][0]: expected a number, found \".nan\""},
      {replaced(yaml, "M: [[1, 0, 0]", "M: [[1e999, 0, 0]"), "file:13: imu0.gyroscopes.M[0][0]: expected a number"},
      {replaced(yaml, "M: [[1, 0, 0]", "M: [[0, 0, 0]"), "file:13: imu0.gyroscopes.M: is singular"},
      {replaced(yaml, "rows: 3", "rows: 9"), "file:11: imu0.accelerometers.M: expected 3 rows and 3 columns"},
      {replaced(yaml, "data: [0., -1.", "data: [5., -1."), "file:4: imu0.T_i_b: expected a rotation matrix"},
      {replaced(yaml, "    A: [0, 0, 0, 0, 0, 0, 0, 0, 0]\n", ""), "file:13: imu0.gyroscopes.A: is missing"},
      {replaced(yaml, "    A: ", "    M: "), "file:14: M: is given twice; expected each key once"},
      {replaced(yaml, "    A: [0, 0", "    A: [0, ["), "file:"},
      {replaced(yaml, "    A: [0,", "    A: &a [0,") + "x: *a\n", "file:16: an alias; expected values written out"},
      {"gyroscope_noise_density: " + std::string(30, '['), "file:1: nested deeper than 20"},
      {"gyroscope_noise_density: \n" + std::string(30, '-'), "file:"},
      {"gyroscope_noise_density:\n- - - - - - - - - - - - - - - - - - - - - - - 1\n", "file:2: nested deeper than 20"},
      {"gyroscope_noise_density: 1\n? [a]\n: 2\n", "file:2: a key that is no text"},
      {"gyroscope_noise_density: \"unfinished\n", "file:"},
      {"Tw: 1\n" + std::string(300000, '#'), "file: is longer than 256 KiB"},
      {replaced(px4, "CAL_ACC0_YOFF", "CAL_ACC0_XOFF"), "file:"},
      {replaced(px4, "CAL_GYRO0_ZOFF", "CAL_GYRO0_QOFF"), "file: CAL_GYRO0_ZOFF: is missing"},
      {replaced(px4, "TC_A0_TMIN", "TC_A0_QMIN"), "file: TC_A0_TMIN: is missing"},
      {"1 1 CAL_ACC0_XOFF nan 9\n", "file:1: CAL_ACC0_XOFF: expected a number, found \"nan\""},
      {"1 1 CAL_ACC0_XOFF\n", "file:1: 1 1 CAL_ACC0_XOFF: expected NAME,VALUE"},
      {replaced(ardupilot, "INS_ACCSCAL_Y", "INS_ACCSCAL_Q"), "file: INS_ACCSCAL_Y: is missing"},
      {"INS_ACCOFFS_X,\n", "file:1: INS_ACCOFFS_X,: expected NAME,VALUE"},
      {"INS_ACCOFFS_X,1\nINS_ACCOFFS_X 2\n", "file:2: INS_ACCOFFS_X: is given twice"},
      {replaced(vectornav, "$VNWRG,84,", "$VNWRG,85,"), "file: register 84: is missing"},
      {"$VNWRG,25,1,2,3*00\n", "file:1: register 25: expected 12 numbers"},
      {replaced(imucal_text, "\"b_a\": [0.05, -0.06, 0.04]", "\"b_a\": [0.05, -0.06]"), "file: b_a: expected 3 numbers"},
      {replaced(imucal_text, "\"R_a\"", "\"R_b\""), "file: R_a: is missing"},
      {replaced(imucal_text, "\"K_ga\"", "\"K_a\""), "file: K_a: is given twice"},
      {replaced(imucal_text, "\"deg/s\"", "\"furlong\""), "file: gyr_unit: expected m/s^2, g, rad/s, deg/s or a.u."},
      {std::string(imucal_text).substr(0, 300), "file:3: not JSON"},
      {replaced(json, "imulab.matrix/1", "imulab.matrix/2"), "file: format: expected \"imulab.matrix/1\""},
      {std::string("{\"format\": \"imulab.matrix/1\", \"a\": ") + std::string(5000, '['), "file: nested too deeply"},
      {replaced(psins_text, "1.01e+00", "1.01x"), "file:2: \"1.01x\": expected a number"},
      {replaced(psins_text, "Ka = [", "Kb = ["), "file: Ka: is missing"},
      {replaced(psins_text, "db = [", "Ka = ["), "file:14: Ka: is given twice"},
      {replaced(psins_text, "1.0e+01 \t-2.0e+01", "1.0e+01"), "file:6: eb: 2 numbers; expected 3"},
      {"Kg = [ 1 2 3\n", "file:1: a block without its ]"},
      {"Kg = [1 2 3 4 5 6 7 8 9 10];", "file:1: more than 9 numbers"},
      {"1 0 0\n0 1 0\n0 0 1\n", "file:3: 9 numbers; expected 12"},
      {"1 0 0\n0 1 zero\n0 0 1\n0 0 0\n", "file:2: \"zero\": expected a number"},
      {"1 0 0\n0 1 inf\n0 0 1\n0 0 0\n", "file:2: \"inf\": expected a number"},
      {"1 0 0\n0 0 0\n0 0 1\n0 0 0\n", "file: the accelerometers' matrix: is singular"},
      {"1 0 0 0 1 0 0 0 1\n1 1 0 0 1 0 0 0 1\n0 0 0\n", "file:2: the second matrix of imu_tk holds scales; expected a diagonal matrix"},
      {"1e308 0 0 0 1e308 0 0 0 1e308 1e308 0 0", "file: the accelerometers' numbers are too large"},
  };
  for (const Damage& d : cases) EXPECT_THAT(error_of(d.text), StartsWith(d.message)) << d.text.substr(0, 200);
  ImportOptions second;
  second.instance = 1;
  EXPECT_THAT(error_of(chain, second), StartsWith("file:3: imu1: is missing"));
}

TEST(Import, NoBytesDoMoreThanAnError) {
  const ImuNoise noise = some_noise();
  const Calibration thermal = thermal_unit();
  std::vector<std::string> seeds;
  for (const auto& entry : std::filesystem::directory_iterator(IMULAB_SOURCE "/tests/imports"))
    if (entry.path().extension() != ".md") {
      seeds.push_back(read_text(entry.path()));
      EXPECT_NO_THROW(import(seeds.back())) << entry.path();
    }
  for (const char* target : {"kalibr", "openvins", "px4", "ardupilot", "vectornav", "json-matrix"})
    seeds.push_back(exported(target, {thermal, &noise}));
  const RandomStream random(77, "damage");
  std::uint64_t draw = 0;
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random.uniform(draw++) * static_cast<double>(n)); };
  constexpr std::string_view alphabet =
      "[]{}:,-?&*!|>'\"%@`#\n\t \0\xff"
      "0.e+";
  int accepted = 0, refused = 0;
  for (const std::string& seed : seeds)
    for (int i = 0; i < 300; ++i) {
      std::string text = seed;
      for (std::size_t k = below(4) + 1; k-- > 0 && !text.empty();) {
        const std::size_t at = below(text.size()), kind = below(4);
        if (kind == 0) text.resize(at);
        if (kind == 1) text[at] = alphabet[below(alphabet.size())];
        if (kind == 2) text.erase(at, below(40));
        if (kind == 3) text.insert(at, text.substr(below(text.size()), below(100)));
      }
      try {
        const Imported imported = import(text);
        EXPECT_NO_THROW(parse_calibration(calibration_text(imported.calibration), "calibration.json")) << text;
        ++accepted;
      } catch (const Error&) {
        ++refused;
      }
    }
  EXPECT_GT(accepted, 100);  // much damage hits comments and digits
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace imulab::export_test
