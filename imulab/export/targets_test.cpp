// Every target's file, read back and put into the equation of its consumer, does what `compensate` does, as far as the target holds it; what is said
// to be lost is what is lost.
#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/export/consumer_model.hpp"
#include "imulab/export/loss.hpp"

#include <Eigen/LU>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/export_unit.hpp"
#include <limits>
#include <map>
#include <regex>
#include <sstream>
#include <yaml-cpp/yaml.h>

namespace imulab::export_test {
namespace {

using export_io::consumer_model;
using ::testing::HasSubstr;

constexpr int samples = 10000;

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
    worst.add({.rate = w_b, .force = a_b}, r.compensated);
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
  for (const char* target :
       {"kalibr-imu", "kalibr", "openvins", "vins", "euroc", "ros", "ros-filter", "orb-slam3", "lio-sam", "fast-lio", "kf-gins"}) {
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
    EXPECT_GE(numbers, std::string_view(target) == "ros-filter" ? 3 : 4) << target;
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
      worst.add({.rate = w_I, .force = a_I}, {.rate = C_I_b * r.compensated.rate, .force = C_I_b * r.compensated.force});
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

/// The numbers of a line of the prior; NaN where it says nan.
std::vector<double> prior_line(const std::string& text, const std::string& name) {
  std::istringstream line(text.substr(text.find("#   " + name + ":") + name.size() + 5));
  std::string rest;
  std::getline(line, rest);
  std::istringstream words(rest);
  std::vector<double> out;
  for (std::string word; words >> word;) out.push_back(word == "nan" ? std::numeric_limits<double>::quiet_NaN() : std::stod(word));
  return out;
}

TEST(ExportTargets, OpenVinsRotationPriorIsInTheImuFrame) {
  // Gyros whose axes are the body's in another order: frames of gyros and IMU differ by a cyclic rotation.
  Calibration c = si_unit(8);
  Matrix3d cyclic;
  cyclic << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  c.model.accel.matrix.setIdentity();
  c.model.gyro.matrix = cyclic;
  c.estimated = select_each({"accel.matrix", "gyro.matrix", "gyro.g_sensitivity"});
  const auto n = static_cast<Eigen::Index>(c.estimated.size());
  const ImuNoise noise = some_noise();
  // One element is uncertain that turns the gyros and does not only shear them: above the diagonal of T Q^T = -T dC for "kalibr", below for "rpng".
  for (const auto& [model, element] : {std::pair<std::string, const char*>{"kalibr", "gyro.matrix.yz"}, {"rpng", "gyro.matrix.xy"}}) {
    const CoefficientIndex uncertain = coefficient_index(element);
    const auto at = std::find(c.estimated.begin(), c.estimated.end(), uncertain) - c.estimated.begin();
    c.covariance = Eigen::MatrixXd::Identity(n, n) * 1e-20;
    c.covariance(at, at) = 1e-6;
    ExportInput input{c, &noise};
    input.options.imu_model = model;
    const std::string key = model == "rpng" ? "R_IMUtoACC" : "R_IMUtoGYRO", name = model == "rpng" ? "R_ACCtoIMU [rad]" : "R_GYROtoIMU [rad]";
    const auto rotation = [&](double change) {  // R_GYROtoIMU or R_ACCtoIMU of the file
      Calibration other = c;
      set_coefficient(other.model, uncertain, coefficient_value(c.model, uncertain) + change);
      ExportInput changed{other, &noise, input.options};
      return Matrix3d(matrix_of(yaml_of(exported("openvins", changed))["imu0"][key]).transpose());
    };
    // JPLQuat::update: R_new = (1 - [theta x]) R_old, by differences; the sigma of the element is 1e-3
    const Matrix3d step = (rotation(1e-6) - rotation(-1e-6)) * rotation(0).transpose() / 2e-6;
    const std::vector<double> stated = prior_line(exported("openvins", input), name);
    ASSERT_EQ(stated.size(), 3u);
    const Vector3d theta(step(1, 2), step(2, 0), step(0, 1));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(stated[static_cast<std::size_t>(k)], 1e-3 * std::abs(theta[k]), 2e-5) << model << " " << k;  // two digits
    EXPECT_GT(theta.norm(), 0.1) << model;
    EXPECT_GT(std::abs(theta.maxCoeff() - theta.minCoeff()), 0.1) << model << ": the axes can be told apart";
  }
}

TEST(ExportTargets, OpenVinsPriorNamesWhatWasNotEstimated) {
  Calibration c = si_unit(9);
  c.estimated = select_each({"gyro.matrix"});
  c.covariance = Eigen::MatrixXd::Identity(9, 9) * 1e-10;
  const ImuNoise noise = some_noise();
  const std::string text = exported("openvins", {c, &noise});
  for (const double sigma : prior_line(text, "vec_dw")) EXPECT_NEAR(sigma, 1e-5, 5e-6);  // the gyros' own matrix: known
  for (const char* name : {"vec_da", "vec_tg", "R_GYROtoIMU [rad]"})  // depend on the accelerometers' matrix, or on the g-sensitivity
    for (const double sigma : prior_line(text, name)) EXPECT_TRUE(std::isnan(sigma)) << name;
  // In the accelerometers' frame their matrix is triangular by definition: nothing of it is missing.
  c.frame = BodyFrame::accelerometers;
  c.model.accel.matrix = Matrix3d(c.model.accel.matrix.triangularView<Eigen::Lower>());
  c.estimated = select_each({"gyro.matrix", "gyro.g_sensitivity"});
  for (const CoefficientIndex i : select_each({"accel.matrix"}))
    if (coefficient(i).row >= coefficient(i).column) c.estimated.push_back(i);
  c.covariance = Eigen::MatrixXd::Identity(24, 24) * 1e-10;
  for (const char* name : {"vec_dw", "vec_da", "vec_tg", "R_GYROtoIMU [rad]"})
    for (const double sigma : prior_line(exported("openvins", {c, &noise}), name)) EXPECT_NEAR(sigma, 1e-5, 6e-6) << name;
  // Coefficients that the data did not determine are not known, whatever the covariance says.
  c.quality.unobservable = {"gyro.g_sensitivity.xx"};
  const std::vector<double> tg = prior_line(exported("openvins", {c, &noise}), "vec_tg");
  EXPECT_TRUE(std::isnan(tg[0]));
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

/// CCNYRoboticsLab/imu_tools, imu_filter.cpp, madgwickAHRSupdateIMU: the orientation's rate is q w / 2 less gain times a unit quaternion.
TEST(ExportTargets, TheRosFiltersGainHoldsTheGyrosError) {
  Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  for (const char* axis : {"x", "y", "z"}) c.estimated.push_back(coefficient_index(std::string("gyro.offset.") + axis));
  c.covariance = Eigen::MatrixXd::Zero(3, 3);
  c.covariance.diagonal() << 1e-8, 4e-8, 1e-8;
  const auto parameters = [&] { return yaml_of(exported("ros-filter", {c, &noise}))["/**"]["ros__parameters"]; };
  // N of the worst axis 1.5e-4 at 200 Hz, B not known, three times 2e-4 rad/s of offset
  const double error = 1.5e-4 * std::sqrt(200) + 3 * 2e-4;
  const double gain = parameters()["gain"].as<double>();
  EXPECT_NEAR(0.5 * std::sqrt(3 * error * error) / gain, 1, 1e-12) << "the same error on all axes turns the quaternion at half its length";
  EXPECT_FALSE(parameters()["use_mag"].as<bool>());
  EXPECT_TRUE(parameters()["do_bias_estimation"].as<bool>()) << "samples at rest differ by 3e-3 rad/s: less than a third of the filter's 0.01";
  c.covariance(1, 1) = 1;  // rad^2/s^2
  EXPECT_THAT([&] { parameters(); }, testing::ThrowsMessage<Error>(testing::HasSubstr("it takes at most 1")));
  c.estimated.clear(), c.covariance.resize(0, 0);
  EXPECT_NEAR(parameters()["gain"].as<double>(), std::sqrt(0.75) * 1.5e-4 * std::sqrt(200), 1e-15);
  EXPECT_THAT(exported("ros-filter", {c, &noise}), testing::HasSubstr("the offset's uncertainty is not known"));
  ImuNoise loud = noise;
  loud.gyro[2]->N = determined(2e-3);
  EXPECT_FALSE(yaml_of(exported("ros-filter", {c, &loud}))["/**"]["ros__parameters"]["do_bias_estimation"].as<bool>());
}

}  // namespace
}  // namespace imulab::export_test
