// The white noise of the rests, which every method of one recording writes into its calibration.
#include "imulab/estimate/kernel/rest_noise.hpp"

#include "imulab/estimate/method.hpp"
#include "imulab/files.hpp"
#include "imulab/tasks/simulate.hpp"

#include <gmock/gmock.h>

#include <vector>

namespace imulab {
namespace {

TEST(RestNoise, IsTheWhiteNoiseThatWasSimulated) {
  for (const char* name : {"handheld", "turntable", "hybrid"}) {
    Session session = method(name).example({});
    session.imu.accel_noise_density = 2e-3, session.imu.gyro_noise_density = 1e-4;
    const Simulation simulated = simulate_session(session, {.seed = 1});
    const Calibration c = calibrate(name, {simulated.session, simulated.recordings}).calibration;
    ASSERT_TRUE(c.rest_noise) << name;
    for (const int axis : {0, 1, 2}) {
      EXPECT_NEAR(c.rest_noise->accel[axis], 2e-3, 2e-4) << name;
      EXPECT_NEAR(c.rest_noise->gyro[axis], 1e-4, 1e-5) << name;
    }
    EXPECT_GT(c.rest_noise->rests, 8) << name;
    EXPECT_DOUBLE_EQ(c.rest_noise->interval_s, simulated.recordings.front().interval_s) << name;
    EXPECT_EQ(parse_calibration(calibration_text(c), "c.json").rest_noise, c.rest_noise) << name;
  }
}

TEST(RestNoise, SecondsOfRecordingsAddUp) {
  const Simulation simulated = simulate_session(method("handheld").example({}), {.seed = 1});
  std::vector<Recording> two = simulated.recordings;
  two.push_back(two.front());
  const Calibration c = calibrate("handheld", {simulated.session, simulated.recordings}).calibration;
  const auto once = kernel::rest_noise(c, {simulated.session, simulated.recordings}), twice = kernel::rest_noise(c, {simulated.session, two});
  ASSERT_TRUE(once && twice);
  EXPECT_NEAR(twice->seconds, 2 * once->seconds, 1e-9);
  EXPECT_EQ(twice->rests, 2 * once->rests);
}

}  // namespace
}  // namespace imulab
