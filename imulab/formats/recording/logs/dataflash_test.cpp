// ArduPilot logs (tests/recordings/dataflash_file.py).
#include <gmock/gmock.h>

#include "tests/recording_files.hpp"

namespace imulab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;

TEST(Dataflash, AMessageAndSensorIsATable) {
  const TableRequest request{.file = recording_file("ardupilot.bin")};
  const auto tables = format_of(request).describe(request);
  std::vector<std::string> names;
  for (const auto& table : tables) names.push_back(table.name + ":" + std::to_string(table.rows));
  EXPECT_THAT(names, IsSupersetOf({"IMU:40", "IMU.1:40", "ATT:10", "OLD:10"}));
  EXPECT_THAT(column_texts(find_table(tables, "IMU.1", "")),
              ElementsAre("TimeUS [us]", "I", "GyrX [rad/s]", "GyrY [rad/s]", "GyrZ [rad/s]", "AccX [m/s^2]", "AccY [m/s^2]", "AccZ [m/s^2]", "EG",
                          "T [degC]", "SampleUS [us]"));
  EXPECT_THAT(column_texts(find_table(tables, "OLD", "")), ElementsAre("TimeMS [ms]", "GX", "GY", "Mode"));
}

TEST(Dataflash, Values) {
  TableRequest request{.file = recording_file("ardupilot.bin"), .topic = "IMU"};
  expect_columns(request, {"GyrX", "GyrY", "GyrZ"}, fixture_gyro);
  expect_columns(request, {"AccX", "AccY", "AccZ"}, fixture_accel);
  expect_columns(request, {"TimeUS", "SampleUS"},
                 [](std::size_t i, std::size_t c) { return 8000.0 * static_cast<double>(i + 1) - (c == 1 ? 500 : 0); });
  EXPECT_EQ(columns_of(request, {"TimeUS"}).columns[0].integers.size(), fixture_samples) << "exact";
  expect_columns(request, {"T"}, [](std::size_t i, std::size_t) { return (25000 + static_cast<double>(i)) / 1000; });
  request.topic = "IMU.1";
  expect_columns(request, {"AccX", "AccY", "AccZ"}, [](std::size_t i, std::size_t k) { return fixture_accel(i, k) + 1; });
  EXPECT_THAT(columns_of(request, {"T"}).warnings, IsEmpty());
}

TEST(Dataflash, FormatsWithAScale) {
  const TableRequest request{.file = recording_file("ardupilot.bin"), .topic = "ATT"};
  const auto value = [](std::size_t row, std::size_t c) {
    const double i = 4 * static_cast<double>(row);
    return c == 0 ? i : c == 1 ? -i / 2 : c == 2 ? 359.99 : c == 3 ? (123456 + i) / 100 : c == 4 ? (473000000 + i) / 1e7 : i + 31;
  };
  expect_columns(request, {"DesRoll", "Roll", "Yaw", "Far", "Lat", "Raw.32"}, value, 10);
}

TEST(Dataflash, SaysWhatWasLost) {
  const TemporaryFolder folder;
  const std::string bytes = file_bytes(recording_file("ardupilot.bin"));
  const auto cut = columns_of({.file = folder.write("cut.bin", bytes.substr(0, bytes.size() - 20)), .topic = "IMU.1"}, {"TimeUS"});
  EXPECT_EQ(cut.columns[0].size(), 39u);
  EXPECT_THAT(cut.warnings, ElementsAre(HasSubstr("cut.bin: 30 bytes at the end are an unfinished message, which is not read")));
  const std::size_t imu = bytes.rfind("\xA3\x95\x0A");
  const auto noise =
      columns_of({.file = folder.write("noise.bin", bytes.substr(0, imu) + "some noise" + bytes.substr(imu)), .topic = "IMU.1"}, {"TimeUS"});
  EXPECT_EQ(noise.columns[0].size(), 40u);
  EXPECT_THAT(noise.warnings, ElementsAre(HasSubstr("10 bytes are no messages and were passed over: samples may be missing")));
}

TEST(Dataflash, NamesWhatThereIs) {
  TableRequest request{.file = recording_file("ardupilot.bin"), .topic = "ACC"};
  EXPECT_THAT(error_of(request, {"AccX"}), HasSubstr("topic ACC is not there; expected one of"));
  request.topic = "IMU";
  EXPECT_THAT(error_of(request, {"X"}), HasSubstr("ardupilot.bin: IMU: column X is not there; expected one of TimeUS, I, GyrX"));
}

TEST(Dataflash, DamageIsSurvived) {
  expect_damage_is_survived({.file = recording_file("ardupilot.bin"), .topic = "IMU.1"}, {"TimeUS", "AccZ", "T"}, 13);
}

}  // namespace
}  // namespace imulab
