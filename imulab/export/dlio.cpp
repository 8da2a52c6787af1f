// DLIO (vectr-ucla/direct_lidar_inertial_odometry, commit fc8d183: src/dlio/odom.cc, cfg/dlio.yaml): a = sm a_m - bias, w = w_m - bias, along the
// IMU's own axes, in single precision. DLIO has no noise of the IMU.
#include "imulab/export/device_axes.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

constexpr Held dlio_holds{.accel_matrix = true, .accel_scale = true, .bias = true};

std::string float_list(const Vector3d& v) { return fmt::format("{}, {}, {}", float_text(v[0]), float_text(v[1]), float_text(v[2])); }

}  // namespace

std::string dlio_text(const ExportInput& input) {
  expect_si_readings(input.calibration.model);
  const ConsumerModel m = consumer_model(along_device_axes(input.calibration.model, device_axes(input.calibration)));
  const Vector3d bias = m.accel.C * m.accel.b;
  Sentences facts{"Holds: accelerometers' matrix and biases, gyros' biases: a = sm a_m - bias [m/s^2], w = w_m - bias [rad/s].",
                  "Input and output: along the IMU's own axes; the extrinsics turn them.",
                  "odom/imu/calibration is off: at start DLIO would replace the biases by means at rest, those of readings without sm."};
  const Sentences more = input_facts(input.calibration);
  facts.insert(facts.end(), more.begin(), more.end());
  std::string sm;
  for (int i = 0; i < 3; ++i) sm += (i > 0 ? ",\n                " : "") + float_list(m.accel.C.row(i).transpose());
  return comment_head(input, "DLIO", facts, left_out_of_dlio(input)) +
         fmt::format(
             "dlio:\n  imu:\n    calibration: true\n    intrinsics:\n      accel:\n        bias: [{}]\n        sm:   [{}]\n      gyro:\n        "
             "bias: [{}]\n"
             "  odom:\n    imu:\n      calibration:\n        accel: false\n        gyro: false\n",
             float_list(bias), sm, float_list(m.gyro.b));
}

Sentences left_out_of_dlio(const ExportInput& input) { return losses(input.calibration.model, dlio_holds); }

}  // namespace imulab::export_io
