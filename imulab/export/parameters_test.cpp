// Targets of parameters, registers and tables: as targets_test.cpp.
#include "imulab/coefficient.hpp"
#include "imulab/export/consumer_model.hpp"

#include <Eigen/LU>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/export_unit.hpp"
#include "tests/parameter_loaders.hpp"
#include <algorithm>
#include <map>
#include <sstream>

namespace imulab::export_test {
namespace {

constexpr int parameter_samples = 10000;

TEST(ExportTargets, LoadersFindEveryParameterOnceAndNoOther) {
  Calibration c = thermal_unit(11);
  c.imu = std::string(119, 'x') + " INS_GYR_CAL 0 " + std::string(200, 'y');  // a name as long as heads admit
  c.quality.unobservable = {"gyro.g_sensitivity.xx", "gyro.g_sensitivity.xy", "gyro.g_sensitivity.xz", "gyro.g_sensitivity.yx", "accel.cubic.x"};
  for (const int instance : {0, 1}) {
    ExportInput input{c};
    input.options.instance = instance;
    // Accelerometers' offsets and scales, gyros' offsets: 9. PX4: 15 of each triad's temperature, and its switch. ArduPilot: 9 of each, range,
    // switch, and the temperatures of the offsets.
    EXPECT_EQ(parameters_of(exported("px4", input), true).size(), 9u + 2 * (15 + 1));
    const Parameters ardupilot = parameters_of(exported("ardupilot", input), false);
    EXPECT_EQ(ardupilot.size(), 9u + 2 * 9 + 3 + 2);
    for (const auto& [name, value] : ardupilot) EXPECT_TRUE(name.starts_with("INS_")) << name;
  }
}

using Vector3f = Eigen::Vector3f;

/// PX4/PX4-Autopilot: TemperatureCompensation::calc_thermal_offsets_3D, then calibration::Accelerometer::Correct, Gyroscope::Correct (float).
Vector3f px4_thermal(const Parameters& p, const char* group, float temperature) {
  const auto at = [&](const std::string& name) { return p.at(fmt::format("{}0_{}", group, name)); };
  Vector3f offset = Vector3f::Zero();
  const auto enable = p.find(std::string(group) + "_ENABLE");
  if (enable == p.end() || enable->second == 0) return offset;
  const float delta = std::clamp(temperature, at("TMIN"), at("TMAX")) - at("TREF");
  for (int axis = 0; axis < 3; ++axis) {
    float power = delta;
    offset[axis] = at(fmt::format("X0_{}", axis)) + at(fmt::format("X1_{}", axis)) * power;
    power *= delta;
    offset[axis] += at(fmt::format("X2_{}", axis)) * power;
    power *= delta;
    offset[axis] += at(fmt::format("X3_{}", axis)) * power;
  }
  return offset;
}

Motion px4_correct(const Parameters& p, const RawSample& raw, double temperature) {
  const Vector3f off(p.at("CAL_ACC0_XOFF"), p.at("CAL_ACC0_YOFF"), p.at("CAL_ACC0_ZOFF")),
      scale(p.at("CAL_ACC0_XSCALE"), p.at("CAL_ACC0_YSCALE"), p.at("CAL_ACC0_ZSCALE")),
      gyro_off(p.at("CAL_GYRO0_XOFF"), p.at("CAL_GYRO0_YOFF"), p.at("CAL_GYRO0_ZOFF"));
  const auto t = static_cast<float>(temperature);
  const Vector3f a = (raw.accel.cast<float>() - px4_thermal(p, "TC_A", t) - off).cwiseProduct(scale);
  const Vector3f w = raw.gyro.cast<float>() - px4_thermal(p, "TC_G", t) - gyro_off;
  return {.rate = w.cast<double>(), .force = a.cast<double>()};
}

/// ArduPilot/ardupilot: AP_InertialSensor_TCal::correct_sensor, then AP_InertialSensor_Backend::_rotate_and_correct_accel and ..._gyro (float).
Vector3f tcal_correct(const Parameters& p, const char* triad, float temperature, Vector3f v) {
  const auto enable = p.find("INS_TCAL1_ENABLE");
  if (enable == p.end() || enable->second != 1) return v;
  const auto calibrated = p.find(fmt::format("INS_{}1_CALTEMP", triad));
  const float low = p.at("INS_TCAL1_TMIN"), high = p.at("INS_TCAL1_TMAX");
  const float cal = std::clamp(calibrated == p.end() ? -300.f : calibrated->second, low, high);
  const auto polynomial = [&](float d) {
    Vector3f c[3];
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) c[k][axis] = p.at(fmt::format("INS_TCAL1_{}{}_{}", triad, k + 1, "XYZ"[axis]));
    return Vector3f((c[0] + (c[1] + c[2] * d) * d) * d * 1.0e-6f);
  };
  return v - polynomial(std::clamp(temperature, low, high) - 35.f) + polynomial(cal - 35.f);
}

Motion ardupilot_correct(const Parameters& p, const RawSample& raw, double temperature) {
  const auto xyz = [&](const char* name) {
    return Vector3f(p.at(fmt::format("{}_X", name)), p.at(fmt::format("{}_Y", name)), p.at(fmt::format("{}_Z", name)));
  };
  const auto t = static_cast<float>(temperature);
  const Vector3f a = (tcal_correct(p, "ACC", t, raw.accel.cast<float>()) - xyz("INS_ACCOFFS")).cwiseProduct(xyz("INS_ACCSCAL"));
  return {.rate = (tcal_correct(p, "GYR", t, raw.gyro.cast<float>()) - xyz("INS_GYROFFS")).cast<double>(), .force = a.cast<double>()};
}

/// The model of an autopilot: diagonal accelerometers, gyros without scale.
SensorModel autopilot_model(SensorModel m) {
  const Vector3d b_a = bias_of(m.accel), b_g = bias_of(m.gyro);
  m.accel.matrix = Matrix3d(m.accel.matrix.diagonal().asDiagonal());
  m.accel.offset = -m.accel.matrix * b_a;
  m.gyro.matrix.setIdentity();
  m.gyro.offset = -b_g;
  m.g_sensitivity.setZero();
  return m;
}

TEST(ExportTargets, AutopilotsGiveWhatCompensateGivesForWhatTheyHold) {
  for (const auto& [unit, zero] : {std::pair{"degC", 0.0}, {"K", 273.15}}) {
    Calibration c = thermal_unit(11, unit, zero);
    c.model = autopilot_model(c.model);
    const Parameters px4 = parameters_of(exported("px4", {c}), true), ardupilot = parameters_of(exported("ardupilot", {c}), false);
    EXPECT_THAT(export_target("px4").left_out({c}), testing::IsEmpty());
    EXPECT_THAT(export_target("ardupilot").left_out({c}), testing::IsEmpty());
    const RandomStream random(6, "autopilots");
    double worst = 0;
    for (int i = 0; i < parameter_samples; ++i) {
      const double T = -5 + 65 * random.uniform(static_cast<std::uint64_t>(i)), tau = T - 22.5;
      const Reading r = random_reading(c.model, random, 1000000 + static_cast<std::uint64_t>(i), tau, tau);
      for (const Motion& m : {px4_correct(px4, r.raw, T), ardupilot_correct(ardupilot, r.raw, T)})
        worst = std::max({worst, (m.force - r.compensated.force).cwiseAbs().maxCoeff() / (1 + r.raw.accel.cwiseAbs().maxCoeff()),
                          (m.rate - r.compensated.rate).cwiseAbs().maxCoeff() / (1 + r.raw.gyro.cwiseAbs().maxCoeff())});
    }
    // Single precision: some ten operations, each rounded to 6e-8 of readings; coefficients likewise.
    EXPECT_LT(worst, 1e-6) << unit;
    EXPECT_GT(worst, 0) << unit;
  }
}

TEST(ExportTargets, ArduPilotsReferenceOutsideTheRangeIsMovedInto) {
  Calibration c = thermal_unit(12);
  c.model = autopilot_model(c.model);
  c.model.accel.temperature->reference = 80;
  c.model.gyro.temperature->range = {10, 50};  // both triads share one range
  const Parameters p = parameters_of(exported("ardupilot", {c}), false);
  EXPECT_EQ(p.at("INS_TCAL1_TMIN"), 10);
  EXPECT_EQ(p.at("INS_TCAL1_TMAX"), 50);
  const RandomStream random(8, "reference");
  for (int i = 0; i < 100; ++i) {
    const double T = 10 + 0.4 * i;
    const Reading r = random_reading(c.model, random, static_cast<std::uint64_t>(i), T - 80, T - 22.5);
    const Motion m = ardupilot_correct(p, r.raw, T);
    EXPECT_LT((m.force - r.compensated.force).norm(), 1e-4);  // single precision of readings up to some 50 m/s^2
    EXPECT_LT((m.rate - r.compensated.rate).norm(), 1e-5);
  }
}

TEST(ExportTargets, WhatArduPilotsOneRangeCostsIsStated) {
  Calibration c = thermal_unit(12);
  c.model = autopilot_model(c.model);
  c.model.gyro.temperature->range = {10, 50};
  const Parameters p = parameters_of(exported("ardupilot", {c}), false);
  double worst = 0;
  for (double T = -5; T <= 60; T += 0.5) {
    const RandomStream random(8, "one range");
    const Reading r = random_reading(c.model, random, 1, T - 22.5, T - 22.5);
    worst = std::max(worst, (ardupilot_correct(p, r.raw, T).force - r.compensated.force).cwiseAbs().maxCoeff());
  }
  const auto lost = export_target("ardupilot").left_out({c});
  ASSERT_EQ(lost.size(), 1u) << "the gyros' range is within the accelerometers'";
  EXPECT_THAT(lost[0], testing::AllOf(testing::StartsWith("accelerometers' thermal terms outside 10 to 50 degC, one range for both triads: up to "),
                                      testing::EndsWith("mg over -5 to 60 degC")));
  const double mg = std::stod(lost[0].substr(lost[0].find("up to ") + 6));
  EXPECT_NEAR(mg * 1e3 * unit::ug / worst, 1, 0.01);  // three figures are written
}

TEST(ExportTargets, PX4sHeadSaysWhatItsStepsOfADegreeCost) {
  Calibration c = thermal_unit(11);
  c.model.accel.matrix.setIdentity();
  c.model.accel.thermal.setZero();
  c.model.accel.thermal(1, 1) = 0.02;
  c.model.accel.thermal(1, 2) = 1e-4;  // 0.02 + 2e-4 (60 - 22.5) = 0.0275 m/s^2 a degree at 60 degC: 2.80 mg
  EXPECT_THAT(exported("px4", {c}), testing::HasSubstr("when the temperature has changed by more than 1 degC: within 2.8 mg."));
}

TEST(ExportTargets, AutopilotsLearnOfNoThermalOffsetsAndOfWhatTheyMeasureAnew) {
  const Calibration c = si_unit();
  const std::string px4 = exported("px4", {c}), ardupilot = exported("ardupilot", {c});
  for (const char* text : {"\n1\t1\tTC_A_ENABLE\t0\t6\n", "\n1\t1\tTC_G_ENABLE\t0\t6\n", "IMU_GYRO_CAL_EN", "SENS_IMU_AUTOCAL"})
    EXPECT_THAT(px4, testing::HasSubstr(text));
  for (const char* text : {"\nINS_TCAL1_ENABLE,0\n", "INS_ACC_ID and INS_GYR_ID"}) EXPECT_THAT(ardupilot, testing::HasSubstr(text));
}

struct Registers {
  Matrix3d C[2];
  Vector3d B[2];
};

Registers registers_of(const std::string& text) {
  Registers out;
  std::istringstream lines(text);
  int found = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with('$')) continue;
    const std::size_t star = line.find('*');
    unsigned checksum = 0;
    for (const char c : line.substr(1, star - 1)) checksum ^= static_cast<unsigned char>(c);
    EXPECT_EQ(std::stoul(line.substr(star + 1, 2), nullptr, 16), checksum) << line;
    if (!line.starts_with("$VNWRG,")) continue;
    std::string numbers = line.substr(7, star - 7);
    std::replace(numbers.begin(), numbers.end(), ',', ' ');
    std::istringstream values(numbers);
    int number = 0;
    values >> number;
    const int k = number == 25 ? 0 : 1;
    EXPECT_TRUE(number == 25 || number == 84);
    for (int i = 0; i < 9; ++i) values >> out.C[k](i / 3, i % 3);
    for (int i = 0; i < 3; ++i) values >> out.B[k][i];
    EXPECT_TRUE(values);
    ++found;
  }
  EXPECT_EQ(found, 2);
  return out;
}

