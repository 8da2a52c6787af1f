// RealSense cameras (IntelRealSense/librealsense, commit cacc8e701: tools/rs-imu-calibration/rs-imu-calibration.py writes calibration.json;
// src/ds/motion-transform.cpp corrects): corrected = sensitivity reading - bias, single precision, along the depth camera's axes. The nine numbers of
// scale_and_alignment are the matrix by columns, in the file as in the camera's table, where the gyros' bias is in deg/s (ds-calib-parsers.cpp).
#include "imulab/export/device_axes.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"
#include "imulab/formats/text/json.hpp"

namespace imulab::export_io {

namespace {

constexpr Held realsense_holds{.accel_matrix = true, .gyro_matrix = true, .accel_scale = true, .gyro_scale = true, .bias = true};

JsonFields realsense_triad(const ConsumerTriad& m) {
  std::vector<double> by_columns, bias;
  for (Eigen::Index k = 0; k < 9; ++k) by_columns.push_back(m.C(k % 3, k / 3) + 0.0);
  const Vector3d output_bias = m.C * m.b;
  for (Eigen::Index i = 0; i < 3; ++i) bias.push_back(output_bias[i] + 0.0);
  return {{{"scale_and_alignment", by_columns}, {"bias", bias}}};
}

}  // namespace

std::string realsense_text(const ExportInput& input) {
  const Calibration& c = input.calibration;
  expect_si_readings(c.model);
  const ConsumerModel m = consumer_model(along_device_axes(c.model, device_axes(c)));
  Sentences equations{
      "Calibration of " + (c.imu.empty() ? "an unnamed IMU" : plain(c.imu)) + ", in the form of rs-imu-calibration's calibration.json",
      "corrected = C reading - bias [m/s^2, rad/s]; scale_and_alignment is C by columns: C_11, C_21, C_31, C_12, ...",
      "readings: of librealsense with enable_motion_correction off, along x right, y down, z forward; corrected ones likewise",
      "the camera's own table has the same numbers, but the gyros' bias in deg/s: librealsense multiplies it by pi/180"};
  const Sentences more = input_facts(c);
  equations.insert(equations.end(), more.begin(), more.end());
  const JsonFields imu{{{"accelerometer", realsense_triad(m.accel)}, {"gyroscope", realsense_triad(m.gyro)}}};
  return json_text(JsonFields{{{"device_type", "D435i"},
                               {"imus", std::vector<JsonValue>{imu}},
                               {"equations", equations},
                               {"not_determined", not_determined(c)},
                               {"not_held", left_out_of_realsense(input)}}},
                   JsonLayout::long_lists);
}

Sentences left_out_of_realsense(const ExportInput& input) { return losses(input.calibration.model, realsense_holds); }

}  // namespace imulab::export_io
