#include "imulab/error.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/alignment/rest_motion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace imulab {
namespace {

using namespace alignment;

/// Returns the attitude with roll and pitch of `C_nb` and this heading.
Matrix3d with_heading(const Matrix3d& C_nb, double heading) {
  check_has_heading(C_nb);  // before Euler angles become singular
  EulerAngles angles = euler_angles(C_nb);
  angles.heading = heading;
  return attitude_matrix(angles);
}

/// Returns C_nb at the start from the directions of gravity in both halves.
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

/// Returns C_nb at the start from the mean direction of gravity and the heading at the end.
Matrix3d from_heading(const RestMotion& rest, const CarriedRest& body, double heading) {
  Matrix3d C_n0 = Matrix3d::Identity();
  Vector3d up = Vector3d::Zero();
  for (const Vector3d& v : body.velocity) up += v;
  for (int pass = 0; pass < 3; ++pass) {  // the Earth's rotation during the rest depends on the heading, which depends on the level
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

/// The axes n are those at mid-rest, without rotation; e(t) is the accumulated angle error of the gyros, df the error of the accelerometers, D the
/// difference between the means of the second and the first half:
///   phi_E = mean e_E - df_N / g,  phi_N = mean e_N + df_E / g,  phi_U = (-D e_E + D df_N / g) / (w_N T / 2)  in the middle; then minus e(T / 2).
/// For constant errors, this is phi_U = phi_N tan L - dw_E / (w_ie cos L).
Matrix3d coarse_covariance(const RestMotion& rest, const Matrix3d& C_nb, const AlignmentSensors& sensors, const Densities& noise,
                           const std::optional<GivenHeading>& heading) {
  const double h = rest.duration / 2, north = rest.earth.y(), tan_latitude = rest.earth.z() / north, g = rest.gravity;
  const double gyro = noise.gyro * noise.gyro, accel = noise.accel * noise.accel / (g * g);
  Matrix3d from_gyro = Matrix3d::Zero(), from_accel = Matrix3d::Zero(), of_noise = Matrix3d::Zero();  // at mid-rest; biases
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
  if (heading) {  // phi_U follows from phi of the level and the error of the heading
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
                    "unit, in the recording's units, and does the IMU rest?)",
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

namespace {

using namespace alignment;

constexpr int states = 13;  // phi 3, horizontal velocity 2 and displacement 2, gyro bias 3, accelerometer bias 3
enum AlignmentState { phi = 0, velocity = 3, displacement = 5, gyro_bias = 7, accel_bias = 10 };
using Vector = Eigen::Matrix<double, states, 1>;
using Matrix = Eigen::Matrix<double, states, states>;
using Eigen::Vector2d;

/// A part of the rest between two updates, as measured by the sensors.
struct RestInterval {
  double duration = 0;
  Matrix3d C_nb = Matrix3d::Zero();          // mean
  Vector2d displacement = Vector2d::Zero();  // east and north at its end, relative to the start of the rest
  Vector2d velocity = Vector2d::Zero();      // at its end
};

/// Integrates at a known place: velocity and displacement do not act on the axes, so that their errors are exactly phi' = -w_ie x phi - C dw,  dv' =
/// g up x phi + C df,  ds' = dv  to first order in phi.
std::vector<RestInterval> integrate(const RestMotion& rest, const Matrix3d& C_start) {
  constexpr double most_updates = 120;
  const double length = std::max(1., rest.duration / most_updates);
  std::vector<RestInterval> blocks(1);
  Matrix3d C_nb = C_start;
  Vector3d v = Vector3d::Zero(), s = Vector3d::Zero();
  for (std::size_t i = 0; i < rest.steps.size(); ++i) {
    const double T = rest.intervals[i];
    Vector3d gain = C_nb * rest.steps[i].velocity;
    gain += T / 2 * gain.cross(rest.earth);
    gain.z() -= T * rest.gravity;
    s += T * (v + gain / 2);
    v += gain;
    C_nb = rotation_exp(-T * rest.earth) * C_nb * rotation_exp(rest.steps[i].rotation);
    RestInterval& block = blocks.back();
    block.duration += T;
    block.C_nb += T * C_nb;
    block.displacement = s.head<2>();
    block.velocity = v.head<2>();
    if (block.duration >= length - T / 2 && i + 1 < rest.steps.size()) blocks.emplace_back();
  }
  for (RestInterval& block : blocks) block.C_nb /= block.duration;
  return blocks;
}

struct Transition {
  Matrix Phi, Q;
};

Transition transition(const RestMotion& rest, const RestInterval& block, const Densities& noise) {
  Matrix F = Matrix::Zero();
  F.block<3, 3>(phi, phi) = -skew<double>(rest.earth);
  F.block<3, 3>(phi, gyro_bias) = -block.C_nb;
  F(velocity, phi + 1) = -rest.gravity;  // g up x phi
  F(velocity + 1, phi) = rest.gravity;
  F.block<2, 3>(velocity, accel_bias) = block.C_nb.topRows<2>();
  F.block<2, 2>(displacement, velocity).setIdentity();
  const Matrix F2 = F * F, F3 = F2 * F, F4 = F3 * F;
  const auto after = [&](double t) -> Matrix { return Matrix::Identity() + t * F + t * t / 2 * F2 + t * t * t / 6 * F3 + t * t * t * t / 24 * F4; };
  Vector density = Vector::Zero();
  density.segment<3>(phi).setConstant(noise.gyro * noise.gyro);
  density.segment<2>(velocity).setConstant(noise.accel * noise.accel);
  static constexpr std::array<double, 4> node{0.069431844202973712, 0.33000947820757187, 0.66999052179242813, 0.93056815579702629};
  static constexpr std::array<double, 4> weight{0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};
  Transition out{after(block.duration), Matrix::Zero()};
  for (std::size_t k = 0; k < node.size(); ++k) {
    const Matrix step = after(node[k] * block.duration);
    out.Q += weight[k] * block.duration * step * density.asDiagonal() * step.transpose();
  }
  return out;
}

struct Filtered {
  Vector x = Vector::Zero();
  Matrix P = Matrix::Zero();
  std::vector<Vector2d> innovations;  // normalized
  double mean_square() const {        // without the part absorbed by initially unknown displacement, velocity and attitude
    double sum = 0;
    for (const Vector2d& e : innovations) sum += e.squaredNorm();
    return sum / (2 * static_cast<double>(innovations.size()) - 7);
  }
};

template <int Rows>
Eigen::Matrix<double, Rows, 1> update(Filtered& f, const Eigen::Matrix<double, Rows, states>& H, const Eigen::Matrix<double, Rows, 1>& z,
                                      double variance) {
  using Square = Eigen::Matrix<double, Rows, Rows>;
  const Square R = variance * Square::Identity();
  const Eigen::LLT<Square> S(H * f.P * H.transpose() + R);
  const Eigen::Matrix<double, Rows, 1> innovation = z - H * f.x;
  const Eigen::Matrix<double, states, Rows> K = S.solve(H * f.P).transpose();
  f.x += K * innovation;
  const Matrix rest = Matrix::Identity() - K * H;
  f.P = (rest * f.P * rest.transpose() + K * R * K.transpose()).eval();
  return S.matrixL().solve(innovation);
}

Filtered filter(const std::vector<RestInterval>& blocks, const std::vector<Transition>& transitions, const AlignmentSensors& sensors, double base) {
  Filtered f;
  Vector sigma;  // so wide that only the rest matters
  sigma << 0.1, 0.1, std::numbers::pi, 1, 1, 10, 10, Eigen::Matrix<double, 6, 1>::Zero();
  f.P.diagonal() = sigma.cwiseAbs2();
  f.P.block<3, 3>(gyro_bias, gyro_bias) = sensors.gyro_bias;
  f.P.block<3, 3>(accel_bias, accel_bias) = sensors.accel_bias;
  Eigen::Matrix<double, 2, states> H = Eigen::Matrix<double, 2, states>::Zero();
  H.block<2, 2>(0, displacement).setIdentity();
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    f.x = (transitions[k].Phi * f.x).eval();
    f.P = (transitions[k].Phi * f.P * transitions[k].Phi.transpose() + transitions[k].Q).eval();
    f.innovations.push_back(update<2>(f, H, blocks[k].displacement, base * base));
  }
  return f;
}

constexpr double least_displacement = 1e-6, most_displacement = 10;  // m, of the base

/// Returns the displacement of the base (one sigma) for which the innovations have their expected size.
double base_displacement(const std::vector<RestInterval>& blocks, const std::vector<Transition>& transitions, const AlignmentSensors& sensors) {
  const auto square = [&](double base) { return filter(blocks, transitions, sensors, base).mean_square(); };
  if (square(least_displacement) < 1 + 2 / std::sqrt(static_cast<double>(blocks.size()))) return least_displacement;
  if (square(most_displacement) > 1)
    throw Unsupported(
        fmt::format("alignment: not even a base that moves by {:.0f} m explains what the sensors give: the IMU does not rest, or the "
                    "calibration is not this unit's",
                    most_displacement));
  double low = std::log(least_displacement), high = std::log(most_displacement);
  for (int i = 0; i < 12; ++i) {
    const double middle = (low + high) / 2;
    (square(std::exp(middle)) > 1 ? low : high) = middle;
  }
  return std::exp((low + high) / 2);
}

double correlation(const std::vector<Vector2d>& e) {
  double product = 0, square = 0;
  for (std::size_t k = 0; k < e.size(); ++k) {
    if (k > 0) product += e[k].dot(e[k - 1]);
    square += e[k].squaredNorm();
  }
  return square > 0 ? product / square : 0;
}

}  // namespace

FineAlignment fine_alignment(std::span<const TimedIncrement> samples, const AlignmentSite& site, const AlignmentSensors& sensors,
                             const std::optional<GivenHeading>& heading) {
  Matrix3d C_nb = coarse_alignment(samples, site, sensors, heading).C_nb;
  const RestMotion rest = rest_motion(samples, site);
  const Matrix3d C_0b = carried(rest).C_0b;
  const Densities noise = densities(rest, sensors);
  FineAlignment out;
  out.gyro_noise = noise.gyro;
  out.accel_noise = noise.accel;
  Filtered f;
  for (int pass = 0; pass < 2; ++pass) {  // the second pass is about the first result, from the same wide start
    const std::vector<RestInterval> blocks = integrate(rest, rest.turned_back(rest.duration) * C_nb * C_0b.transpose());
    std::vector<Transition> transitions;
    for (const RestInterval& block : blocks) transitions.push_back(transition(rest, block, noise));
    if (pass == 0) out.base_displacement = base_displacement(blocks, transitions, sensors);
    f = filter(blocks, transitions, sensors, out.base_displacement);
    if (heading) {
      Eigen::Matrix<double, 1, states> H = Eigen::Matrix<double, 1, states>::Zero();
      H.segment<3>(phi) = heading_gradient(C_nb);
      const double off = std::remainder(heading->value - euler_angles(C_nb).heading, 2 * std::numbers::pi);
      update<1>(f, H, Eigen::Matrix<double, 1, 1>(off), std::max(heading->sigma * heading->sigma, 1e-16));
    }
    out.base_velocity = blocks.back().velocity - f.x.segment<2>(velocity);
    C_nb = rotation_exp(f.x.segment<3>(phi)) * C_nb;
  }
  out.attitude = {orthonormalized(C_nb), f.P.block<3, 3>(phi, phi)};
  out.innovation_square = f.mean_square();
  out.innovation_correlation = correlation(f.innovations);
  out.updates = f.innovations.size();
  out.gyro_bias = f.x.segment<3>(gyro_bias);
  out.accel_bias = f.x.segment<3>(accel_bias);
  out.gyro_bias_covariance = f.P.block<3, 3>(gyro_bias, gyro_bias);
  out.accel_bias_covariance = f.P.block<3, 3>(accel_bias, accel_bias);
  return out;
}

}  // namespace imulab
