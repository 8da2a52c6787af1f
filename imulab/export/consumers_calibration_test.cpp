// The calibration that DLIO, Fusion and RealSense apply is that of `compensate`, as far as they hold it. Files of a data sheet say that they are, and
// those of one triad lack the other.
#include "imulab/error.hpp"
#include "imulab/export/consumer_model.hpp"
#include "imulab/export/loss.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/export_unit.hpp"
#include <limits>
#include <yaml-cpp/yaml.h>

namespace imulab::export_test {
namespace {

using ::testing::HasSubstr;

TEST(ExportConsumers, FilesOfADataSheetSayThatTheyAre) {
  const Calibration c = si_unit();
  ImuNoise noise = some_noise();
  noise.from_data_sheet = true;
  noise.recording = "ICM-42688-P";
  for (std::size_t i = 0; i < 3; ++i) {
    noise.gyro[i]->K = undetermined_below(4e-6), noise.gyro[i]->K.bounded = true;
    noise.gyro[i]->B = {3e-5, std::numeric_limits<double>::infinity(), 0, 3e-5, true, true};
    noise.accel[i]->N = {1e-3, std::numeric_limits<double>::infinity(), 0, std::numeric_limits<double>::infinity(), true};
  }
  for (const ExportTarget& target : export_targets()) {
    if (!target.needs_noise) continue;
    std::string text = target.text({c, &noise});
    std::erase(text, '\\');  // before quotation marks in JSON
    EXPECT_THAT(text, HasSubstr("Noise: values of a DATA SHEET, not fitted to a log: \"ICM-42688-P\".")) << target.name;
  }
  EXPECT_THAT(exported("lio-sam", {c, &noise}), HasSubstr("y <= 4e-06, z <= 4e-06; <=: not in the data sheet, bounded by what it states"));
  EXPECT_THAT(exported("matlab", {c, &noise}), HasSubstr("x <= 3e-05"));
  EXPECT_THAT(exported("matlab", {c, &noise}), HasSubstr("'BiasInstability', [0.0, 0.0, 0.0], ... % m/s^2: NOT MEASURED"));
  EXPECT_THAT(exported("csv", {c, &noise}), testing::Not(HasSubstr("inf.")));
  for (auto& axis : noise.gyro) axis->B = axis->K;
  EXPECT_THAT(exported("lio-sam", {c, &noise}), HasSubstr("z <= 4e-06; <=: not in the data sheet, ASSUMED: the sheet has no bias instability"));
  const nlohmann::json K = nlohmann::json::parse(exported("json-matrix", {c, &noise}))["noise"]["gyros"]["axes"][1]["K"];
  EXPECT_TRUE(K.contains("assumed") && !K.contains("bounded")) << K;
  noise.interval_s = 0;  // most sheets have no rate
  for (const char* target : {"gtsam", "lio-sam", "json-matrix", "csv"}) EXPECT_NO_THROW(exported(target, {c, &noise})) << target;
  EXPECT_THAT([&] { exported("fast-lio", {c, &noise}); }, testing::ThrowsMessage<Error>(HasSubstr("expected a rate: --stream-rate HZ")));
}

/// A calibration without the terms that the target does not hold.
Calibration held_unit(bool gyro_matrix) {
  Calibration c = si_unit(4);
  const Vector3d b_g = bias_of(c.model.gyro);
  if (!gyro_matrix) c.model.gyro.matrix.setIdentity(), c.model.gyro.offset = -b_g;
  c.model.g_sensitivity.setZero();
  return c;
}

/// odom.cc: (sm a_m) - bias and w_m - bias, floats.
TEST(ExportConsumers, DlioAppliesTheCalibration) {
  const Calibration c = held_unit(false);
  const YAML::Node y = YAML::Load(exported("dlio", {c}))["dlio"], imu = y["imu"]["intrinsics"];
  EXPECT_THAT(export_target("dlio").left_out({c}), testing::IsEmpty());
  EXPECT_FALSE(y["odom"]["imu"]["calibration"]["accel"].as<bool>());
  Eigen::Matrix3f sm;
  for (std::size_t i = 0; i < 9; ++i) sm(static_cast<int>(i / 3), static_cast<int>(i % 3)) = imu["accel"]["sm"][i].as<float>();
  const auto vector = [](const YAML::Node& n) { return Eigen::Vector3f(n[0].as<float>(), n[1].as<float>(), n[2].as<float>()); };
  const RandomStream random(2, "dlio");
  Worst worst;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const Reading r = random_reading(c.model, random, i);
    const Eigen::Vector3f a = sm * r.raw.accel.cast<float>() - vector(imu["accel"]["bias"]),
                          w = r.raw.gyro.cast<float>() - vector(imu["gyro"]["bias"]);
    worst.add({.rate = w.cast<double>(), .force = a.cast<double>()}, r.compensated);
  }
  EXPECT_LT(std::max(worst.force, worst.rate), 1e-6) << "single precision";
  EXPECT_THAT(export_target("dlio").left_out({si_unit()}), testing::Contains(HasSubstr("gyros")));
}

/// FusionModel.h: misalignment (sensitivity o (uncalibrated - offset)), floats.
TEST(ExportConsumers, FusionAppliesTheCalibration) {
  const Calibration c = held_unit(true);
  const std::string text = exported("fusion", {c});
  EXPECT_THAT(export_target("fusion").left_out({c}), testing::IsEmpty());
  const auto corrected = [&](const std::string& triad, const Vector3d& raw) {
    const auto m = numbers_after(text, triad + "Misalignment = {", 9), s = numbers_after(text, triad + "Sensitivity = {", 3),
               o = numbers_after(text, triad + "Offset = {", 3);
    Eigen::Vector3f out = Eigen::Vector3f::Zero();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const auto k = static_cast<std::size_t>(j);
        out[i] += static_cast<float>(m[static_cast<std::size_t>(3 * i) + k]) *
                  ((static_cast<float>(raw[j]) - static_cast<float>(o[k])) * static_cast<float>(s[k]));
      }
    return Vector3d(out.cast<double>());
  };
  const RandomStream random(2, "fusion");
  Worst worst;
  for (std::uint64_t i = 0; i < 30; ++i) {
    const Reading r = random_reading(c.model, random, i);
    worst.add({.rate = corrected("gyroscope", r.raw.gyro) * unit::deg, .force = corrected("accelerometer", r.raw.accel) * unit::g}, r.compensated);
  }
  EXPECT_LT(std::max(worst.force, worst.rate), 1e-6) << "single precision";
}

