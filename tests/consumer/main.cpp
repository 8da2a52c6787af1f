#include <cstdio>
#include <imulab/model/compensate.hpp>

int main() {
  imulab::SensorModel model;
  model.accel.matrix.diagonal() << 0.5, 0.25, 2;
  model.gyro.offset << 1, 2, 3;
  const imulab::Motion motion = compensate(model, imulab::RawSample{{2, 4, 8}, {10, 20, 30}});
  std::printf("%g %g %g %g %g %g\n", motion.force.x(), motion.force.y(), motion.force.z(), motion.rate.x(), motion.rate.y(), motion.rate.z());
}
