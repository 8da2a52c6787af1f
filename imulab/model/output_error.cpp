#include "imulab/model/output_error.hpp"

namespace imulab {

SensorModel without_error(const SensorModel& model, const SensorModel& error) {
  const Matrix3d one = Matrix3d::Identity(), keep_accel = one - error.accel.matrix, keep_gyro = one - error.gyro.matrix;
  SensorModel out = model;
  out.accel.offset = keep_accel * model.accel.offset - error.accel.offset;
  out.accel.matrix = keep_accel * model.accel.matrix;
  // The g-sensitivity is fed with the corrected force.
  out.gyro.offset = keep_gyro * (model.gyro.offset + model.g_sensitivity * error.accel.offset) - error.gyro.offset;
  out.gyro.matrix = keep_gyro * model.gyro.matrix;
  out.g_sensitivity = keep_gyro * model.g_sensitivity * (one + error.accel.matrix) - error.g_sensitivity;
  out.lever_arm += error.lever_arm;
  for (Eigen::Index i = 0; i < 3; ++i) {  // q (a0 + a1 V)^2
    const double q = error.accel.quadratic[i], a0 = model.accel.offset[i], a1 = model.accel.matrix(i, i);
    out.accel.offset[i] -= q * a0 * a0;
    out.accel.matrix(i, i) -= 2 * q * a0 * a1;
    out.accel.quadratic[i] -= q * a1 * a1;
  }
  return out;
}

}  // namespace imulab
