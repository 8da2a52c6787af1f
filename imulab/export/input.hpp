// The input of an export target: a calibration, possibly the noise of the IMU, and the user's choices.
#pragma once

#include "imulab/model/calibration.hpp"
#include "imulab/model/imu_noise.hpp"

#include <optional>
#include <string>

namespace imulab {

/// Where a target has one number for three axes.
enum class AxisChoice { worst, mean };

struct ExportOptions {
  AxisChoice axes = AxisChoice::worst;
  bool variance_matched = false;     ///< vins: white noise that makes the covariance of its code right, instead of the standard deviation of a sample
  std::string imu_model = "kalibr";  ///< openvins: "kalibr" or "rpng"
  std::optional<double> rate_hz;     ///< of the stream; absent: that of the noise log
  int instance = 0;                  ///< px4, ardupilot: which of the autopilot's IMUs, from 0
  std::string prefix = "imulab";     ///< c-header: with which its names begin
  std::string topic{};               ///< kalibr, openvins: of the IMU; empty: that of the calibration's recording, else /imu0
};

struct ExportInput {
  const Calibration& calibration;
  const ImuNoise* noise = nullptr;  ///< null: not known
  ExportOptions options{};
};

}  // namespace imulab
