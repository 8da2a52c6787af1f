// The noise that consumers make of their files: each one's equation, as in its source, adds N^2 T to the variance of angle and velocity over a time
// T, and K^2 T to that of a bias.
#include "imulab/error.hpp"
#include "imulab/export/consumer_model.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/noise/bound.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/export_unit.hpp"
#include <cmath>
#include <complex>
#include <yaml-cpp/yaml.h>

namespace imulab::export_test {
namespace {

using ::testing::HasSubstr;

constexpr double rate_hz = 200, dt = 1 / rate_hz;  // of some_noise()
constexpr int steps = 2000;
constexpr double T = steps * dt;

/// The worst axes of some_noise(); the gyros' K is a bound.
constexpr double gyro_N = 1.5e-4, gyro_K = 4e-6, accel_N = 1.5e-3, accel_K = 7.5e-5;

std::string noise_file(const char* target) {
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  return exported(target, {c, &noise});
}

YAML::Node noise_yaml(const char* target) {
  std::string text = noise_file(target);
  if (text.starts_with("%YAML:1.0")) text[0] = '#';
  return YAML::Load(text);
}

/// Variances that a filter states after T.
struct Stated {
  double velocity = 0, angle = 0, accel_bias = 0, gyro_bias = 0;
};
void expect_right(const Stated& stated, const char* target, double tolerance) {
  EXPECT_NEAR(stated.velocity / (accel_N * accel_N * T), 1, tolerance) << target;
  EXPECT_NEAR(stated.angle / (gyro_N * gyro_N * T), 1, tolerance) << target;
  EXPECT_NEAR(stated.accel_bias / (accel_K * accel_K * T), 1, tolerance) << target;
  EXPECT_NEAR(stated.gyro_bias / (gyro_K * gyro_K * T), 1, tolerance) << target;
}

/// gtsam 4.2, ImuFactor.cpp: B (accelerometerCovariance / dt) B^T with B = dt for the velocity; CombinedImuFactor.cpp: biasAccCovariance dt.
Stated stated_by_gtsam(double acc, double gyro, double bias_acc, double bias_omega) {
  Stated out;
  for (int i = 0; i < steps; ++i) {
    out.velocity += dt * (acc / dt) * dt, out.angle += dt * (gyro / dt) * dt;
    out.accel_bias += bias_acc * dt, out.gyro_bias += bias_omega * dt;
  }
  return out;
}

TEST(ExportConsumers, GtsamHasEveryAxis) {
  const std::string text = noise_file("gtsam");
  const ImuNoise noise = some_noise();
  const auto acc = numbers_after(text, "params.setAccelerometerCovariance(gtsam::Vector3(", 3),
             gyro = numbers_after(text, "params.setGyroscopeCovariance(gtsam::Vector3(", 3),
             bias_acc = numbers_after(text, "params.setBiasAccCovariance(gtsam::Vector3(", 3),
             bias_omega = numbers_after(text, "params.setBiasOmegaCovariance(gtsam::Vector3(", 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const Stated stated = stated_by_gtsam(acc[i], gyro[i], bias_acc[i], bias_omega[i]);
    EXPECT_NEAR(stated.velocity / (std::pow(noise.accel[i]->N.value, 2) * T), 1, 1e-10);
    EXPECT_NEAR(stated.angle / (std::pow(noise.gyro[i]->N.value, 2) * T), 1, 1e-10);
    EXPECT_NEAR(stated.accel_bias / (std::pow(noise.accel[i]->K.value, 2) * T), 1, 1e-10);
    EXPECT_NEAR(stated.gyro_bias / (std::pow(noise.gyro[i]->K.determined ? noise.gyro[i]->K.value : noise.gyro[i]->K.upper, 2) * T), 1, 1e-10);
  }
  EXPECT_THAT(text, HasSubstr("// Holds: noise in CONTINUOUS time"));
}

/// LIO-SAM 0be1fbe, imuPreintegration.cpp: floats; squares into GTSAM; a BetweenFactor of sqrt(T) imuAccBiasN.
TEST(ExportConsumers, LioSam) {
  const YAML::Node y = noise_yaml("lio-sam")["lio_sam"];
  const auto value = [&](const char* key) { return static_cast<double>(y[key].as<float>()); };
  Stated stated = stated_by_gtsam(std::pow(value("imuAccNoise"), 2), std::pow(value("imuGyrNoise"), 2), 0, 0);
  stated.accel_bias = std::pow(std::sqrt(T) * value("imuAccBiasN"), 2), stated.gyro_bias = std::pow(std::sqrt(T) * value("imuGyrBiasN"), 2);
  expect_right(stated, "lio-sam", 1e-6);
}

/// ORB-SLAM3 1.0: Tracking.cc, IMU::Calib(Tbc, Ng sf, Na sf, Ngw / sf, Naw / sf) with sf = sqrt(IMU.Frequency); ImuTypes.cc, B Nga B^T with B = dt,
/// and NgaWalk added at every sample. Floats.
TEST(ExportConsumers, OrbSlam3) {
  const YAML::Node y = noise_yaml("orb-slam3");
  const auto value = [&](const char* key) { return y[key].as<float>(); };
  const float sf = std::sqrt(value("IMU.Frequency"));
  const double ng = value("IMU.NoiseGyro") * sf, na = value("IMU.NoiseAcc") * sf, ngw = value("IMU.GyroWalk") / sf, naw = value("IMU.AccWalk") / sf;
  Stated stated;
  for (int i = 0; i < steps; ++i) {
    stated.velocity += dt * na * na * dt, stated.angle += dt * ng * ng * dt;
    stated.accel_bias += naw * naw, stated.gyro_bias += ngw * ngw;
  }
  expect_right(stated, "orb-slam3", 1e-6);
}

/// FAST_LIO 7cc4175: esekfom.hpp, P += (dt f_w) Q (dt f_w)^T with acc_cov, gyr_cov, b_acc_cov and b_gyr_cov on Q's diagonal.
TEST(ExportConsumers, FastLio) {
  const YAML::Node y = noise_yaml("fast-lio")["mapping"];
  const auto value = [&](const char* key) { return y[key].as<double>(); };
  Stated stated;
  for (int i = 0; i < steps; ++i) {
    stated.velocity += dt * value("acc_cov") * dt, stated.angle += dt * value("gyr_cov") * dt;
    stated.accel_bias += dt * value("b_acc_cov") * dt, stated.gyro_bias += dt * value("b_gyr_cov") * dt;
  }
  expect_right(stated, "fast-lio", 1e-10);
  EXPECT_THAT(noise_file("fast-lio"), HasSubstr("DISCRETE values at 200 Hz"));
}

/// GLIM 1007fec: imu_integration.cpp, squares into GTSAM; odometry_estimation_imu.cpp, a BetweenFactor of imu_bias_noise from scan to scan. Its
/// config.cpp parses JSON with comments.
TEST(ExportConsumers, Glim) {
  const nlohmann::json y = nlohmann::json::parse(noise_file("glim"), nullptr, true, true)["sensors"];
  Stated stated = stated_by_gtsam(std::pow(y["imu_acc_noise"].get<double>(), 2), std::pow(y["imu_gyro_noise"].get<double>(), 2), 0, 0);
  constexpr double scans = 10 * T;  // 10 Hz
  stated.accel_bias = scans * std::pow(y["imu_bias_noise"].get<double>(), 2);
  stated.gyro_bias = gyro_K * gyro_K * T;  // one number holds the larger walk alone
  expect_right(stated, "glim", 1e-10);
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  EXPECT_THAT(export_target("glim").warnings({c, &noise}), testing::ElementsAre(HasSubstr("the biases of the gyros change 19 times as fast")));
}

/// KF-GINS f39bc2e: kf_gins.cpp, units of loadConfig; gi_engine.cpp, Qc with 2 std^2 / corr_time, Phi = 1 + F dt, Qd = (Phi Q Phi^T + Q) dt / 2.
TEST(ExportConsumers, KfGins) {
  const YAML::Node y = noise_yaml("kf-gins"), n = y["imunoise"];
  constexpr double D2R = M_PI / 180;
  const double corr_time = n["corrtime"].as<double>() * 3600;
  const ImuNoise noise = some_noise();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = [&](const char* key) { return n[key].as<std::vector<double>>().at(i); };
    const double arw = value("arw") * D2R / 60, vrw = value("vrw") / 60, gbstd = value("gbstd") * D2R / 3600, abstd = value("abstd") * 1e-5;
    Stated stated;
    const auto propagate = [](double& variance, double Qc, double decay) {
      const double Phi = 1 - decay * dt, Qd = (Phi * Qc * Phi + Qc) * dt / 2;
      variance = Phi * variance * Phi + Qd;
    };
    for (int k = 0; k < steps; ++k) {
      propagate(stated.angle, arw * arw, 0), propagate(stated.velocity, vrw * vrw, 0);
      propagate(stated.gyro_bias, 2 / corr_time * gbstd * gbstd, 1 / corr_time);
      propagate(stated.accel_bias, 2 / corr_time * abstd * abstd, 1 / corr_time);
    }
    const double K_g = noise.gyro[i]->K.determined ? noise.gyro[i]->K.value : noise.gyro[i]->K.upper;
    EXPECT_NEAR(stated.angle / (std::pow(noise.gyro[i]->N.value, 2) * T), 1, 1e-10);
    EXPECT_NEAR(stated.velocity / (std::pow(noise.accel[i]->N.value, 2) * T), 1, 1e-10);
    EXPECT_NEAR(stated.gyro_bias / (K_g * K_g * T), 1, 2 * T / corr_time) << "the process decays";
    EXPECT_NEAR(stated.accel_bias / (std::pow(noise.accel[i]->K.value, 2) * T), 1, 2 * T / corr_time);
    for (const char* key : {"initgyrbias", "initaccbias", "initgyrscale", "initaccscale"})
      EXPECT_EQ(y[key].as<std::vector<double>>().at(i), 0) << key;
    EXPECT_DOUBLE_EQ(value("gsstd"), 10000) << "of grade mems: this calibration has no uncertainties";
  }
}

/// insEKF, as its documentation has it: a reading is fused with the covariance of a sample, here summed as the increments of T; the bias's variance
/// grows by AdditiveProcessNoise per second.
TEST(ExportConsumers, MatlabFusesTheNoise) {
  const std::string text = noise_file("matlab-ins");
  const ImuNoise noise = some_noise();
  const auto white = numbers_after(text, "measurementNoise.GyroscopeNoise = [", 3),
             walk = numbers_after(text, "filter.AdditiveProcessNoise(states.Accelerometer_Bias, states.Accelerometer_Bias) = diag([", 3);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(white[i] * dt * dt * steps / (std::pow(noise.gyro[i]->N.value, 2) * T), 1, 1e-10);
    EXPECT_NEAR(walk[i] / std::pow(noise.accel[i]->K.value, 2), 1, 1e-10);
  }
}

