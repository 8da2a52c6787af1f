#include "imulab/core/nearest_name.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

TEST(NearestName, IsWhatWasMeant) {
  const std::vector<std::string> verbs{"inspect", "calibrate", "compensate", "noise"};
  EXPECT_EQ(did_you_mean("calibrat", verbs), "; did you mean calibrate?");
  EXPECT_EQ(did_you_mean("nosie", verbs), "; did you mean noise?");
  EXPECT_EQ(did_you_mean("weather", verbs), "");
  EXPECT_EQ(did_you_mean(std::string(1000, 'a'), verbs), "");
}

}  // namespace
}  // namespace imulab
