#include "imulab/core/nearest_name.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

TEST(NearestName, IsWhatWasMeant) {
  const std::vector<std::string> verbs{"inspect", "calibrate", "compensate", "noise"};
  EXPECT_EQ(did_you_mean("calibrat", verbs), "; did you mean calibrate?");
  EXPECT_EQ(did_you_mean("nosie", verbs), "; did you mean noise?");
  EXPECT_EQ(did_you_mean("comp", verbs), "; did you mean compensate?");
  EXPECT_EQ(did_you_mean("ca", verbs), "");
  EXPECT_EQ(did_you_mean("lat", std::vector<std::string>{"latitude_sigma_deg", "latitude_deg"}), "; did you mean latitude_deg?");
  EXPECT_EQ(did_you_mean("--out", std::vector<std::string>{"--set", "--output"}), "; did you mean --output?");
  EXPECT_EQ(did_you_mean("--o", std::vector<std::string>{"--output"}), "");
  EXPECT_EQ(expected_name("nosie", verbs), "; did you mean noise?");
  EXPECT_EQ(expected_name("weather", verbs), "; expected one of inspect, calibrate, compensate, noise");
  EXPECT_EQ(did_you_mean("weather", verbs), "");
  EXPECT_EQ(did_you_mean(std::string(1000, 'a'), verbs), "");
}

}  // namespace
}  // namespace imulab