/// depthai-core ca7d6dea1: BasaltVIO.cpp, the root of each number; basalt-headers, calibration.hpp: times the root of the rate; preintegration.h: a
/// sample's covariance times dt^2.
TEST(ExportConsumers, Oak) {
  const std::string text = noise_file("oak");
  const ImuNoise noise = some_noise();
  const auto accel = numbers_after(text, "vio.setAccelNoiseStd([", 3), gyro = numbers_after(text, "vio.setGyroNoiseStd([", 3);
  EXPECT_THAT(text, HasSubstr("vio.setImuUpdateRate(200)"));
  for (std::size_t i = 0; i < 3; ++i) {
    const double accel_d = std::sqrt(accel[i]) * std::sqrt(rate_hz), gyro_d = std::sqrt(gyro[i]) * std::sqrt(rate_hz);
    EXPECT_NEAR(steps * dt * dt * accel_d * accel_d / (std::pow(noise.accel[i]->N.value, 2) * T), 1, 1e-10);
    EXPECT_NEAR(steps * dt * dt * gyro_d * gyro_d / (std::pow(noise.gyro[i]->N.value, 2) * T), 1, 1e-10);
  }
  const Calibration c = si_unit();
  EXPECT_THAT(export_target("oak").left_out({c, &noise}), testing::Contains(HasSubstr("accelerometers' K, random walk")));
}

