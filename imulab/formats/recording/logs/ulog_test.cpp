// PX4 logs (tests/recordings/ulog_file.py).
#include <gmock/gmock.h>

#include "tests/recording_files.hpp"

namespace imulab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

double micros(std::size_t i) { return 8000.0 * static_cast<double>(i + 1); }

TEST(Ulog, AMessageAndInstanceIsATable) {
  const TableRequest request{.file = recording_file("px4.ulg")};
  const auto tables = format_of(request).describe(request);
  std::vector<std::string> names;
  for (const auto& table : tables) names.push_back(table.name + ":" + std::to_string(table.rows));
  EXPECT_THAT(names, ElementsAre("sensor_accel:40", "sensor_accel.1:40", "sensor_combined:40", "nested:10"));
  EXPECT_THAT(column_texts(tables[0]), ElementsAre("timestamp [us]", "timestamp_sample [us]", "device_id", "x [m/s^2]", "y [m/s^2]", "z [m/s^2]",
                                                   "temperature [degC]", "clip.1", "clip.2", "clip.3", "clip.4"));
  EXPECT_THAT(column_texts(tables[3]), ElementsAre("timestamp [us]", "parts.1.raw", "parts.2.raw", "rate"));
}

TEST(Ulog, Values) {
  for (const char* name : {"px4.ulg", "px4_appended.ulg"}) {
    TableRequest request{.file = recording_file(name), .topic = "sensor_accel"};
    expect_columns(request, {"x", "y", "z"}, fixture_accel);
    expect_columns(request, {"timestamp"}, [](std::size_t i, std::size_t) { return micros(i); });
    expect_columns(request, {"timestamp_sample"}, [](std::size_t i, std::size_t) { return micros(i) - 500; });
    expect_columns(request, {"clip.3"}, [](std::size_t, std::size_t) { return 3.0; });
    request.topic = "sensor_accel.1";
    expect_columns(request, {"x", "y", "z"}, [](std::size_t i, std::size_t k) { return fixture_accel(i, k) + 1; });
    request.topic = "sensor_combined";
    expect_columns(request, {"gyro_rad.1", "gyro_rad.2", "gyro_rad.3"}, fixture_gyro);
    expect_columns(request, {"accelerometer_m_s2.1", "accelerometer_m_s2.2", "accelerometer_m_s2.3"}, fixture_accel);
    expect_columns(request, {"accelerometer_timestamp_relative"}, [](std::size_t, std::size_t) { return -300.0; });
    request.topic = "nested";
    expect_columns(
        request, {"parts.1.raw", "parts.2.raw"}, [](std::size_t i, std::size_t k) { return fixture_counts(4 * i, k); }, 10);
  }
}

TEST(Ulog, SaysWhatWasLost) {
  const TableRequest plain{.file = recording_file("px4.ulg"), .topic = "sensor_accel"};
  EXPECT_THAT(columns_of(plain, {"x"}).warnings, ElementsAre(HasSubstr("px4.ulg: 1 dropout of the logger, 30 ms together: messages of those times")));
  const TableRequest appended{.file = recording_file("px4_appended.ulg"), .topic = "sensor_accel"};
  EXPECT_THAT(columns_of(appended, {"x"}).warnings,
              ElementsAre(HasSubstr("dropout"), HasSubstr("25 bytes at the end are an unfinished message, which is not read")));

  const TemporaryFolder folder;
  const std::string bytes = file_bytes(plain.file);
  const auto cut = columns_of({.file = folder.write("cut.ulg", bytes.substr(0, bytes.size() - 20)), .topic = "sensor_combined"}, {"timestamp"});
  EXPECT_EQ(cut.columns[0].size(), 39u);
  EXPECT_THAT(cut.warnings, ElementsAre(HasSubstr("dropout"), HasSubstr("unfinished")));
}

