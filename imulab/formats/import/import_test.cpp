// Files of other programs become calibrations that do what those programs' equations do; what was exported comes back; damage is named by file and
// line.
#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/exchange.hpp"
#include "imulab/files.hpp"

#include <Eigen/LU>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include "tests/import_texts.hpp"
#include "tests/run_command.hpp"
#include <algorithm>
#include <functional>

namespace imulab::export_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

TEST(Import, EveryTermOfMatricesAndTablesComesBack) {
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
  const Imported read = import(exported("csv", {c}));
  EXPECT_THAT(read.warnings, IsEmpty()) << "the table tells the unit of the readings";
  const Calibration& table = read.calibration;
  for (const CoefficientIndex i : coefficient_indices()) EXPECT_EQ(coefficient_value(table.model, i), coefficient_value(c.model, i));
  EXPECT_EQ(table.model.gyro.temperature, c.model.gyro.temperature);
  EXPECT_EQ(table.model.gyro.raw_unit, "count");
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

TEST(Import, TermsOfThirdOrderAreTheAutopilots) {
  const Imported imported = import(import_file("ardupilot.param"));
  EXPECT_THAT(imported.warnings, IsEmpty());
  // ArduPilot's equation (AP_InertialSensor_tempcal.cpp) for the z accelerometer of this file: P(d) = 1e-6 (3000 d + 30 d^2 + 3 d^3), d = T - 35,
  // T at most 60 and at least -5 degC
  const auto P = [](double T) { return 1e-6 * (3000 + (30 + 3 * (T - 35)) * (T - 35)) * (T - 35); };
  const SampleCompensator compensator(imported.calibration.model);
  for (double T = -20; T <= 70; T += 0.25)
    EXPECT_NEAR(compensator({0, 0, 0}, {0, 0, 9.8}, T).force.z(), 9.8 - P(std::clamp(T, -5.0, 60.0)) + P(22.5) + 0.1, 1e-12) << T;
  // PX4's with the term in X3
  std::string px4 = exported("px4", {thermal_unit()});
  const std::string name = "TC_A0_X3_1\t0.0";
  ASSERT_NE(px4.find(name), std::string::npos);
  px4.replace(px4.find(name), name.size(), "TC_A0_X3_1\t1e-6");
  const Imported cubic = import(px4);
  EXPECT_THAT(cubic.warnings, IsEmpty());
  EXPECT_NEAR(cubic.calibration.model.accel.thermal(1, 3), 1e-6, 1e-12);
  EXPECT_NEAR(import(exported("px4", {cubic.calibration})).calibration.model.accel.thermal(1, 3), 1e-6, 1e-12);
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
  const RawSample raw{.gyro = {32000, 33000, 34000}, .accel = {30000, 35000, 31000}};
  const Motion found = compensate(m, raw);
  EXPECT_LT((found.force - T * K * (raw.accel - Vector3d(33123, 33276.4, 32360.5))).norm(), 1e-12 * 30);  // offsets of 13 m/s^2 cancel
  EXPECT_LT((found.rate - T_g * K_g * (raw.gyro - Vector3d(32768, 32760, 32750))).norm(), 1e-12 * 30);
  // The accelerometers alone
  const Imported alone = import(accel);
  EXPECT_THAT(alone.warnings, Contains(HasSubstr("a second file (gyro) may have them")));
  EXPECT_EQ(alone.calibration.model.gyro.matrix, Matrix3d(Matrix3d::Identity()));
}

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
  const Motion found = compensate(imported.calibration.model, {.gyro = unit::deg * dps, .accel = unit::g * g});
  EXPECT_LT((found.force - acc).norm(), 1e-12);
  EXPECT_LT((found.rate - unit::deg * gyr).norm(), 1e-12);
  std::string text = imucal_text;
  text.replace(text.find("\"acc_unit\": \"m/s^2\""), 19, "\"acc_unit\": \"g\"");
  const Motion in_g = compensate(import(text).calibration.model, {.gyro = unit::deg * dps, .accel = unit::g * g});
  EXPECT_LT((in_g.force - unit::g * acc).norm(), 1e-11);
  EXPECT_LT((in_g.rate - unit::deg * gyr).norm(), 1e-12);
  text.replace(text.find("\"from_acc_unit\": \"g\""), 20, "\"from_acc_unit\": \"a.u.\"");
  EXPECT_EQ(import(text).calibration.model.accel.raw_unit, "count");
  text = imucal_text;
  text.replace(text.find("\"gyr_unit\": \"deg/s\""), 19, "\"gyro_unit\": \"deg/s\"");  // before version 2
  EXPECT_LT((compensate(import(text).calibration.model, {.gyro = unit::deg * dps, .accel = unit::g * g}).rate - unit::deg * gyr).norm(), 1e-12);
  text.replace(text.find("\"gyro_unit\": \"deg/s\", "), 22, "");
  EXPECT_LT((compensate(import(text).calibration.model, {.gyro = unit::deg * dps, .accel = unit::g * g}).rate - unit::deg * gyr).norm(), 1e-12);
  EXPECT_THAT(import(text).warnings, Contains(HasSubstr("gyr_unit is not given: taken as deg/s")));
  text.replace(text.find("\"from_acc_unit\": \"g\""), 20, "\"from_acc_unit\": null");
  EXPECT_EQ(import(text).calibration.model.accel.raw_unit, "count") << "about 10 m/s^2 to one";
  text.replace(text.find("\"from_gyr_unit\": \"deg/s\""), 24, "\"from_gyr_unit\": null");
  EXPECT_THAT(import(text).warnings, Contains(HasSubstr("from_gyr_unit is not given")));
}