/// gz-sensors, GaussianNoiseModel.cc: b = exp(-dt / tau) b + N(0, sqrt(-s^2 tau / 2 expm1(-2 dt / tau))).
TEST(ExportConsumers, GazeboSimulatesTheNoise) {
  const std::string text = noise_file("gazebo");
  const ImuNoise noise = some_noise();
  const std::size_t gyros = text.find("<angular_velocity>"), accelerometers = text.find("<linear_acceleration>");
  for (std::size_t i = 0; i < 3; ++i)
    for (const bool gyro : {true, false}) {
      const std::string axis = text.substr(text.find(fmt::format("<{}>", "xyz"[i]), gyro ? gyros : accelerometers));
      const double white = numbers_after(axis, "<stddev>", 1)[0], s = numbers_after(axis, "<dynamic_bias_stddev>", 1)[0],
                   tau = numbers_after(axis, "<dynamic_bias_correlation_time>", 1)[0];
      double bias = 0;
      for (int k = 0; k < steps; ++k) bias = std::exp(-2 * dt / tau) * bias - s * s * tau / 2 * std::expm1(-2 * dt / tau);
      const NoiseCoefficients& truth = gyro ? *noise.gyro[i] : *noise.accel[i];
      EXPECT_NEAR(white * white * dt / std::pow(truth.N.value, 2), 1, 1e-10);
      EXPECT_NEAR(bias / (std::pow(truth.K.determined ? truth.K.value : truth.K.upper, 2) * T), 1, 2e-4) << "T / tau";
    }
  EXPECT_EQ(text.find("--", 4), text.find("-->")) << "XML has no -- in a comment";
}

