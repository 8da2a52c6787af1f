#include "imulab/navigation/budget/error_dynamics.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/navigation/integration/local_earth.hpp"

#include <cmath>
#include <numbers>

namespace imulab::budget {

using Index = ErrorIndex;

ErrorState error_of(const NavigationState& computed, const NavigationState& truth) {
  const LocalEarth earth = local_earth(truth.latitude, truth.height);
  const double longitude = std::remainder(computed.longitude - truth.longitude, 2 * std::numbers::pi);
  ErrorState x;
  x.segment<3>(Index::attitude) = -rotation_log((computed.q_nb * truth.q_nb.conjugate()).toRotationMatrix());
  x.segment<3>(Index::velocity) = computed.velocity - truth.velocity;
  x.segment<3>(Index::position) << longitude * earth.transverse_radius * earth.cos_latitude,
      (computed.latitude - truth.latitude) * earth.meridian_radius, computed.height - truth.height;
  x[Index::barometer] = 0;
  return x;
}

NavigationState with_error(const NavigationState& truth, const ErrorState& error) {
  const LocalEarth earth = local_earth(truth.latitude, truth.height);
  NavigationState out = truth;
  out.q_nb = Eigen::Quaterniond(rotation_exp(-error.segment<3>(Index::attitude))) * truth.q_nb;
  out.velocity += error.segment<3>(Index::velocity);
  out.longitude += error[Index::position] / (earth.transverse_radius * earth.cos_latitude);
  out.latitude += error[Index::position + 1] / earth.meridian_radius;
  out.height += error[Index::up];
  return out;
}

namespace {

/// Terms that vary with place and velocity: w_in_n, and the acceleration without the specific force.
struct Slow {
  Vector3d turn, acceleration;
};

Slow slow(double latitude, double height, const Vector3d& velocity, const StrapdownOptions& options) {
  const LocalEarth earth = integration::earth_at(latitude, height, options);
  const Vector3d transport = earth.transport_rate(velocity);
  return {earth.rate + transport, earth.gravity - (2 * earth.rate + transport).cross(velocity)};
}

Slow slope(const Slow& above, const Slow& below, double distance) {
  return {(above.turn - below.turn) / distance, (above.acceleration - below.acceleration) / distance};
}

/// Modifies the dynamics for the vertical channel, like Strapdown.
void hold_height(ErrorDynamics& d, const LocalEarth& earth, const StrapdownOptions& options) {
  const int up_velocity = Index::velocity + 2;
  if (options.vertical == VerticalChannel::fixed) d.F.row(up_velocity).setZero(), d.F.row(Index::up).setZero();
  if (options.vertical == VerticalChannel::held) {  // height equals the barometer's
    d.F.row(Index::up).setZero();
    d.b = d.F.col(Index::up);
    d.F.col(Index::up).setZero();
  }
  if (options.vertical == VerticalChannel::aided) {
    const double pole = 1 / options.barometer_time_constant, gravity = options.gravity.value_or(earth.gravity.norm());
    d.b[Index::barometer] = -pole * pole * pole;
    d.b[up_velocity] = 3 * pole * pole + 2 * gravity / earth.transverse_radius;
    d.b[Index::up] = 3 * pole;
    d.F.col(Index::up) -= d.b;
    d.F(up_velocity, Index::barometer) = -1;
  }
}

}  // namespace

ErrorDynamics error_dynamics(const NavigationState& s, const Vector3d& force_n, const StrapdownOptions& options) {
  const LocalEarth earth = local_earth(s.latitude, s.height);
  const Vector3d& v = s.velocity;
  const Vector3d transport = earth.transport_rate(v);
  ErrorDynamics d{ErrorMatrix::Zero(), ErrorState::Zero()};
  auto attitude = d.F.middleRows<3>(Index::attitude), velocity = d.F.middleRows<3>(Index::velocity), position = d.F.middleRows<3>(Index::position);

  // Xu eq 1 is phi' = -w_in x phi + dw_in - C_nb dw; ErrorGrowth adds the last term.
  attitude.middleCols<3>(Index::attitude) = -skew<double>(earth.rate + transport);
  // Xu eq 2 is dv' = f_n x phi - (2 w_ie + w_en) x dv - (2 dw_ie + dw_en) x v + C_nb df, likewise without the last term.
  velocity.middleCols<3>(Index::attitude) = skew<double>(force_n);
  for (int k = 0; k < 3; ++k) {
    const Vector3d axis = Vector3d::Unit(k), turn = earth.transport_rate(axis);  // w_en is linear in v
    attitude.col(Index::velocity + k) = turn;
    velocity.col(Index::velocity + k) = -(2 * earth.rate + transport).cross(axis) - turn.cross(v);
  }
  // dw_in and dw_ie of eqs 1 and 2 by place, and normal gravity, which Xu omits: central differences with a relative error of 1e-9.
  const double dL = 1e-5, dh = 10;
  const Slow north = slope(slow(s.latitude + dL, s.height, v, options), slow(s.latitude - dL, s.height, v, options), 2 * dL * earth.meridian_radius);
  const Slow up = slope(slow(s.latitude, s.height + dh, v, options), slow(s.latitude, s.height - dh, v, options), 2 * dh);
  attitude.col(Index::position + 1) = north.turn;
  velocity.col(Index::position + 1) = north.acceleration;
  attitude.col(Index::up) = up.turn;
  velocity.col(Index::up) = up.acceleration;

  // Xu eqs 3 (latitude), 4 (longitude) and 5 (height) in meters: derivatives of (RN+h) cos L dlon, (RM+h) dL, dh; those of the radii cancel, because
  // RN' = (RN - RM) tan L.
  const double tangent = earth.sin_latitude / earth.cos_latitude, rm = earth.meridian_radius, rn = earth.transverse_radius;
  position.middleCols<3>(Index::velocity).setIdentity();
  position.middleCols<3>(Index::position) << (v.z() - v.y() * tangent) / rn, v.x() * tangent / rn, -v.x() / rn,  //
      0, v.z() / rm, -v.y() / rm,                                                                                //
      0, 0, 0;
  hold_height(d, earth, options);
  return d;
}

ErrorMatrix error_transition(const ErrorMatrix& F, double interval) {
  // The exponential is a fourth-order series for an interval that is short compared with the fastest decay, followed by squaring.
  int halvings = 0;
  for (double rate = interval * F.diagonal().cwiseAbs().maxCoeff(); rate > 0.1; rate /= 2) ++halvings;
  const ErrorMatrix A = std::ldexp(interval, -halvings) * F;
  const ErrorMatrix A2 = A * A;
  ErrorMatrix out = ErrorMatrix::Identity() + A + A2 / 2 + (A2 * A) / 6 + (A2 * A2) / 24;
  for (; halvings > 0; --halvings) out = (out * out).eval();
  return out;
}

}  // namespace imulab::budget
