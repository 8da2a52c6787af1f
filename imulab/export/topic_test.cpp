// The topic of the IMU in the files of Kalibr and OpenVINS.
#include "imulab/exchange.hpp"

#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include <yaml-cpp/yaml.h>

namespace imulab::export_test {
namespace {

std::string topic_in(const std::string& target, const Calibration& calibration, const std::string& chosen) {
  const ImuNoise noise = some_noise();
  ExportInput input{calibration, &noise, {}};
  input.options.topic = chosen;
  std::string text = export_target(target).text(input);
  if (text.starts_with("%YAML:1.0")) text[0] = '#';
  YAML::Node imu = YAML::Load(text);
  if (imu["imu0"]) imu.reset(YAML::Node(imu["imu0"]));
  return imu["rostopic"].as<std::string>();
}

TEST(ExportTopic, IsTheChosenOneOrTheRecordings) {
  Calibration c = si_unit();
  for (const char* target : {"kalibr-imu", "kalibr", "openvins"}) {
    c.sources.clear();
    EXPECT_EQ(topic_in(target, c, ""), "/imu0") << target;
    c.sources.resize(2);
    c.sources[1].topic = "/imu/data_raw";
    EXPECT_EQ(topic_in(target, c, ""), "/imu/data_raw") << target;
    EXPECT_EQ(topic_in(target, c, "/other"), "/other") << target;
    for (const char* hostile : {"/a: b\nupdate_rate: 1", "\"x\\", "imu # no", "[1, 2]", "*a"})
      EXPECT_EQ(topic_in(target, c, hostile), hostile) << target;
  }
}

}  // namespace
}  // namespace imulab::export_test