/// imuSensor, single-sided: a sample has NoiseDensity sqrt(Fs), a step of the walk RandomWalk / sqrt(Fs); the bias instability is white noise through
/// Kasdin's filter 1 / (1 + a_1 z^-1 + ...), a_k = (k - 3/2) a_(k-1) / k.
TEST(ExportConsumers, MatlabSimulatesTheNoise) {
  const Calibration c = si_unit();
  ImuNoise noise = some_noise();
  for (std::size_t i = 0; i < 3; ++i) noise.gyro[i]->B = determined(3e-5), noise.accel[i]->B = determined(4e-4);
  const std::string text = exported("matlab", {c, &noise});
  EXPECT_THAT(text, HasSubstr("imuSensor('accel-gyro', 'SampleRate', 200.0);"));
  EXPECT_THAT(export_target("matlab").left_out({c, &noise}), testing::Each(testing::Not(HasSubstr("noise:")))) << "it has N, B and K";
  const std::string gyro = text.substr(text.find("imu.Gyroscope"));
  for (std::size_t i = 0; i < 3; ++i) {
    const double white = numbers_after(gyro, "'NoiseDensity', [", 3)[i] * std::sqrt(rate_hz),
                 step = numbers_after(gyro, "'RandomWalk', [", 3)[i] / std::sqrt(rate_hz);
    EXPECT_NEAR(white * white * dt / std::pow(noise.gyro[i]->N.value, 2), 1, 1e-10);
    EXPECT_NEAR(step * step * steps / (std::pow(noise.gyro[i]->K.determined ? noise.gyro[i]->K.value : noise.gyro[i]->K.upper, 2) * T), 1, 1e-10);
  }
  const double B = numbers_after(gyro, "'BiasInstability', [", 3)[0];
  EXPECT_THAT(gyro, HasSubstr("fractalcoef(2000)"));
  for (const double hz : {0.5, 1.0, 5.0}) {
    std::complex<double> sum = 1;
    double a = 1;
    for (int k = 1; k <= 2000; ++k) a *= (k - 1.5) / k, sum += a * std::polar(1.0, -2 * M_PI * hz * dt * k);
    EXPECT_NEAR(B * B * dt / std::norm(sum) / (std::pow(3e-5, 2) / (2 * M_PI * hz)), 1, 0.05) << hz;  // ripple of the cut filter
  }
}

/// b' = F b + w has the spectrum T Q / |1 - F exp(-i 2 pi f T)|^2; a reading's white noise R has T R.
TEST(ExportConsumers, StatesOfAFilterHaveTheSpectrumOfTheBound) {
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  const auto filter = nlohmann::json::parse(exported("filter", {c, &noise}));
  EXPECT_EQ(filter["rate_hz"], rate_hz);
  const NoiseBound& bound = *noise.accel[1]->bound;
  ASSERT_FALSE(bound.markov.empty());
  for (const double hz : {1e-3, 0.02, 1.0, 70.0}) {
    double sum = dt * filter["R"][4].get<double>();
    for (std::size_t i = 0; i < filter["states"].size(); ++i)
      if (filter["states"][i]["axis"] == "accel.y")
        sum += dt * filter["Q"][i].get<double>() / std::norm(1.0 - filter["F"][i].get<double>() * std::polar(1.0, -2 * M_PI * hz * dt));
    EXPECT_NEAR(sum / noise::density(bound, hz, dt), 1, 1e-9) << hz;
    EXPECT_GE(sum, 0.98 * noise::at_frequencies(bound.upper, {hz})[0].density) << hz;
  }
  double start = 0;
  for (std::size_t i = 0; i < filter["states"].size(); ++i)
    if (filter["states"][i]["axis"] == "accel.y" && filter["states"][i]["kind"] == "walk") start = filter["P0"][i];
  EXPECT_NEAR(start, bound.start_sigma * bound.start_sigma, 1e-12 * start);
  EXPECT_THAT(exported("filter-c", {c, &noise}), HasSubstr(fmt::format("#define IMULAB_FILTER_STATES {}\n", filter["states"].size())));
}