TEST(Import, PsinsFilesAreReadByItsEquation) {
  const Imported imported = import(psins_text);
  EXPECT_EQ(imported.format, "PSINS");
  EXPECT_THAT(imported.warnings, IsEmpty());
  EXPECT_EQ(imported.calibration.frame, BodyFrame::accelerometers);
  Matrix3d Kg, Ka, gSens;
  Kg << 1.01, 2e-3, -1e-3, 3e-3, 0.99, 4e-3, -5e-3, 6e-3, 1.02;
  Ka << 0.99, 0, 0, 1e-3, 1.01, 0, 2e-3, 3e-3, 1.005;
  gSens << 10, 20, 30, 40, 50, 60, 70, 80, 90;
  constexpr double g0 = 9.7803267714;  // PSINS' own, glvf.m
  const Vector3d eb = Vector3d(10, -20, 30) * unit::deg_per_h, db = Vector3d(1000, -2000, 3000) * (1e-6 * g0);
  const Vector3d fm(3, -5, 8), wm(0.5, -1, 2);
  // PSINS, imuclbt.m by imuadderr.m with imuerr = -clbt: drift gets imu(:,4:6) gSens' before Ka, then imu = K imu + drift
  const Vector3d f = Ka * fm - db, w = Kg * wm - eb - gSens * (unit::deg_per_h / g0) * fm;
  const Motion found = compensate(imported.calibration.model, {.gyro = wm, .accel = fm});
  EXPECT_LT((found.force - f).norm(), 1e-12);
  EXPECT_LT((found.rate - w).norm(), 1e-12);
}

TEST(Import, AMatrixAndABiasAreTakenAsTheyStand) {
  const Imported one = import("# C, then b\n1.01 0 0\n0.002, 0.99, 0\n0 0 1;\n0.1 -0.2 +0.3\n");
  EXPECT_EQ(one.format, "matrix and bias");
  EXPECT_EQ(one.calibration.frame, BodyFrame::accelerometers);
  EXPECT_EQ(one.calibration.model.accel.raw_unit, "m/s^2");
  EXPECT_LT((compensate(one.calibration.model, {.accel = {1.1, 0.8, 9}}).force - Vector3d(1.01, 0.992, 8.7)).norm(), 1e-14);
  const Imported two = import("1 0 0 0 1 0 0 0 1 0 0 0\n2e-4 1e-6 0 0 2e-4 0 0 0 2e-4 10 20 30\n");
  EXPECT_EQ(two.calibration.model.gyro.raw_unit, "count");
  EXPECT_THAT(two.warnings, Contains(HasSubstr("taken as counts, because their scale is 0.0002")));
  ImportOptions si;
  si.raw = "si";
  EXPECT_EQ(import("1 0 0 0 1 0 0 0 1 0 0 0\n2e-4 1e-6 0 0 2e-4 0 0 0 2e-4 10 20 30\n", si).calibration.model.gyro.raw_unit, "rad/s");
}

TEST(Import, OpenCvsYamlIsRead) {
  const Imported imported = import(chain);
  EXPECT_EQ(imported.format, "Kalibr");
  // a_b = C_i_b^T M^-1 a_m
  EXPECT_LT((compensate(imported.calibration.model, {.accel = {2, 3, 4}}).force - Vector3d(3, -1, 4)).norm(), 1e-15);
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
  EXPECT_EQ(back.quality.verdict, Verdict::doubtful);
  EXPECT_EQ(back.options.at("format"), "PSINS");
  EXPECT_LT(difference(imported.calibration.model, back.model), 1e-300);
}

}  // namespace
}  // namespace imulab::export_test
