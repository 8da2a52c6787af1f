// Logs of autopilots as they are in the field: beside the readings they hold averages, biases and health of the sensors, and old ones name no units.
#include "imulab/error.hpp"
#include "imulab/formats/recording/format.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/join.hpp"
#include "imulab/inspection/names.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace imulab {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

template <class Number>
std::string bytes_of(Number number) {
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  return bytes;
}

std::string floats(const std::array<float, 6>& numbers, std::size_t begin = 0, std::size_t end = 6) {
  std::string bytes;
  for (std::size_t i = begin; i < end; ++i) bytes += bytes_of(numbers[i]);
  return bytes;
}

/// Gyros and accelerometers of a unit that lies still: noise of a kind about gravity.
std::array<float, 6> sample(std::size_t i) {
  const auto wave = [i](double k) { return static_cast<float>(0.01 * std::sin(k * static_cast<double>(i))); };
  return {wave(1.1), wave(1.7), wave(2.3), wave(0.9), wave(1.3), 9.8F + wave(2.9)};
}

/// A PX4 log (https://docs.px4.io/main/en/dev_log/ulog_file_format.html).
class UlogText {
 public:
  UlogText() : text_("ULog\x01\x12\x35\x01") { text_ += bytes_of(std::uint64_t{0}); }
  /// Returns the number that its messages have.
  std::uint16_t define(const std::string& name, const std::string& fields) {
    message('F', name + ":uint64_t timestamp;" + fields);
    names_.push_back(name);
    return static_cast<std::uint16_t>(names_.size() - 1);
  }
  void begin_data() {
    for (std::size_t i = 0; i < names_.size(); ++i) message('A', std::string(1, '\0') + bytes_of(static_cast<std::uint16_t>(i)) + names_[i]);
  }
  void add(std::uint16_t id, std::uint64_t us, const std::string& fields) { message('D', bytes_of(id) + bytes_of(us) + fields); }
  const std::string& text() const { return text_; }

 private:
  void message(char type, const std::string& body) { text_ += bytes_of(static_cast<std::uint16_t>(body.size())) + type + body; }
  std::string text_;
  std::vector<std::string> names_;
};

std::string px4_log(std::size_t samples, std::size_t every) {
  UlogText log;
  const auto combined = log.define("sensor_combined", "float[3] gyro_rad;uint32_t gyro_integral_dt;float[3] accelerometer_m_s2;");
  const auto status = log.define("vehicle_imu_status", "float[3] mean_gyro;float[3] mean_accel;");
  const auto bias = log.define("estimator_sensor_bias", "float[3] gyro_bias;float[3] accel_bias;");
  const auto gyro = log.define("sensor_gyro", "float x;float y;float z;uint32_t error_count;");
  const auto accel = log.define("sensor_accel", "float x;float y;float z;uint32_t error_count;");
  log.begin_data();
  for (std::size_t i = 0; i < samples; ++i) {
    const std::uint64_t us = 4000 * i;
    const auto s = sample(i);
    log.add(combined, us, floats(s, 0, 3) + bytes_of(static_cast<std::uint32_t>(3990 + i % 7)) + floats(s, 3, 6));
    log.add(gyro, us, floats(s, 0, 3) + bytes_of(std::uint32_t{0}));
    log.add(accel, us, floats(s, 3, 6) + bytes_of(std::uint32_t{0}));
    if (i % every == 0) log.add(status, us, floats(s)), log.add(bias, us, floats(s));
  }
  return log.text();
}

/// An ArduPilot log from before 2018: no units.
std::string ardupilot_log(std::size_t samples, const std::string& name) {
  const auto padded = [](std::string text, std::size_t size) { return text.append(size - text.size(), '\0'); };
  std::string log = "\xA3\x95\x80\x80\x59" + padded("FMT", 4) + padded("BBnNZ", 16) + padded("Type,Length,Name,Format,Columns", 64);
  log += "\xA3\x95\x80\x0A\x1F" + padded(name, 4) + padded("Iffffff", 16) + padded("TimeMS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ", 64);
  for (std::size_t i = 0; i < samples; ++i) log += "\xA3\x95\x0A" + bytes_of(static_cast<std::uint32_t>(20 * i)) + floats(sample(i));
  return log;
}