TEST(ExportTargets, VectorNavsRegistersGiveWhatCompensateGives) {
  Calibration c = si_unit(13);
  c.model.g_sensitivity.setZero();
  const Registers v = registers_of(exported("vectornav", {c}));
  const RandomStream random(7, "vectornav");
  Worst worst;
  for (int i = 0; i < parameter_samples; ++i) {
    const Reading r = random_reading(c.model, random, static_cast<std::uint64_t>(i));
    worst.add({.rate = v.C[1] * (r.raw.gyro - v.B[1]), .force = v.C[0] * (r.raw.accel - v.B[0])},
              r.compensated);  // VN-100 user manual, registers 25 and 84
  }
  EXPECT_LT(worst.force, 2e-7);  // the registers' numbers are rounded to single precision, 6e-8 each
  EXPECT_LT(worst.rate, 2e-7);
}

/// A unit in counts with every term of the model.
Calibration full_unit() {
  Calibration c = thermal_unit(14, "raw", 5000);
  c.model.accel.raw_unit = c.model.gyro.raw_unit = "count";
  c.model.accel.quadratic = {1e-5, -2e-5, 3e-5};
  c.model.gyro.cubic = {1e-4, -2e-4, 3e-4};
  return c;
}

TEST(ExportTargets, JsonMatricesGiveWhatCompensateGives) {
  const Calibration c = full_unit();
  const auto json = nlohmann::json::parse(exported("json-matrix", {c}));
  const auto matrix = [](const nlohmann::json& j) {
    Matrix3d m;
    for (std::size_t i = 0; i < 9; ++i) m(static_cast<int>(i) / 3, static_cast<int>(i) % 3) = j[i / 3][i % 3].get<double>();
    return m;
  };
  const auto vector = [](const nlohmann::json& j) { return Vector3d(j[0].get<double>(), j[1].get<double>(), j[2].get<double>()); };
  const RandomStream random(9, "json");
  Worst worst;
  for (int i = 0; i < parameter_samples; ++i) {
    const double T = 4995 + 65 * random.uniform(static_cast<std::uint64_t>(i)), tau = T - 5022.5;
    const Reading r = random_reading(c.model, random, 1000000 + static_cast<std::uint64_t>(i), tau, tau);
    const auto triad = [&](const nlohmann::json& j, const Vector3d& u, const Vector3d& taken) {
      const double d = T - j["thermal"]["reference"].get<double>();
      const Vector3d V = u - vector(j["thermal"]["c1"]) * d - vector(j["thermal"]["c2"]) * d * d;
      Vector3d out = matrix(j["matrix"]) * (V - vector(j["bias"]) - taken);
      if (j.contains("quadratic")) out += vector(j["quadratic"]).cwiseProduct(V.cwiseAbs2());
      if (j.contains("cubic")) out += vector(j["cubic"]).cwiseProduct(V.cwiseAbs2()).cwiseProduct(V);
      return out;
    };
    const Vector3d a = triad(json["accelerometers"], r.raw.accel, Vector3d::Zero());
    worst.add({.rate = triad(json["gyros"], r.raw.gyro, matrix(json["gyros"]["g_sensitivity"]) * a), .force = a}, r.compensated);
  }
  EXPECT_LT(worst.force, double_rounding);
  EXPECT_LT(worst.rate, double_rounding);
}

