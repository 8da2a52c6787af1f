#include "imulab/recording/gyro_saturation.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace imulab {
namespace {

TEST(GyroSaturation, IsNotThatOfTheAccelerometers) {
  std::vector<double> t;
  Columns3 gyro, accel;
  for (int i = 0; i < 100; ++i) {
    t.push_back(0.01 * i);
    for (std::size_t axis = 0; axis < 3; ++axis)
      gyro[axis].push_back(200 * std::sin(0.1 * i + static_cast<double>(axis))), accel[axis].push_back(axis == 2 ? 9.8 : 0);
  }
  const RecordingOptions options{.gyro = {.unit = "deg/s", .limits = {{-250, 250}}}, .accel = {.limits = {{-30, 30}}}};
  EXPECT_THAT(GyroSaturation(make_recording(t, gyro, accel, options)).samples(), testing::IsEmpty());
  accel[0][7] = 31, accel[1][80] = -30, gyro[2][80] = -251, gyro[1][90] = 250;
  const Recording r = make_recording(t, gyro, accel, options);
  EXPECT_THAT(r.saturated, testing::ElementsAre(7, 80, 90));
  const GyroSaturation of_gyro(r);
  EXPECT_THAT(of_gyro.samples(), testing::ElementsAre(80, 90));
  EXPECT_EQ(of_gyro.in({0, 80}), 0U);
  EXPECT_EQ(of_gyro.in({80, 90}), 1U);
}

}  // namespace
}  // namespace imulab