Inspection inspected_file(const std::filesystem::path& file, const std::vector<std::string>& topics = {}) {
  return inspect(inspection::joined(read_tables(file, topics)));
}

TEST(InspectAutopilots, TakesTheReadingsAndNotTheirAveragesOfAPx4Log) {
  const TemporaryFolder folder;
  const Inspection found = inspected_file(folder.write("log.ulg", px4_log(2000, 250)));
  EXPECT_EQ(found.topic, "sensor_combined");
  EXPECT_EQ(found.format, "PX4 ULog: sensor_combined");
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_THAT(found.evidence(),
              Contains("sensor_combined has most rows of the tables with gyros and accelerometers and was taken; --topic takes another: "
                       "vehicle_imu_status"));
  EXPECT_THAT(found.evidence(), Contains(HasSubstr("gyros: gyro_rad.1, gyro_rad.2, gyro_rad.3: rad/s")));
  EXPECT_THAT(found.evidence(), Contains(HasSubstr("accelerometers: accelerometer_m_s2.1, accelerometer_m_s2.2, accelerometer_m_s2.3: |a| at rest")));
}

TEST(InspectAutopilots, AsksWhereTwoTablesHaveSimilarRates) {
  const TemporaryFolder folder;
  const auto file = folder.write("log.ulg", px4_log(2000, 5));
  EXPECT_THAT(imus_of(file), IsEmpty()) << "they are no two IMUs";
  try {
    inspected_file(file);
    FAIL() << "one of them was taken";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(),
                HasSubstr("several tables have both gyros and accelerometers by name; expected a topic of sensor_combined, vehicle_imu_status"));
  }
}

TEST(InspectAutopilots, ATablesNameSaysWhichSensorItsAxesAreOf) {
  const TemporaryFolder folder;
  const Inspection found = inspected_file(folder.write("log.ulg", px4_log(2000, 250)), {"sensor_gyro", "sensor_accel"});
  EXPECT_THAT(found.ambiguous(), IsEmpty());
  EXPECT_THAT(found.evidence(), Contains(HasSubstr("gyros: sensor_gyro.x, sensor_gyro.y, sensor_gyro.z: rad/s")));
  EXPECT_EQ(found.source.gyro.columns, (std::vector<Column>{"x", "y", "z"})) << "as the file names them";
  EXPECT_EQ(found.source.accel.topic, "sensor_accel");
}

TEST(InspectAutopilots, KnowsTheUnitsOfOldArduPilotLogs) {
  const TemporaryFolder folder;
  for (const char* name : {"IMU", "IMU2"}) {
    const Inspection found = inspected_file(folder.write("log.bin", ardupilot_log(2000, name)));
    EXPECT_THAT(found.ambiguous(), IsEmpty()) << name;
    EXPECT_EQ(found.source.gyro.unit, "rad/s");
    EXPECT_EQ(found.source.accel.unit, "m/s^2");
  }
  EXPECT_THAT(inspected_file(folder.write("log.bin", ardupilot_log(2000, "XYZ"))).ambiguous(), Contains(HasSubstr("gyro.unit"))) << "nothing says it";
}

TEST(InspectAutopilots, NamesOfWhatIsKnownAboutASensorAreNotItsReadings) {
  using inspection::hint_of;
  using inspection::Role;
  for (const char* name : {"gyro_bias.1", "accel_bias_x", "gyro_integral_dt", "accelerometer_timestamp_relative", "accel_error_count",
                           "accel_device_id", "accelerometer_clipping", "gyro_rate_hz", "gyro_inconsistency", "gyro_calibration_count"})
    EXPECT_EQ(hint_of(name).role, Role::other) << name;
  for (const char* name : {"accel_x", "accelX_raw", "linear_acceleration.x", "accelerometer_m_s2.1"})
    EXPECT_EQ(hint_of(name).role, Role::accel) << name;
  for (const char* name : {"gyro_rad.3", "angular_velocity.z", "GyrX", "gyr_x [deg/s]"}) EXPECT_EQ(hint_of(name).role, Role::gyro) << name;
}

}  // namespace
}  // namespace imulab
