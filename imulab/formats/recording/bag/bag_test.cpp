// Bags that other programs wrote, read.
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/bag/ros_message.hpp"
#include "imulab/formats/recording/reader.hpp"

#include <gmock/gmock.h>

#include "tests/bag_fixture.hpp"
#include "tests/run_command.hpp"
#include <algorithm>

namespace imulab::bag {
namespace {

using recording_io::TableDescription;
using recording_io::TableRows;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

class Bags : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Fixtures, Bags, testing::ValuesIn(fixture_names()), [](const auto& file) {
  std::string name = file.param;
  for (char& c : name) c = c == '.' ? '_' : c;
  return name;
});

TEST_P(Bags, HaveTheMessagesOfTheirImu) {
  for (const char* topic : {"/imu0", ""}) {  // it is the only one
    const TableRows table = read_columns(fixture(GetParam()), topic, imu_columns());
    EXPECT_THAT(table.warnings, testing::IsEmpty());
    EXPECT_EQ(table.row, "message");
    ASSERT_EQ(table.columns.size(), imu_columns().size());
    for (const auto& column : table.columns) ASSERT_EQ(column.size(), fixture_samples);
    for (std::size_t i = 0; i < fixture_samples; ++i) {
      EXPECT_EQ(table.columns[0].integers[i], fixture_stamp(i));
      EXPECT_EQ(table.columns[1].integers[i], fixture_stamp(i) + 1'000'000 + 1000 * static_cast<std::int64_t>(i));
      EXPECT_EQ(table.columns[2].numbers[i], 1);
      for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(table.columns[3 + k].numbers[i], fixture_readings(i)[k]) << i << " " << k;
    }
  }
}

TEST_P(Bags, HaveTheirTemperature) {
  const TableRows table = read_columns(fixture(GetParam()), "/temp", {"header.stamp", "temperature"});
  ASSERT_EQ(table.columns[1].size(), 6u);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(table.columns[0].integers[k], fixture_stamp(10 * k));
    EXPECT_EQ(table.columns[1].numbers[k], 20 + 10. * static_cast<double>(k) / 16);
  }
}

