// The formats of receivers, buses and logs, from bytes made here by their specifications.
#include "imulab/error.hpp"
#include "imulab/formats/aid/format.hpp"
#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/mcap_file.hpp"
#include "tests/temporary_folder.hpp"
#include <cmath>
#include <string>
#include <vector>

namespace imulab::aid_io {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int64_t second = 1'000'000'000;

struct ReadAid {
  AidRecord record;
  TimeScale scale;
  std::vector<std::string> warnings;
  std::string format;
};

/// By the format that recognizes the text.
ReadAid read_aid_text(std::string_view text, AidKind kind = AidKind::gnss, const std::string& topic = "") {
  const TemporaryFolder folder;
  const AidRequest request{folder.write("aid", text), kind, topic};
  for (const AidFormat& format : aid_formats())
    if (format.recognizes(text.substr(0, 4096))) {
      AidRows rows = format.read(request);
      const TimeScale scale = rows.scale;
      AidReading reading = make_record(std::move(rows));
      return {std::move(reading.record), scale, std::move(reading.warnings), std::string(format.name)};
    }
  throw Error("no format");
}

std::string aid_text_error(std::string_view text, AidKind kind = AidKind::gnss, const std::string& topic = "") {
  try {
    read_aid_text(text, kind, topic);
  } catch (const Error& e) {
    return e.what();
  }
  return "none";
}

void expect_place(const AidRecord& r) {
  ASSERT_FALSE(r.position.empty());
  EXPECT_NEAR(r.position[0].x(), 40.0966268 * unit::deg, 1e-11);
  EXPECT_NEAR(r.position[0].y(), -105.1474483 * unit::deg, 1e-11);
  EXPECT_NEAR(r.position[0].z(), 1601.5, 1e-9);
}

const std::string nmea =
    "$GNGGA,193418.500,4005.797608,N,10508.846898,W,4,21,0.6,1622.3,M,-20.8,M,1.0,0001*67\r\n"
    "$GNRMC,193418.500,A,4005.797608,N,10508.846898,W,10.0,90.0,080725,,,R*7B\r\n"
    "$GNVTG,90.0,T,,M,10.0,N,18.52,K,D*10\r\n"
    "$GNGST,193418.500,1.0,,,,0.012,0.010,0.020*55\r\n";

TEST(Nmea, SentencesOfOneTimeAreOneRow) {
  const ReadAid aid = read_aid_text(nmea);
  EXPECT_EQ(aid.format, "NMEA 0183");
  EXPECT_EQ(aid.scale, TimeScale::utc);
  EXPECT_THAT(aid.record.time, ElementsAre(1752003258 * second + second / 2));
  expect_place(aid.record);
  EXPECT_NEAR(aid.record.velocity[0].x(), 10 * 1852.0 / 3600, 1e-12);
  EXPECT_NEAR(aid.record.velocity[0].y(), 0, 1e-12);
  EXPECT_TRUE(std::isnan(aid.record.velocity[0].z()));
  EXPECT_EQ(aid.record.position_sigma[0], Eigen::Vector3d(0.010, 0.012, 0.020)) << "GST has latitude first";
  EXPECT_THAT(aid.warnings, ElementsAre(HasSubstr("1 rows repeat"))) << "VTG says what RMC has said";
}

TEST(Nmea, WhatIsLostIsSaid) {
  const std::string second_row =
      "$GNGGA,193419.500,4005.797608,N,10508.846898,W,4,21,0.6,1622.3,M,,M,1.0,0001*5F\n$GNGGA,193420.500,,,,,0,00,99.9,,M,,M,,*79\n";
  std::string damaged = nmea + second_row + nmea.substr(0, 70);
  damaged[20] = '5';
  const ReadAid aid = read_aid_text(damaged);
  EXPECT_THAT(aid.warnings, ElementsAre(HasSubstr("2 of 7 sentences are damaged (checksum)"), HasSubstr("1 sentences without a fix"),
                                        HasSubstr("1 heights have no geoid separation"), HasSubstr("1 rows repeat")));
  EXPECT_EQ(aid.record.time.size(), 2u);
  EXPECT_EQ(aid.record.position_sigma.at(1).z(), 30) << "the geoid's size";
  const ReadAid undated = read_aid_text(second_row);
  EXPECT_EQ(undated.scale, TimeScale::own);
  const ReadAid known = read_aid_text(nmea + second_row);
  EXPECT_NEAR(known.record.position.at(1).z(), 1601.5, 1e-9) << "a separation holds until the next one";
  EXPECT_THAT(aid_text_error(nmea, AidKind::barometer), HasSubstr("is a receiver's log (NMEA 0183), and the aid's kind is barometer"));
}

const std::string bestpos =
    "#BESTPOSA,COM1,0,90.5,FINESTEERING,2374,243258.500,02000000,b1f6,32768;SOL_COMPUTED,NARROW_INT,40.0966268,-105.1474483,1622.3,-20.8,WGS84,0.012,"
    "0.010,0.020,\"\",0.0,0.0,35,30,30,30,00,06,39,33*a15956df\r\n";
const std::string bestvel =
    "#BESTVELA,COM1,0,90.5,FINESTEERING,2374,243258.500,02000000,10a2,32768;SOL_COMPUTED,DOPPLER_VELOCITY,0.150,0.0,5.0,90.0,0.1,0.0*b94333ec\r\n";

TEST(NovatelSolution, AVelocityIsEarlierByItsLatency) {
  const ReadAid aid = read_aid_text(bestpos + bestvel + bestvel.substr(0, 100));
  EXPECT_EQ(aid.scale, TimeScale::gps);
  EXPECT_THAT(aid.record.time, ElementsAre(1752003258 * second + 350'000'000, 1752003258 * second + 500'000'000));
  EXPECT_NEAR(aid.record.velocity[0].x(), 5, 1e-12);
  EXPECT_EQ(aid.record.velocity[0].z(), 0.1);
  EXPECT_NEAR(aid.record.position[1].z(), 1601.5, 1e-9);
  EXPECT_EQ(aid.record.position_sigma[1], Eigen::Vector3d(0.010, 0.012, 0.020));
  EXPECT_THAT(aid.warnings, ElementsAre(HasSubstr("1 logs are damaged")));
  EXPECT_THAT(aid_text_error("#BESTPOSA,COM1,0,90.5,FINESTEERING,2374,243259.500,02000000,b1f6,32768;SOL_COMPUTED,NARROW_INT,40.0966268,-105.1474483,"
                             "1622.3,-20.8,USER,0.012,0.010,0.020,\"\",0.0,0.0,35,30,30,30,00,06,39,33*e141aa0e\n"),
              HasSubstr("aid:1: positions in the datum USER; expected WGS84"));
}

template <class... Numbers>
std::string packed(Numbers... numbers) {
  std::string out;
  (bag::append<Numbers>(out, numbers), ...);
  return out;
}

std::string ulog_message(char type, const std::string& payload) { return packed(static_cast<std::uint16_t>(payload.size())) + type + payload; }

std::string ulog_of(const std::string& format, const std::string& name, const std::string& row) {
  return std::string("ULog\x01\x12\x35\x01", 8) + packed(std::uint64_t{0}) + ulog_message('F', name + ":" + format) +
         ulog_message('A', std::string(1, '\0') + packed(std::uint16_t{0}) + name) + ulog_message('D', packed(std::uint16_t{0}) + row);
}

TEST(AutopilotLogs, Px4) {
  const ReadAid now = read_aid_text(ulog_of(
      "uint64_t timestamp;uint64_t timestamp_sample;double latitude_deg;double longitude_deg;double altitude_ellipsoid_m;float vel_n_m_s;float "
      "vel_e_m_s;float vel_d_m_s;float eph;float epv;float s_variance_m_s;uint8_t fix_type;",
      "vehicle_gps_position",
      packed(std::uint64_t{1'500'000}, std::uint64_t{1'400'000}, 40.0966268, -105.1474483, 1601.5, 1.0F, 2.0F, 3.0F, 0.5F, 0.75F, 0.25F,
             std::uint8_t{3})));
  EXPECT_EQ(now.format, "PX4 ULog");
  EXPECT_THAT(now.record.time, ElementsAre(1'400'000'000));
  expect_place(now.record);
  EXPECT_EQ(now.record.velocity[0], Eigen::Vector3d(2, 1, -3));
  EXPECT_EQ(now.record.position_sigma[0], Eigen::Vector3d(0.5, 0.5, 0.75));
  const std::string before = ulog_of("uint64_t timestamp;int32_t lat;int32_t lon;int32_t alt_ellipsoid;uint8_t fix_type;", "vehicle_gps_position",
                                     packed(std::uint64_t{1'500'000}, 400966268, -1051474483, 1601500, std::uint8_t{4}));
  expect_place(read_aid_text(before).record);
  EXPECT_THAT(aid_text_error(before, AidKind::barometer),
              HasSubstr("has no message of kind barometer; expected vehicle_air_data, BARO; it has vehicle_gps"));
  const ReadAid height =
      read_aid_text(ulog_of("uint64_t timestamp;float baro_alt_meter;", "vehicle_air_data", packed(std::uint64_t{7}, 12.5F)), AidKind::barometer);
  EXPECT_THAT(height.record.value, ElementsAre(12.5));
}

std::string dataflash_format_of(int id, int length, const char* name, const char* format, const char* labels) {
  const auto fixed = [](std::string text, std::size_t size) {
    text.resize(size, '\0');
    return text;
  };
  return "\xA3\x95\x80" + std::string(1, static_cast<char>(id)) + static_cast<char>(length) + fixed(name, 4) + fixed(format, 16) + fixed(labels, 64);
}

TEST(AutopilotLogs, ArduPilot) {
  const std::string log = dataflash_format_of(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns") +
                          dataflash_format_of(1, 3 + 8 + 1 + 8 + 16, "GPS", "QBLLffff", "TimeUS,Status,Lat,Lng,Alt,Spd,GCrs,VZ") +
                          dataflash_format_of(2, 3 + 8 + 16, "GPA", "Qffff", "TimeUS,HAcc,VAcc,SAcc,Und") + "\xA3\x95\x01" +
                          packed(std::uint64_t{1'400'000}, std::uint8_t{3}, 400966268, -1051474483, 1622.25F, 5.0F, 90.0F, 0.5F) + "\xA3\x95\x02" +
                          packed(std::uint64_t{1'400'000}, 0.5F, 0.75F, 0.25F, -20.75F) + "\xA3\x95\x01" +
                          packed(std::uint64_t{1'600'000}, std::uint8_t{1}, 0, 0, 0.0F, 0.0F, 0.0F, 0.0F);
  const ReadAid aid = read_aid_text(log);
  EXPECT_EQ(aid.format, "ArduPilot DataFlash");
  EXPECT_THAT(aid.record.time, ElementsAre(1'400'000'000));
  expect_place(aid.record);
  EXPECT_NEAR(aid.record.velocity[0].x(), 5, 1e-12);
  EXPECT_EQ(aid.record.velocity[0].z(), -0.5);
  EXPECT_EQ(aid.record.velocity_sigma[0].x(), 0.25);
  EXPECT_THAT(aid.warnings, ElementsAre(HasSubstr("GPS: 1 messages without a fix")));
}

/// A bag of ROS 2 with one message of the type on each of its topics.
std::string aid_bag(const std::string& type, const std::vector<std::string>& topics, const std::string& content) {
  std::string file(bag::mcap_magic), schema = packed(std::uint16_t{1});
  append_mcap_record(file, 1, std::string(8, '\0'));
  for (const std::string& text : {type, std::string("ros2msg"), std::string()}) append_counted(schema, text);
  append_mcap_record(file, 3, schema);
  for (std::size_t t = 0; t < topics.size(); ++t) {
    std::string channel = packed(static_cast<std::uint16_t>(t + 1), std::uint16_t{1});
    for (const std::string& text : {topics[t], std::string("cdr"), std::string()}) append_counted(channel, text);
    append_mcap_record(file, 4, channel);
    append_mcap_record(file, 5, packed(static_cast<std::uint16_t>(t + 1), std::uint32_t{0}, std::int64_t{0}, std::int64_t{0}) + content);
  }
  append_mcap_record(file, 15, std::string(4, '\0'));
  append_mcap_record(file, 2, std::string(20, '\0'));
  return file + std::string(bag::mcap_magic);
}

TEST(BagAids, FixesAndTwists) {
  // In CDR, behind four bytes: the stamp, "gps" and its end, NavSatStatus (one byte, one of padding, two), then doubles on a multiple of eight.
  const std::string head =
      std::string("\0\1\0\0", 4) + packed(std::int32_t{1'752'003'240}, std::uint32_t{500'000'000}, std::uint32_t{4}) + std::string("gps\0", 4);
  std::string fix = head + packed(std::int8_t{0}, std::uint8_t{0}, std::uint16_t{1}, std::uint32_t{0}) + packed(40.0966268, -105.1474483, 1601.5);
  for (int i = 0; i < 9; ++i) fix += packed(i == 0 ? 0.25 : i == 4 ? 0.16 : i == 8 ? 1.0 : 0.0);
  fix += packed(std::uint8_t{2});
  const ReadAid aid = read_aid_text(aid_bag("sensor_msgs/msg/NavSatFix", {"/fix"}, fix));
  EXPECT_THAT(aid.record.time, ElementsAre(1'752'003'240 * second + second / 2));
  expect_place(aid.record);
  EXPECT_EQ(aid.record.position_sigma[0], Eigen::Vector3d(0.5, 0.4, 1));
  const std::string twist = head + packed(1.0, 2.0, 3.0, 0.0, 0.0, 0.0);
  const std::string twists = aid_bag("geometry_msgs/msg/TwistStamped", {"/vel", "/odom"}, twist);
  EXPECT_THAT(aid_text_error(twists), HasSubstr("has several topics of an aid; expected file = \"aid:TOPIC\" with one of /vel, /odom"));
  EXPECT_EQ(read_aid_text(twists, AidKind::gnss, "/vel").record.velocity[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_THAT(read_aid_text(twists, AidKind::wheels, "/odom").record.value, ElementsAre(1.0));
  std::string known = twist;  // and a covariance of six rows, the velocity's first
  for (int i = 0; i < 36; ++i) known += packed(i == 0 ? 0.25 : i == 7 ? 0.16 : i == 14 ? 0.01 : i > 20 ? 9.0 : 0.001);
  const std::string with_covariance = aid_bag("geometry_msgs/msg/TwistWithCovarianceStamped", {"/vel"}, known);
  const AidRecord velocity = read_aid_text(with_covariance, AidKind::gnss).record;
  EXPECT_EQ(velocity.velocity[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(velocity.velocity_sigma[0], Eigen::Vector3d(0.5, 0.4, 0.1));
  EXPECT_THAT(read_aid_text(with_covariance, AidKind::wheels).record.value_sigma, ElementsAre(0.5));
  EXPECT_THAT(aid_text_error(twists, AidKind::heading), HasSubstr("has no topic of kind heading"));
}

void expect_pose(const AidRecord& r) {
  ASSERT_EQ(r.place.size(), 1u);
  EXPECT_EQ(r.place[0], Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((r.attitude[0] - Eigen::Vector4d(0.5, -0.5, 0.1, 0.7).normalized()).norm(), 1e-12) << "x, y, z, w";
}

TEST(BagAids, Poses) {
  const std::string head =
      std::string("\0\1\0\0", 4) + packed(std::int32_t{1'752'003'240}, std::uint32_t{500'000'000}, std::uint32_t{4}) + std::string("map\0", 4);
  const std::string pose = packed(1.0, 2.0, 3.0, 0.5, -0.5, 0.1, 0.7);
  expect_pose(read_aid_text(aid_bag("geometry_msgs/msg/PoseStamped", {"/pose"}, head + pose), AidKind::pose).record);
  // The name of the child, then numbers on a multiple of eight after the encapsulation.
  const std::string child = packed(std::uint32_t{5}) + std::string("base\0", 5) + std::string(7, '\0');
  std::string covariance;
  for (int i = 0; i < 36; ++i) covariance += packed(i % 7 != 0 ? 0.0 : i < 21 ? 0.04 : 1e-4);
  const ReadAid odometry = read_aid_text(aid_bag("nav_msgs/msg/Odometry", {"/odom"}, head + child + pose + covariance), AidKind::odometry);
  expect_pose(odometry.record);
  EXPECT_NEAR(odometry.record.position_sigma[0].y(), 0.2, 1e-12);
  EXPECT_NEAR(odometry.record.value_sigma[0], 0.01, 1e-12);
  EXPECT_THAT(read_aid_text(aid_bag("geometry_msgs/msg/PoseStamped", {"/pose"}, head + pose), AidKind::attitude).record.place, IsEmpty());
  // Transforms: their number, then each as above; the first stamp is on a multiple of four, the second on one of eight.
  const auto transform = [&](const std::string& name, const std::string& numbers, std::size_t before) {
    std::string out = head.substr(4) + packed(static_cast<std::uint32_t>(name.size() + 1)) + name + '\0';
    while ((before + out.size()) % 8 != 0) out += '\0';
    return out + numbers;
  };
  std::string list = packed(std::uint32_t{2});
  list += transform("base_link", pose, list.size());
  list += transform("wheel", packed(9.0, 9.0, 9.0, 0.0, 0.0, 0.0, 1.0), list.size());
  const std::string tf = aid_bag("tf2_msgs/msg/TFMessage", {"/tf", "/tf_static"}, head.substr(0, 4) + list);
  expect_pose(read_aid_text(tf, AidKind::pose, "/tf:base_link").record);
  EXPECT_EQ(read_aid_text(tf, AidKind::pose, "/tf:wheel").record.place[0], Eigen::Vector3d(9, 9, 9));
  for (const char* topic : {"", "/tf", "/tf:arm"})
    EXPECT_THAT(aid_text_error(tf, AidKind::pose, topic), HasSubstr("2 frames; expected file = \"aid:/tf:FRAME\" with one of base_link")) << topic;
  const std::string cut = aid_bag("tf2_msgs/msg/TFMessage", {"/tf"}, (head.substr(0, 4) + list).substr(0, list.size() - 8));
  EXPECT_THAT(aid_text_error(cut, AidKind::pose), HasSubstr("message 1: it is too short for tf2_msgs/TFMessage"));
  const std::string endless = aid_bag("tf2_msgs/msg/TFMessage", {"/tf"}, head.substr(0, 4) + packed(std::uint32_t{0xFFFFFFFF}));
  EXPECT_THAT(aid_text_error(endless, AidKind::pose), HasSubstr("too short"));
  EXPECT_THAT(aid_text_error(aid_bag("geometry_msgs/msg/PoseStamped", {"/pose"}, head + pose)), HasSubstr("has no topic of kind gnss"));
}

TEST(PoseText, TrajectoriesOfBenchmarks) {
  const ReadAid tum = read_aid_text("# timestamp tx ty tz qx qy qz qw\n12.25 1 2 3 0.5 -0.5 0.1 0.7\n", AidKind::pose);
  EXPECT_EQ(tum.format, "a trajectory of poses (TUM)");
  EXPECT_THAT(tum.record.time, ElementsAre(12 * second + second / 4));
  expect_pose(tum.record);
  const ReadAid euroc = read_aid_text(
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1]\n"
      "1403636580838555648, 1, 2, 3, 0.7, 0.5, -0.5, 0.1, 0.3\n",
      AidKind::pose);
  EXPECT_EQ(euroc.format, "ground truth (EuRoC)");
  EXPECT_THAT(euroc.record.time, ElementsAre(1403636580838555648));
  expect_pose(euroc.record);
  expect_pose(read_aid_text("t,x_m,y_m,z_m,qw,qx,qy,qz\n0,1,2,3,0.7,0.5,-0.5,0.1\n", AidKind::pose).record);
}

TEST(PoseText, WhatIsNoPoseIsNamed) {
  EXPECT_THAT(aid_text_error("1 2 3 4 0 0 0 1\n2 2 3 4 0 0 x 1\n", AidKind::pose),
              HasSubstr(":2: 2 2 3 4 0 0 x 1 is no pose; expected seconds x y z"));
  EXPECT_THAT(aid_text_error("1 2 3 4 0 0 0 2\n", AidKind::pose), HasSubstr(":1: quaternion: its length is 2; expected 1"));
  EXPECT_THAT(aid_text_error("1 2 3 4 0 0 0 1\n", AidKind::gnss),
              HasSubstr("is a trajectory of poses, and the aid's kind is gnss; expected kind = \"pose\""));
  EXPECT_THAT(aid_text_error("1 1e9 3 4 0 0 0 1\n", AidKind::pose), HasSubstr("position: 1e+09 m is out of range"));
  EXPECT_THAT(aid_text_error("t,qw,qx,qy,qz\n0,1,0,0,0\n", AidKind::pose), HasSubstr("expected qw, qx, qy, qz, and x_m, y_m, z_m"));
  const ReadAid cut = read_aid_text("1 2 3 4 0 0 0 1\n2 2 3 4 0", AidKind::pose);
  EXPECT_THAT(cut.record.time, ElementsAre(second));
  EXPECT_THAT(cut.warnings, ElementsAre(HasSubstr("the last line is cut off")));
}

}  // namespace
}  // namespace imulab::aid_io
