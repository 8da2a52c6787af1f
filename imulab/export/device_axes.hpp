// A calibration's model has readings along the body axes; a program that takes a device's own readings has them along the device's axes, which the
// calibration knows as `recorded`.
#pragma once

#include "imulab/export/consumer_model.hpp"

#include <string>
#include <vector>

namespace imulab::export_io {

/// P of u_body = P u_device: each row and each column has one element, 1 or -1. The identity where the recording's axes are not known.
struct DeviceAxes {
  Matrix3d accel = Matrix3d::Identity(), gyro = Matrix3d::Identity();
  bool turned() const { return !accel.isIdentity(0) || !gyro.isIdentity(0); }
};
/// Throws Error where an axis is named that is none, or one twice.
DeviceAxes device_axes(const Calibration& calibration);

/// For the device's readings; the outputs stay along the body axes: C' = C P, T' = P^T T, b' = P^T b, G' = P_g^T G. Throws Error as consumer_model.
ConsumerModel device_model(const SensorModel& model, const DeviceAxes& axes);

/// For a program that corrects the readings of one axis after another: readings and outputs along the device's axes. C' = P^T C P, and so on.
SensorModel along_device_axes(const SensorModel& model, const DeviceAxes& axes);

/// For the head of a file: along which body axes the readings come, and in which unit the recording had them where that is not SI.
std::vector<std::string> input_facts(const Calibration& calibration);

}  // namespace imulab::export_io