/// As in the test KfGins: b' = (1 - dt / T) b + w, var w = (Phi Q Phi + Q) dt / 2.
TEST(ExportConsumers, KfGinsHasOneProcessAboveAllBounds) {
  const Calibration c = si_unit();
  const ImuNoise noise = some_noise();
  const std::string text = exported("kf-gins", {c, &noise, {.bound = true}});
  EXPECT_THAT(text, testing::AllOf(HasSubstr("are BOUNDS"), HasSubstr("processes that together with N")));
  const YAML::Node n = YAML::Load(text)["imunoise"];
  const double T = n["corrtime"].as<double>() * 3600, Phi = 1 - dt / T;
  double least = INFINITY;
  const auto expect_above = [&](const NoiseBound& bound, double N, double sigma) {
    const double q = 2 / T * sigma * sigma, w = (Phi * q * Phi + q) * dt / 2;
    for (const UpperDensity& u : bound.upper) {
      const double ratio = (N * N + dt * w / std::norm(1.0 - std::polar(Phi, -2 * M_PI * u.hz * dt))) / u.density;
      EXPECT_GE(ratio, 1 - 0.1 * dt / T - 1e-6) << u.hz << " Hz, " << T << " s";
      least = std::min(least, ratio);
    }
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = [&](const char* key) { return n[key].as<std::vector<double>>().at(i); };
    expect_above(*noise.gyro[i]->bound, value("arw") * M_PI / 180 / 60, value("gbstd") * M_PI / 180 / 3600);
    expect_above(*noise.accel[i]->bound, value("vrw") / 60, value("abstd") * 1e-5);
  }
  EXPECT_NEAR(least, 1, 1e-3) << "none is tight";
}

TEST(ExportConsumers, BoundsAreAboveTheSpectrumAndFactorsAreSaid) {
  const Calibration c = si_unit();
  ImuNoise noise = some_noise();
  const YAML::Node y = YAML::Load(exported("kalibr-imu", {c, &noise, {.bound = true}}));
  const double N = y["accelerometer_noise_density"].as<double>(), K = y["accelerometer_random_walk"].as<double>();
  for (const auto& axis : noise.accel)
    for (const UpperDensity& u : axis->bound->upper) EXPECT_GE(noise::density({.N = N, .K = K}, u.hz, dt), 0.9999 * u.density) << u.hz;
  EXPECT_THAT(exported("kalibr-imu", {c, &noise, {.bound = true}}), HasSubstr("N and K are BOUNDS"));
  const YAML::Node plain = YAML::Load(exported("kalibr-imu", {c, &noise})), ten = YAML::Load(exported("kalibr-imu", {c, &noise, {.inflate = 10}}));
  EXPECT_NEAR(ten["gyroscope_noise_density"].as<double>() / plain["gyroscope_noise_density"].as<double>(), 10, 1e-12);
  EXPECT_THAT(exported("kalibr-imu", {c, &noise, {.inflate = 10}}), HasSubstr("MULTIPLIED by 10"));
  EXPECT_THROW(exported("kalibr-imu", {c, &noise, {.bound = true, .inflate = 10}}), Error);
  EXPECT_THROW(exported("kalibr-imu", {c, &noise, {.axes = AxisChoice::mean, .bound = true}}), Error);
  EXPECT_THROW(exported("kalibr-imu", {c, nullptr, {.bound = true}}), Error);
  noise.gyro[0]->bound.reset();
  EXPECT_THAT([&] { exported("kalibr-imu", {c, &noise, {.bound = true}}); }, testing::ThrowsMessage<Error>(HasSubstr("noise LOG --bound")));
}

}  // namespace
}  // namespace imulab::export_test