TEST(ExportTargets, CsvHasEveryCoefficient) {
  Calibration c = full_unit();
  c.estimated = {coefficient_index("gyro.matrix.xy")};
  c.covariance = Eigen::MatrixXd::Constant(1, 1, 4e-12);
  const ImuNoise noise = some_noise();
  std::istringstream lines(exported("csv", {c, &noise}));
  std::map<std::string, std::array<std::string, 3>> rows;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream fields(line);
    std::array<std::string, 4> f;
    for (std::string& field : f) std::getline(fields, field, ',');
    rows[f[0]] = {f[1], f[2], f[3]};
  }
  EXPECT_EQ(rows.at("name")[0], "value");
  for (const CoefficientIndex i : coefficient_indices())
    if (const auto row = rows.find(std::string(coefficient(i).name)); row != rows.end())
      EXPECT_EQ(std::stod(row->second[0]), coefficient_value(c.model, i));
    else
      EXPECT_TRUE(is_extended(coefficient(i)) && coefficient_value(c.model, i) == 0) << coefficient(i).name;
  EXPECT_EQ(std::stod(rows.at("gyro.matrix.xy")[1]), 2e-6);
  EXPECT_EQ(rows.at("accel.matrix.xy")[1], "");
  EXPECT_EQ(rows.at("accel.matrix.xx")[1], "inf") << "counts whose scale was not estimated";
  EXPECT_EQ(std::stod(rows.at("noise.gyro.K")[0]), 4e-6);
  EXPECT_EQ(std::stod(rows.at("accel.temperature.reference")[0]), 5022.5);
}

}  // namespace
}  // namespace imulab::export_test
