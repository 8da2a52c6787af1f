#include "imulab/navigation/alignment/alignment.hpp"

#include "imulab/core/error.hpp"
#include "imulab/navigation/alignment/rest_motion.hpp"
#include "imulab/navigation/integration/attitude.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <array>
#include <cmath>

namespace imulab {
namespace {

using namespace alignment;

/// The roll and pitch of `C_nb`, with this heading.
Matrix3d with_heading(const Matrix3d& C_nb, double heading) {
  check_has_heading(C_nb);  // before Euler angles spoil it
  EulerAngles angles = euler_angles(C_nb);
  angles.heading = heading;
  return attitude_matrix(angles);
}

/// C_nb at the start, from both halves' directions of gravity.
Matrix3d from_two_halves(const RestMotion& rest, const CarriedRest& body) {
  std::array<Vector3d, 2> measured{Vector3d::Zero(), Vector3d::Zero()}, known = measured;
  std::array<double, 2> length{0, 0};
  double t = 0;
  for (std::size_t i = 0; i < rest.steps.size(); ++i) {
    const double interval = rest.intervals[i];
    const std::size_t half = t + interval / 2 < rest.duration / 2 ? 0 : 1;
    measured[half] += body.velocity[i];
    known[half] += interval * rest.turned_back(t + interval / 2).col(2);
    length[half] += interval;
    t += interval;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    measured[k] /= length[k];
    known[k] /= length[k];
  }
  return rotation_from_directions(known[0] + known[1], known[1] - known[0], measured[0] + measured[1], measured[1] - measured[0]);
}

/// C_nb at the start from the mean direction of gravity and the heading at the end.
Matrix3d from_heading(const RestMotion& rest, const CarriedRest& body, double heading) {
  Matrix3d C_n0 = Matrix3d::Identity();
  Vector3d up = Vector3d::Zero();
  for (const Vector3d& v : body.velocity) up += v;
  for (int pass = 0; pass < 3; ++pass) {  // the turn of the Earth during the rest needs the heading, which needs the levels
    if (pass > 0) {
      up.setZero();
      double t = 0;
      for (std::size_t i = 0; i < rest.steps.size(); ++i) {
        up += rest.turned_back(-(t + rest.intervals[i] / 2)) * (C_n0 * body.velocity[i]);
        t += rest.intervals[i];
      }
    }
    C_n0 = shortest_rotation(up, Vector3d::UnitZ()) * C_n0;
    const Matrix3d C_nb = with_heading(rest.turned_back(-rest.duration) * C_n0 * body.C_0b, heading);
    C_n0 = rest.turned_back(rest.duration) * C_nb * body.C_0b.transpose();
  }
  return C_n0;
}

/// With the axes n of the middle kept from turning, e(t) the angle that the gyros' error has gathered since, df the accelerometers' error, and a
/// difference D between the means of the second and the first half:
///   phi_E = mean e_E - df_N / g,  phi_N = mean e_N + df_E / g,  phi_U = (-D e_E + D df_N / g) / (w_N T / 2)  in the middle; then less e(T / 2).
/// For constant errors that is phi_U = phi_N tan L - dw_E / (w_ie cos L).
Matrix3d coarse_covariance(const RestMotion& rest, const Matrix3d& C_nb, const AlignmentSensors& sensors, const Densities& noise,
                           const std::optional<GivenHeading>& heading) {
  const double h = rest.duration / 2, north = rest.earth.y(), tan_latitude = rest.earth.z() / north, g = rest.gravity;
  const double gyro = noise.gyro * noise.gyro, accel = noise.accel * noise.accel / (g * g);
  Matrix3d from_gyro = Matrix3d::Zero(), from_accel = Matrix3d::Zero(), of_noise = Matrix3d::Zero();  // in the middle; biases
  from_accel(0, 1) = -1 / g;
  from_accel(1, 0) = 1 / g;
  if (!heading) {
    from_accel(2, 0) = tan_latitude / g;
    from_gyro(2, 0) = -1 / north;
  }
  from_gyro -= h * Matrix3d::Identity();
  of_noise.diagonal() << gyro * 2 * h / 3 + accel / (2 * h), gyro * 2 * h / 3 + accel / (2 * h), gyro * h;
  if (!heading) {
    of_noise(2, 2) += (gyro * 2 * h / 3 + 2 * accel / h) / (north * north * h * h);
    of_noise(0, 2) = of_noise(2, 0) = gyro / (2 * north);
  }
  const Matrix3d turn = rotation_exp(-h * rest.earth);
  const Matrix3d gyro_bias = C_nb * sensors.gyro_bias * C_nb.transpose(), accel_bias = C_nb * sensors.accel_bias * C_nb.transpose();
  Matrix3d P =
      turn * (from_gyro * gyro_bias * from_gyro.transpose() + from_accel * accel_bias * from_accel.transpose() + of_noise) * turn.transpose();
  if (heading) {  // phi_U follows from the levels' phi and the heading's error
    Matrix3d J = Matrix3d::Identity();
    J.row(2) = heading_gradient(C_nb);
    J(2, 2) = 0;
    P = (J * P * J.transpose()).eval();
    P(2, 2) += heading->sigma * heading->sigma;
  }
  return P;
}

Matrix3d start_attitude(const RestMotion& rest, const CarriedRest& body, const std::optional<GivenHeading>& heading) {
  Vector3d force = Vector3d::Zero();
  for (const Vector3d& v : body.velocity) force += v / rest.duration;
  if (std::abs(force.norm() - rest.gravity) > 0.05 * rest.gravity)
    throw Error(
        fmt::format("alignment: the mean specific force at rest is {:.5g} m/s^2, expected {:.5g} within 5 % (is the calibration that of this "
                    "unit, in the recording's units, and does the unit rest?)",
                    force.norm(), rest.gravity));
  return heading ? from_heading(rest, body, heading->value) : from_two_halves(rest, body);
}

Matrix3d end_attitude(const RestMotion& rest, const CarriedRest& body, const Matrix3d& C_n0) {
  return rest.turned_back(-rest.duration) * C_n0 * body.C_0b;
}

}  // namespace

Alignment coarse_alignment(std::span<const TimedIncrement> samples, const AlignmentSite& site, const AlignmentSensors& sensors,
                           const std::optional<GivenHeading>& heading) {
  const RestMotion rest = rest_motion(samples, site);
  const CarriedRest body = carried(rest);
  const Matrix3d C_nb = end_attitude(rest, body, start_attitude(rest, body, heading));
  return {C_nb, coarse_covariance(rest, C_nb, sensors, densities(rest, sensors), heading)};
}

}  // namespace imulab