/// librealsense cacc8e701: float3x3 has columns x, y, z; motion-transform.cpp, sensitivity * xyz - bias, floats. The tool's check_X multiplies a row
/// of readings by the same nine numbers as a matrix by rows.
TEST(ExportConsumers, RealSenseAppliesTheCalibration) {
  const Calibration c = held_unit(true);
  const nlohmann::json imu = nlohmann::json::parse(exported("realsense", {c}))["imus"][0];
  EXPECT_THAT(export_target("realsense").left_out({c}), testing::IsEmpty());
  const auto corrected = [&](const char* triad, const Vector3d& raw) {
    const auto m = imu[triad]["scale_and_alignment"].get<std::vector<float>>(), bias = imu[triad]["bias"].get<std::vector<float>>();
    Eigen::Vector3f out = Eigen::Vector3f::Zero();
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) out[i] += m[static_cast<std::size_t>(3 * j + i)] * static_cast<float>(raw[j]);  // column j times reading j
    const Eigen::RowVector3f of_tool = raw.cast<float>().transpose() * Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(m.data());
    EXPECT_LT((of_tool.transpose() - out).norm(), 1e-5 * out.norm());
    return Vector3d((out - Eigen::Map<const Eigen::Vector3f>(bias.data())).cast<double>());
  };
  const RandomStream random(2, "realsense");
  Worst worst;
  for (std::uint64_t i = 0; i < 30; ++i) {
    const Reading r = random_reading(c.model, random, i);
    worst.add({.rate = corrected("gyroscope", r.raw.gyro), .force = corrected("accelerometer", r.raw.accel)}, r.compensated);
  }
  EXPECT_LT(std::max(worst.force, worst.rate), 1e-6) << "single precision";
  const Calibration whole = si_unit();
  EXPECT_THAT(export_target("realsense").left_out({whole}), testing::Contains(HasSubstr("g-sensitivity")));
}

/// A noise.json of gyros alone: their values, and no number for the other triad.
TEST(ExportConsumers, ATriadWithoutNoiseIsNotWritten) {
  const Calibration c = si_unit();
  ImuNoise gyros = some_noise();
  gyros.accel = {}, gyros.accel_unit.clear();
  for (const ExportTarget& target : export_targets()) {
    if (!target.needs_noise) continue;
    const std::string text = target.text({c, &gyros});
    EXPECT_THAT(target.warnings({c, &gyros}), testing::Contains(HasSubstr("the noise has no accelerometers"))) << target.name;
    if (target.name != "ros-filter") EXPECT_THAT(text, HasSubstr("the noise has no accelerometers")) << target.name;
    EXPECT_THAT(text, testing::Not(HasSubstr("nan"))) << target.name;
  }
  EXPECT_THAT(exported("gtsam", {c, &gyros}), testing::Not(HasSubstr("params.setAccelerometerCovariance")));
  const std::string yaml = exported("lio-sam", {c, &gyros});
  EXPECT_THAT(yaml, testing::AllOf(HasSubstr("  imuGyrNoise: "), HasSubstr("imuAccNoise NOT WRITTEN"), testing::Not(HasSubstr("imuAccNoise:"))));
  EXPECT_TRUE(nlohmann::json::parse(exported("json-matrix", {c, &gyros}))["noise"]["accelerometers"]["N"].is_null());
  ImuNoise accelerometers = some_noise();
  accelerometers.gyro = {}, accelerometers.gyro_unit.clear();
  EXPECT_THAT([&] { exported("ros-filter", {c, &accelerometers}); }, testing::ThrowsMessage<Error>(HasSubstr("needs the gyros' noise")));
}

}  // namespace
}  // namespace imulab::export_test
