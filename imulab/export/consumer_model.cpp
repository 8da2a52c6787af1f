#include "imulab/export/consumer_model.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/error.hpp"

#include <Eigen/Geometry>

#include <utility>

namespace imulab::export_io {

namespace {

ConsumerTriad consumer_triad(const TriadModel& m, const char* name) {
  if (!m.all_finite()) throw Error(std::string(name) + ": numbers that are not finite; expected a complete calibration");
  const auto inverse = regular_inverse(m.matrix);
  if (!inverse) throw Error(std::string(name) + ".matrix: is singular; expected a matrix with an inverse");
  ConsumerTriad triad{m.matrix, *inverse, {}};
  triad.b = -triad.T * m.offset;
  return triad;
}

}  // namespace

ConsumerModel consumer_model(const SensorModel& model) {
  if (!model.g_sensitivity.allFinite()) throw Error("gyro.g_sensitivity: numbers that are not finite; expected a complete calibration");
  ConsumerModel out{consumer_triad(model.accel, "accel"), consumer_triad(model.gyro, "gyro"), {}};
  out.G = -out.gyro.T * model.g_sensitivity;
  return out;
}

SensorModel sensor_model(const Matrix3d& C_a, const Vector3d& b_a, const Matrix3d& C_g, const Vector3d& b_g, const Matrix3d& G) {
  SensorModel m;
  m.accel.matrix = C_a;
  m.accel.offset = -C_a * b_a;
  m.gyro.matrix = C_g;
  m.gyro.offset = -C_g * b_g;
  m.g_sensitivity = -C_g * G;
  return m;
}

void expect_si_readings(const SensorModel& model) {
  for (const auto& [triad, name, si] : {std::tuple{&model.accel, "accelerometers", "m/s^2"}, std::tuple{&model.gyro, "gyros", "rad/s"}})
    if (!triad->raw_unit.empty() && triad->raw_unit != si)
      throw Error(std::string("the ") + name + "' readings are in " + (triad->raw_unit == "count" ? "counts" : "another unit than SI") +
                  "; expected " + si + ", which this target reads: calibrate a recording in SI units, or export to c-header, json-matrix or csv");
}

TriangularFactors lower_factors(const Matrix3d& T) {
  // Gram-Schmidt on the rows, from the first: row i of T is a combination of the first i rows of Q. Twice, which makes Q orthogonal to rounding.
  TriangularFactors f{Matrix3d::Zero(), Matrix3d::Zero()};
  for (int i = 0; i < 3; ++i) {
    Vector3d row = T.row(i).transpose();
    for (int round = 0; round < 2; ++round)
      for (int j = 0; j < i; ++j) row -= f.Q.row(j).dot(row) * f.Q.row(j).transpose();
    f.Q.row(i) = row.normalized().transpose();
  }
  f.triangle = T * f.Q.transpose();
  for (int i = 0; i < 3; ++i)
    for (int j = i + 1; j < 3; ++j) f.triangle(i, j) = 0;  // rounding
  return f;
}

TriangularFactors upper_factors(const Matrix3d& T) {
  const TriangularFactors reversed = lower_factors(T.rowwise().reverse().colwise().reverse());
  return {reversed.triangle.rowwise().reverse().colwise().reverse(), reversed.Q.rowwise().reverse().colwise().reverse()};
}

void expect_right_handed(const ConsumerModel& model) {
  for (const auto& [triad, name] : {std::pair{&model.accel, "accelerometers"}, std::pair{&model.gyro, "gyros"}})
    if (triad->T.determinant() < 0)
      throw Error(std::string("the ") + name + "' axes form a left-handed triad; expected a right-handed one, since this target has only rotations");
}

}  // namespace imulab::export_io
