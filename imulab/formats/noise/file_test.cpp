#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/results/noise.hpp"

#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <cmath>

namespace imulab {
namespace {

std::string written() {
  NoiseAnalysis analysis;
  analysis.recording = "night.csv";
  analysis.interval_s = 0.01;
  std::vector<double> rate(4096);
  RandomStream(1, "noise of a test").normals(0, rate);
  for (const char* name : {"gyro.x", "gyro.y", "gyro.z", "accel.x", "accel.y", "accel.z"}) {
    NoiseAxis axis;
    axis.name = name;
    axis.unit = name[0] == 'g' ? "rad/s" : "m/s^2";
    if (axis.name != "accel.y") axis.fit = fit_noise(rate, 0.01);
    analysis.axes.push_back(axis);
  }
  return noise_json(analysis);
}

TEST(NoiseReader, ReadsWhatIsWritten) {
  const TemporaryFolder folder;
  folder.write("noise.json", written());
  const ImuNoise noise = read_noise((folder / "noise.json").string());
  EXPECT_EQ(noise.recording, "night.csv");
  EXPECT_EQ(noise.accel_unit, "m/s^2");
  EXPECT_FALSE(noise.accel[1]);
  ASSERT_TRUE(noise.gyro[2]);
  EXPECT_TRUE(noise.gyro[2]->N.determined);
  EXPECT_NEAR(noise.gyro[2]->N.value, 0.1, 0.01) << "sigma sqrt(interval), of 4096 numbers";
  EXPECT_FALSE(noise.gyro[2]->K.determined);
  EXPECT_TRUE(std::isnan(noise.gyro[2]->K.value));
  EXPECT_GT(noise.gyro[2]->K.upper, 0);
}

TEST(NoiseReader, ReadsAScaleWithoutAnUpperBound) {
  const TemporaryFolder folder;
  std::string text = written();
  const std::string process =
      "\"markov\": [{\"sigma\": {\"value\": 1, \"standard_uncertainty\": 0.1, \"lower\": 0.8, \"upper\": 1.2, \"determined\": true}, "
      "\"time\": {\"value\": 50, \"standard_uncertainty\": null, \"lower\": 20, \"upper\": null, \"determined\": true}}]";
  const std::string none = "\"markov\": []";
  ASSERT_NE(text.find(none), std::string::npos);
  folder.write("noise.json", text.replace(text.find(none), none.size(), process));
  const ImuNoise noise = read_noise((folder / "noise.json").string());
  ASSERT_EQ(noise.gyro[0]->markov.size(), 1u);
  EXPECT_EQ(noise.gyro[0]->markov[0].time.value, 50);
  EXPECT_TRUE(std::isinf(noise.gyro[0]->markov[0].time.upper));
}

TEST(NoiseReader, NamesFileAndField) {
  const TemporaryFolder folder;
  const auto message_of = [&](const std::string& text) -> std::string {
    folder.write("noise.json", text);
    try {
      read_noise((folder / "noise.json").string());
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  const auto with = [](std::string text, const std::string& from, const std::string& to) { return text.replace(text.find(from), from.size(), to); };
  EXPECT_THAT(message_of("{}"), testing::HasSubstr("noise.json: expected \"format\": \"imulab.noise/1\""));
  EXPECT_THAT(message_of(written().substr(0, 5000)), testing::HasSubstr("not JSON"));
  EXPECT_THAT(message_of(with(written(), "\"gyro.y\"", "\"gyro.w\"")), testing::HasSubstr("axes[1].name: expected gyro.x to accel.z"));
  EXPECT_THAT(message_of(with(written(), "\"K\":", "\"k\":")), testing::HasSubstr("axes[0].coefficients.K: is missing"));
  EXPECT_THAT(message_of(with(written(), "\"determined\": false", "\"determined\": true")), testing::HasSubstr("is determined without a value"));
}

}  // namespace
}  // namespace imulab