TEST(Ulog, GoesOnAtASyncMessageAfterDamage) {
  const TemporaryFolder folder;
  std::string bytes = file_bytes(recording_file("px4.ulg"));
  const std::string dropout("\2\0O\x1E\0", 5);
  const std::size_t at = bytes.find(dropout);
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, 3, 3, '\0');  // the logger's message before the sync message
  const auto table = columns_of({.file = folder.write("x.ulg", bytes), .topic = "sensor_accel"}, {"x"});
  EXPECT_EQ(table.columns[0].size(), fixture_samples);
  EXPECT_THAT(table.warnings, ElementsAre(HasSubstr("16 bytes are no messages and were passed over")));
}

TEST(Ulog, MessagesOfNewerTypesArePassedOver) {
  const TemporaryFolder folder;
  std::string bytes = file_bytes(recording_file("px4.ulg"));
  const std::size_t at = bytes.find(std::string("\2\0O\x1E\0", 5));
  bytes[at + 2] = 'z';
  const auto table = columns_of({.file = folder.write("x.ulg", bytes), .topic = "sensor_accel"}, {"x"});
  EXPECT_EQ(table.columns[0].size(), fixture_samples);
  EXPECT_THAT(table.warnings, IsEmpty());
}

TEST(Ulog, NamesWhatThereIs) {
  TableRequest request{.file = recording_file("px4.ulg")};
  EXPECT_THAT(error_of(request, {"x"}),
              HasSubstr("has several topics and the session names none; expected topic = one of sensor_accel, sensor_accel.1"));
  request.topic = "vehicle_imu";
  EXPECT_THAT(error_of(request, {"x"}), HasSubstr("topic vehicle_imu is not there; expected one of sensor_accel"));
  request.topic = "never_logged";
  EXPECT_THAT(error_of(request, {"x"}), HasSubstr("topic never_logged is not there"));
  request.topic = "sensor_accel";
  EXPECT_THAT(error_of(request, {"w"}),
              HasSubstr("px4.ulg: sensor_accel: column w is not there; expected one of timestamp, timestamp_sample, device_id, x"));
}

/// A log of one definition, one subscription and some data.
std::string log_of(const std::string& definition, const std::string& message, char incompatible = 0) {
  const auto framed = [](char type, const std::string& payload) {
    std::string text{static_cast<char>(payload.size() & 255), static_cast<char>(payload.size() >> 8), type};
    return text + payload;
  };
  std::string flags(40, '\0');
  flags[8] = incompatible;
  return std::string("ULog\x01\x12\x35\x01", 8) + std::string(8, '\0') + framed('B', flags) + framed('F', definition) +
         framed('A', std::string(3, '\0') + message) + framed('D', std::string(64, '\0'));
}

TEST(Ulog, WrongDefinitionsAreErrors) {
  const TemporaryFolder folder;
  const struct {
    std::string bytes, message;
  } cases[] = {
      {log_of("a:a x;int8_t y;", "a"), "message a is nested too deep; expected no message that contains itself"},
      {log_of("a:float[60000] x;", "a"), "message a is longer than a message can be"},
      {log_of("a:float x;", "b"), "message b is not defined"},
      {log_of("a:b[9] x;", "a"), "message b is not defined"},
      {log_of("a:float x;", "a", 4), "features of a newer format"},
      {log_of("a:char[4] x;", "a"), "column x is not there"},
      {log_of("a:float[99999] x;", "a"), "column x is not there"},
      {log_of("nothing", "a"), "message a is not defined"},
      {log_of("a:", "a").substr(0, 10), "ends inside its head"},
  };
  for (const auto& c : cases) EXPECT_THAT(error_of({.file = folder.write("x.ulg", c.bytes)}, {"x"}), HasSubstr(c.message));
  const auto table = columns_of({.file = folder.write("x.ulg", log_of("a:float[30] x;", "a"))}, {"x.20"});
  EXPECT_EQ(table.columns[0].size(), 0u);
  EXPECT_THAT(table.warnings, ElementsAre(HasSubstr("a: 1 messages are shorter than their definition: they are not read")));
}

TEST(Ulog, DamageIsSurvived) {
  expect_damage_is_survived({.file = recording_file("px4_appended.ulg"), .topic = "sensor_accel.1"}, {"timestamp", "x"}, 13);
}

}  // namespace
}  // namespace imulab
