// Every target's file, read back and put into the equation of its consumer, does what `compensate` does, as far as the target holds it; what is said
// to be lost is what is lost.
#include "imulab/core/error.hpp"
#include "imulab/io/export/consumer_model.hpp"
#include "imulab/io/export/loss.hpp"
#include "imulab/model/coefficient.hpp"

#include <Eigen/LU>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/export_unit.hpp"
#include <map>
#include <regex>
#include <sstream>
#include <yaml-cpp/yaml.h>

namespace imulab::export_test {
namespace {

using export_io::consumer_model;
using ::testing::HasSubstr;

constexpr int samples = 10000;

/// A model that the consumer can hold: its own offset terms aside.
Vector3d bias_of(const TriadModel& m) { return -m.matrix.inverse() * m.offset; }

YAML::Node yaml_of(std::string text) {
  if (text.starts_with("%YAML:1.0")) text[0] = '#';  // OpenCV's directive, which OpenCV and OpenVINS read and yaml-cpp does not
  return YAML::Load(text);
}
Matrix3d matrix_of(const YAML::Node& node) {
  Matrix3d m;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) m(static_cast<int>(i), static_cast<int>(j)) = node[i][j].as<double>();
  return m;
}

/// Largest difference, relative to the size of the motion.
struct Worst {
  double force = 0, rate = 0;
  void add(const Motion& found, const Motion& expected) {
    force = std::max(force, (found.force - expected.force).norm() / (1 + expected.force.norm()));
    rate = std::max(rate, (found.rate - expected.rate).norm() / (1 + expected.rate.norm()));
  }
};

constexpr double double_rounding = 1e-12;  // some tens of operations, numbers in the file exact

TEST(ExportTargets, KalibrsEquationGivesWhatCompensateGives) {
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  const YAML::Node imu = yaml_of(exported("kalibr", {c, &noise}))["imu0"];
  EXPECT_EQ(imu["model"].as<std::string>(), "scale-misalignment");
  const Matrix3d M_a = matrix_of(imu["accelerometers"]["M"]), M_g = matrix_of(imu["gyroscopes"]["M"]), A = matrix_of(imu["gyroscopes"]["A"]),
                 C_gyro_i = matrix_of(imu["gyroscopes"]["C_gyro_i"]), C_i_b = matrix_of(imu["T_i_b"]);
  for (const Matrix3d& M : {M_a, M_g}) EXPECT_TRUE(M(0, 1) == 0 && M(0, 2) == 0 && M(1, 2) == 0) << "Kalibr's design variables are lower triangular";
  const RandomStream random(2, "kalibr");
  const Vector3d b_a = bias_of(c.model.accel), b_g = bias_of(c.model.gyro);  // states of Kalibr
  Worst worst;
  for (int i = 0; i < samples; ++i) {
    const Reading r = random_reading(c.model, random, static_cast<std::uint64_t>(i));
    // ethz-asl/kalibr, aslam_offline_calibration/kalibr/python/kalibr_imu_camera_calibration/IccSensors.py, IccScaledMisalignedImu:
    // a = M (C_i_b a_b) + b,  w = M (C_gyro_b w_b) + Ma (C_gyro_b a_b) + b with C_gyro_b = C_gyro_i C_i_b, solved for a_b and w_b
    const Matrix3d C_gyro_b = C_gyro_i * C_i_b;
    const Vector3d a_b = (M_a * C_i_b).inverse() * (r.raw.accel - b_a);
    const Vector3d w_b = (M_g * C_gyro_b).inverse() * (r.raw.gyro - b_g - A * (C_gyro_b * a_b));
    worst.add({a_b, w_b}, r.compensated);
  }
  EXPECT_LT(worst.force, double_rounding);
  EXPECT_LT(worst.rate, double_rounding);
}

TEST(ExportTargets, KalibrsNoiseKeysAreWhatItChecks) {
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  for (const char* target : {"kalibr-imu", "kalibr", "openvins", "euroc"}) {
    YAML::Node imu = yaml_of(exported(target, {c, &noise}));
    if (imu["imu0"]) imu = imu["imu0"];
    EXPECT_DOUBLE_EQ(imu["accelerometer_noise_density"].as<double>(), 1.5e-3) << target;  // the worst axis
    EXPECT_DOUBLE_EQ(imu["accelerometer_random_walk"].as<double>(), 7.5e-5) << target;
    EXPECT_DOUBLE_EQ(imu["gyroscope_noise_density"].as<double>(), 1.5e-4) << target;
    EXPECT_EQ(imu["gyroscope_random_walk"].as<double>(), 4e-6) << target << ": the bound of the axis that is not determined";
    EXPECT_EQ(imu[std::string_view(target) == "euroc" ? "rate_hz" : "update_rate"].as<double>(), 200) << target;
    EXPECT_THAT(exported(target, {c, &noise}), HasSubstr("y <= 4e-06"));
    ExportInput mean{c, &noise};
    mean.options.axes = AxisChoice::mean;
    imu.reset(yaml_of(exported(target, mean)));
    if (imu["imu0"]) imu.reset(YAML::Node(imu["imu0"]));
    EXPECT_DOUBLE_EQ(imu["gyroscope_noise_density"].as<double>(), 1.25e-4) << target;
    EXPECT_DOUBLE_EQ(imu["gyroscope_random_walk"].as<double>(), (2e-6 + 4e-6 + 3e-6) / 3) << target;
  }
}

TEST(ExportTargets, NumbersAreNumbersInYaml11) {
  // PyYAML, which Kalibr uses, takes 1e-05 for a text: its numbers have a point and a signed exponent.
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  const std::regex number(R"([-+]?[0-9]+\.[0-9]*(e[-+][0-9]+)?)"), token(R"([-+]?[0-9][-+.0-9e]*)");
  for (const char* target : {"kalibr-imu", "kalibr", "openvins", "vins", "euroc", "ros"}) {
    std::istringstream lines(exported(target, {c, &noise}));
    int numbers = 0;
    for (std::string line; std::getline(lines, line);) {
      line = line.substr(0, line.find('#'));
      const std::size_t colon = line.find(": "), dash = line.find("- [");
      if (line.starts_with("%") || (colon == std::string::npos && dash == std::string::npos)) continue;
      std::string values = line.substr(colon != std::string::npos ? colon + 2 : dash + 2);
      if (values.find_first_of("/ghijklmopqrstuvwxyz") != std::string::npos || line.find("cols") != std::string::npos ||
          line.find("rows") != std::string::npos)
        continue;
      for (std::sregex_iterator at(values.begin(), values.end(), token), end; at != end; ++at, ++numbers)
        EXPECT_TRUE(std::regex_match(at->str(), number)) << target << ": " << line;
    }
    EXPECT_GE(numbers, 5) << target;
  }
}

TEST(ExportTargets, OpenVinsEquationGivesWhatCompensateGives) {
  const Calibration c = si_unit(5);
  const ImuNoise noise = some_noise();
  for (const std::string model : {"kalibr", "rpng"}) {
    ExportInput input{c, &noise};
    input.options.imu_model = model;
    const YAML::Node imu = yaml_of(exported("openvins", input))["imu0"];
    EXPECT_EQ(imu["model"].as<std::string>(), model);
    // rpng/open_vins, ov_msckf/src/core/VioManagerOptions.h: D = T^-1, of which vec_dw and vec_da keep the lower triangle (kalibr) or the upper
    // (rpng); R_IMUtoACC is not estimated in the first, R_IMUtoGYRO not in the second; ov_msckf/src/state/Propagator.cpp corrects.
    const auto kept = [&](const Matrix3d& D) {
      return model == "kalibr" ? Matrix3d(D.triangularView<Eigen::Lower>()) : Matrix3d(D.triangularView<Eigen::Upper>());
    };
    const Matrix3d Dw = kept(matrix_of(imu["Tw"]).inverse()), Da = kept(matrix_of(imu["Ta"]).inverse()), Tg = matrix_of(imu["Tg"]);
    const Matrix3d R_GYROtoIMU = matrix_of(imu["R_IMUtoGYRO"]).transpose(), R_ACCtoIMU = matrix_of(imu["R_IMUtoACC"]).transpose();
    EXPECT_TRUE((model == "kalibr" ? R_ACCtoIMU : R_GYROtoIMU) == Matrix3d(Matrix3d::Identity()));
    // I = C b is said in the head; here from the accelerometers, which both must share.
    const Matrix3d C_I_b = R_ACCtoIMU * Da * c.model.accel.matrix.inverse();
    EXPECT_LT((C_I_b * C_I_b.transpose() - Matrix3d::Identity()).norm(), double_rounding) << "a rotation and nothing else";
    const RandomStream random(3, "openvins");
    Worst worst;
    for (int i = 0; i < samples; ++i) {
      const Reading r = random_reading(c.model, random, static_cast<std::uint64_t>(i));
      const Vector3d a_I = R_ACCtoIMU * Da * (r.raw.accel - bias_of(c.model.accel));
      const Vector3d w_I = R_GYROtoIMU * Dw * (r.raw.gyro - bias_of(c.model.gyro) - Tg * a_I);
      worst.add({a_I, w_I}, {C_I_b * r.compensated.force, C_I_b * r.compensated.rate});
    }
    EXPECT_LT(worst.force, double_rounding) << model;
    EXPECT_LT(worst.rate, double_rounding) << model;
  }
}

TEST(ExportTargets, OpenVinsPriorIsTheSpreadOfItsStates) {
  Calibration c = si_unit(7);
  c.estimated = select_each({"accel.matrix", "gyro.matrix", "gyro.g_sensitivity"});
  const auto n = static_cast<Eigen::Index>(c.estimated.size());
  Eigen::VectorXd sigma(n);
  for (Eigen::Index i = 0; i < n; ++i) sigma[i] = 1e-5 * (1 + static_cast<double>(i % 5));
  c.covariance = sigma.cwiseAbs2().asDiagonal();
  const ImuNoise noise = some_noise();
  const std::string text = exported("openvins", {c, &noise});
  // Calibrations drawn from the covariance, each exported: the spread of the first element of Dw, of Da's second and of Tg's last.
  const RandomStream random(4, "draws");
  constexpr int draws = 400;
  Eigen::Array3d sum = Eigen::Array3d::Zero(), squares = Eigen::Array3d::Zero();
  for (int k = 0; k < draws; ++k) {
    Calibration drawn = c;
    for (Eigen::Index i = 0; i < n; ++i) {
      const CoefficientIndex index = c.estimated[static_cast<std::size_t>(i)];
      set_coefficient(drawn.model, index, coefficient_value(c.model, index) + sigma[i] * random.normal(static_cast<std::uint64_t>(k * n + i)));
    }
    drawn.estimated.clear();
    drawn.covariance.resize(0, 0);
    const YAML::Node imu = yaml_of(exported("openvins", {drawn, &noise}))["imu0"];
    const Eigen::Array3d v(matrix_of(imu["Tw"]).inverse()(0, 0), matrix_of(imu["Ta"]).inverse()(1, 0), matrix_of(imu["Tg"])(2, 2));
    sum += v;
    squares += v.square();
  }
  const Eigen::Array3d spread = ((squares - sum.square() / draws) / (draws - 1)).sqrt();
  const auto stated = [&](const std::string& name, int k) {
    std::istringstream line(text.substr(text.find("#   " + name + ":") + name.size() + 5));
    double value = 0;
    for (int i = 0; i <= k; ++i) line >> value;
    return value;
  };
  // 400 draws tell a standard deviation to 3.5 %; two digits are written, 5 % at worst. Four sigma of the first and the rounding.
  EXPECT_NEAR(stated("vec_dw", 0) / spread[0], 1, 0.19);
  EXPECT_NEAR(stated("vec_da", 1) / spread[1], 1, 0.19);
  EXPECT_NEAR(stated("vec_tg", 8) / spread[2], 1, 0.19);
}

TEST(ExportTargets, VinsPropagatesTheVarianceOfTheNoise) {
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  for (const bool matched : {false, true}) {
    ExportInput input{c, &noise};
    input.options.variance_matched = matched;
    const YAML::Node vins = yaml_of(exported("vins", input));
    // HKUST-Aerial-Robotics/VINS-Fusion, vins_estimator/src/factor/integration_base.h: noise = diag(acc_n^2, gyr_n^2, acc_n^2, gyr_n^2, acc_w^2,
    // gyr_w^2) for the two samples of a step; V has 0.5 dt I for each sample in velocity and angle, dt I for the biases; P <- F P F' + V noise V'.
    constexpr double dt = 0.005;
    double velocity = 0, angle = 0, accel_bias = 0, gyro_bias = 0;
    constexpr int steps = 400;
    for (int i = 0; i < steps; ++i) {
      velocity += 2 * std::pow(0.5 * dt * vins["acc_n"].as<double>(), 2);
      angle += 2 * std::pow(0.5 * dt * vins["gyr_n"].as<double>(), 2);
      accel_bias += std::pow(dt * vins["acc_w"].as<double>(), 2);
      gyro_bias += std::pow(dt * vins["gyr_w"].as<double>(), 2);
    }
    const double time = steps * dt, share = matched ? 1 : 0.5;
    EXPECT_NEAR(velocity / (1.5e-3 * 1.5e-3 * time), share, 1e-9);
    EXPECT_NEAR(angle / (1.5e-4 * 1.5e-4 * time), share, 1e-9);
    EXPECT_NEAR(accel_bias / (7.5e-5 * 7.5e-5 * time), 1, 1e-9);
    EXPECT_NEAR(gyro_bias / (4e-6 * 4e-6 * time), 1, 1e-9);
  }
}

TEST(ExportTargets, RosCovariancesAreThoseOfSamplesOfEachAxis) {
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  const YAML::Node ros = yaml_of(exported("ros", {c, &noise}));
  for (std::size_t i = 0; i < 9; ++i) {
    const double k = 1 + 0.25 * static_cast<double>(i / 4);
    EXPECT_NEAR(ros["linear_acceleration_covariance"][i].as<double>(), i % 4 == 0 ? std::pow(1e-3 * k, 2) * 200 : 0, 1e-12 * 2e-4);
    EXPECT_NEAR(ros["angular_velocity_covariance"][i].as<double>(), i % 4 == 0 ? std::pow(1e-4 * k, 2) * 200 : 0, 1e-12 * 2e-6);
  }
  EXPECT_EQ(ros["orientation_covariance"][0].as<double>(), -1);
}

using Parameters = std::map<std::string, float>;

Parameters parameters_of(const std::string& text, bool px4) {
  Parameters out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    for (char& c : line)
      if (c == ',') c = ' ';
    std::istringstream words(line);
    std::string vehicle, component, name, value;
    if (px4) words >> vehicle >> component;
    words >> name >> value;
    EXPECT_TRUE(out.try_emplace(name, std::stof(value)).second) << name;
  }
  return out;
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
  return {a.cast<double>(), w.cast<double>()};
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
  return {a.cast<double>(), (tcal_correct(p, "GYR", t, raw.gyro.cast<float>()) - xyz("INS_GYROFFS")).cast<double>()};
}

/// What an autopilot holds: diagonal accelerometers, gyros without scale.
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
    for (int i = 0; i < samples; ++i) {
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
  for (int i = 0; i < samples; ++i) {
    const Reading r = random_reading(c.model, random, static_cast<std::uint64_t>(i));
    worst.add({v.C[0] * (r.raw.accel - v.B[0]), v.C[1] * (r.raw.gyro - v.B[1])}, r.compensated);  // VN-100 user manual, registers 25 and 84
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
  for (int i = 0; i < samples; ++i) {
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
    worst.add({a, triad(json["gyros"], r.raw.gyro, matrix(json["gyros"]["g_sensitivity"]) * a)}, r.compensated);
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
    EXPECT_EQ(std::stod(rows.at(std::string(coefficient(i).name))[0]), coefficient_value(c.model, i));
  EXPECT_EQ(std::stod(rows.at("gyro.matrix.xy")[1]), 2e-6);
  EXPECT_EQ(rows.at("accel.offset.x")[1], "");
  EXPECT_EQ(std::stod(rows.at("noise.gyro.K")[0]), 4e-6);
  EXPECT_EQ(std::stod(rows.at("accel.temperature.reference")[0]), 5022.5);
}

}  // namespace
}  // namespace imulab::export_test