TEST_P(Bags, AreDescribed) {
  const TableRequest request{fixture(GetParam()), "", ""};
  std::vector<TableDescription> tables = format_of(request).describe(request);
  std::sort(tables.begin(), tables.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  ASSERT_EQ(tables.size(), 3u);
  EXPECT_EQ(tables[0].name, "/cam0");
  EXPECT_EQ(tables[0].rows, 3u);
  EXPECT_THAT(tables[0].columns, testing::IsEmpty());
  EXPECT_EQ(tables[1].name, "/imu0");
  EXPECT_THAT(tables[1].type, testing::AnyOf("sensor_msgs/Imu", "sensor_msgs/msg/Imu"));
  EXPECT_EQ(tables[1].rows, fixture_samples);
  EXPECT_EQ(tables[1].columns.at(6).name, "angular_velocity.x");
  EXPECT_EQ(tables[1].columns.at(6).unit, "rad/s");
  EXPECT_EQ(tables[1].columns.at(11).unit, "m/s^2");
  EXPECT_EQ(tables[2].rows, 6u);
  EXPECT_EQ(tables[2].columns.at(2).unit, "degC");
}

TEST_P(Bags, NameTheTopicsThereAre) {
  const auto file = fixture(GetParam());
  EXPECT_THAT([&] { read_columns(file, "/imu1", {1}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("topic /imu1 is not there"), HasSubstr("/imu0 (sensor_msgs/"), HasSubstr("/cam0"))));
  EXPECT_THAT([&] { read_columns(file, "/cam0", {1}); },
              ThrowsMessage<Error>(AllOf(HasSubstr("CompressedImage"), HasSubstr("expected sensor_msgs/Imu or sensor_msgs/Temperature"))));
  EXPECT_THAT([&] { read_columns(file, "/imu0", {"magnetic"}); }, ThrowsMessage<Error>(HasSubstr("column magnetic is not there")));
}

TEST_P(Bags, AreRecordingsOfASession) {
  const TemporaryFolder folder;
  std::filesystem::copy_file(fixture(GetParam()), folder / GetParam());
  folder.write(
      "session.toml",
      "format = \"imulab.session/1\"\n[imu]\nname = \"x\"\n[site]\ngravity_mps2 = 9.8\n[[recording]]\nfile = \"" + GetParam() +
          "\"\ntopic = \"/imu0\"\ntime = { column = \"header.stamp\", unit = \"ns\" }\n"
          "gyro = { columns = [\"angular_velocity.x\", \"angular_velocity.y\", \"angular_velocity.z\"], output = \"rate\", unit = \"rad/s\" }\n"
          "accel = { columns = [\"linear_acceleration.x\", \"linear_acceleration.y\", \"linear_acceleration.z\"], output = \"rate\", "
          "unit = \"m/s^2\" }\n");
  const Session session = read_session(folder.path());
  const Recording recording = read_recording(session, session.recordings.front()).recording;
  ASSERT_EQ(recording.size(), fixture_samples);
  EXPECT_EQ(recording.interval_s, 0.005);
  EXPECT_EQ(recording.time_ns[59], fixture_stamp(59));
  EXPECT_EQ(recording.accel[2][7], 9.8125);
}

/// The checksum of a chunk would need all of it: that only the messages were read shows where the picture is damaged.
TEST(Bag, ReadsMessagesSinglyBesideALargePicture) {
  const TemporaryFolder folder;
  for (const std::string& name : sparse_names()) {
    std::string bytes = read_text(fixture(name));
    bytes[bytes.size() / 2] ^= 1;  // in the picture, which is most of the file
    const TableRows table = read_columns(folder.write(name, bytes), "/imu0", imu_columns());
    EXPECT_THAT(table.warnings, testing::IsEmpty());
    ASSERT_EQ(table.columns[0].size(), sparse_samples) << name;
    for (std::size_t i = 0; i < sparse_samples; ++i) {
      EXPECT_EQ(table.columns[0].integers[i], fixture_stamp(i));
      for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(table.columns[3 + k].numbers[i], fixture_readings(i)[k]) << name << " " << i;
    }
    EXPECT_EQ(read_columns(folder / name, "/temp", {"temperature"}).columns[0].numbers, std::vector{20.});
  }
}

/// A bag of ROS 2 that is a folder is read; one that is compressed as a whole is not.
TEST(Bag, SaysWhatToNameInstead) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "run");
  folder.write("run/metadata.yaml", "rosbag2_bagfile_information:\n");
  std::filesystem::copy_file(fixture("imu.db3"), folder / "run/run_0.db3");
  EXPECT_GT(read_columns(folder / "run", "/imu0", {1}).size(), 0U) << "as one of its file";
  const auto packed = folder.write("run.db3.zstd", std::string("\x28\xB5\x2F\xFD\x00\x01", 6));
  EXPECT_THAT([&] { read_columns(packed, "", {1}); }, ThrowsMessage<Error>(HasSubstr("run.db3.zstd")));
}

TEST(RosMessage, KnowsBothNamesOfAType) {
  ASSERT_NE(message_type("sensor_msgs/Imu"), nullptr);
  EXPECT_EQ(message_type("sensor_msgs/msg/Imu"), message_type("sensor_msgs/Imu"));
  EXPECT_EQ(message_type("sensor_msgs/msg/MagneticField"), nullptr);
}

/// The frame's name moves the numbers, which CDR aligns to eight bytes.
TEST(RosMessage, FollowsTheAlignmentOfCdr) {
  for (std::size_t length = 1; length < 20; ++length) {
    std::string message("\0\1\0\0", 4);
    message.append("\2\0\0\0\7\0\0\0", 8);  // 2 s, 7 ns
    message.append({static_cast<char>(length), 0, 0, 0});
    message.append(length, 'x');
    while ((message.size() - 4) % 8 != 0) message += '\0';
    const std::size_t numbers = message.size();
    message.append(37 * sizeof(double), '\0');
    const MessagePlaces places = message_places(Encoding::cdr, *message_type("sensor_msgs/msg/Imu"), message);
    EXPECT_EQ(places.numbers, numbers) << length;
    EXPECT_EQ(places.stamp_ns, 2'000'000'007);
    message.pop_back();
    EXPECT_THROW(message_places(Encoding::cdr, *message_type("sensor_msgs/msg/Imu"), message), std::exception) << "too short";
  }
}

}  // namespace
}  // namespace imulab::bag
