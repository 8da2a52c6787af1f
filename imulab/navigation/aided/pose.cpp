#include "imulab/navigation/aided/pose.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/aided/observed_point.hpp"
#include "imulab/navigation/aided/pose_alignment.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace imulab::aided {
namespace {

using Eigen::VectorXd;

/// Returns the derivative of a rotation vector: exp(r + d) = exp(r) exp(J d) to first order in d (right Jacobian, Chirikjian 2012).
Matrix3d right_jacobian(const Vector3d& r) {
  const double t = r.norm();
  const Matrix3d k = skew<double>(r);
  if (t < 1e-4) return Matrix3d::Identity() - k / 2 + k * k / 6;
  return Matrix3d::Identity() - (1 - std::cos(t)) / (t * t) * k + (t - std::sin(t)) / (t * t * t) * k * k;
}

Vector3d tilt_of(const Channel& c, const VectorXd& x) { return {x[c.tilt], x[c.tilt + 1], 0}; }
Matrix3d frame_of(const Channel& c, const VectorXd& x) { return rotation_exp(tilt_of(c, x)) * c.frame_start; }
Matrix3d body_of(const Channel& c, const VectorXd& x) { return c.body_start * rotation_exp(x.segment<3>(c.body)); }

ObservedRows observe_place(const Problem& p, const Channel& c, const Observation& o, const Instant& at, const Vector3d& measured) {
  const VectorXd& x = at.state.x;
  const double relative = 1 + (c.scale >= 0 ? x[c.scale] : 0), offset = offset_in_time(p, c, o, at);
  const Vector3d guessed = c.scale_start * (frame_of(c, x) * measured), place = relative * guessed;
  const Matrix3d C = at.state.motion.q_nb.toRotationMatrix();
  const Vector3d moved = C * lever_of(c, at), acceleration = acceleration_of(c, at);
  const Derived velocity = velocity_of(p, c, at);
  ObservedRows out = rows_of(3, p.size);
  const Vector3d here = minus(at.state.motion, at_place(p.place)).segment<3>(At::position);
  out.residual = place - here - moved - offset * velocity.value - offset * offset / 2 * acceleration;
  out.derivative = offset * velocity.derivative;
  out.derivative.middleCols<3>(At::attitude) -= skew<double>(moved);
  out.derivative.middleCols<3>(At::position).setIdentity();
  if (c.lever >= 0) out.derivative.middleCols<3>(c.lever) += C;
  out.derivative.middleCols<2>(c.tilt) += (skew<double>(place) * right_jacobian(-tilt_of(c, x))).leftCols<2>();
  if (c.scale >= 0) out.derivative.col(c.scale) -= guessed;
  set_delay(p, c, o, velocity.value + offset * acceleration, out.derivative);
  if (c.slow >= 0) out.residual -= x.segment<3>(c.slow), out.derivative.middleCols<3>(c.slow).setIdentity();
  out.variance = (relative * c.scale_start * position_sigma(c.aid, o.row)).cwiseAbs2();
  std::ranges::fill(out.source, c.first_noise);
  return out;
}

/// Rows are rotations in the axes of the tracked body: measured less computed.
ObservedRows observe_attitude(const Problem& p, const Channel& c, const Observation& o, const Instant& at, const Eigen::Quaterniond& measured) {
  const VectorXd& x = at.state.x;
  const Matrix3d C = at.state.motion.q_nb.toRotationMatrix(), B = body_of(c, x), T = frame_of(c, x);
  const double offset = offset_in_time(p, c, o, at);
  const Vector3d turning = offset * (B.transpose() * at.turning), rate = B.transpose() * at.rate_eb + turning, turned = offset * (rate - turning / 2);
  const Vector3d error = c.slow_turn >= 0 ? Vector3d(x.segment<3>(c.slow_turn)) : Vector3d::Zero();
  const Matrix3d computed = rotation_exp(error) * C * B * rotation_exp(turned), to_body = computed.transpose();
  ObservedRows out = rows_of(3, p.size);
  out.residual = rotation_log(to_body * T * measured.toRotationMatrix());
  out.derivative = offset * B.transpose() * rate_derivative(p, at);
  out.derivative.middleCols<3>(At::attitude) += to_body * rotation_exp(error);
  out.derivative.middleCols<3>(c.body) = rotation_exp(-turned) * right_jacobian(x.segment<3>(c.body));
  out.derivative.middleCols<2>(c.tilt) -= (to_body * right_jacobian(-tilt_of(c, x))).leftCols<2>();
  if (c.slow_turn >= 0) out.derivative.middleCols<3>(c.slow_turn) += to_body * right_jacobian(-error);
  set_delay(p, c, o, rate, out.derivative);
  out.variance.setConstant(std::pow(value_sigma(c.aid, o.row), 2));
  std::ranges::fill(out.source, c.second_noise);
  return out;
}

bool has_pose(const AidRecord& r, std::size_t row, bool places) { return r.attitude[row].allFinite() && (!places || r.place[row].allFinite()); }

}  // namespace

ObservedRows observe_pose(const Problem& p, const Channel& c, const Observation& o, const Instant& at) {
  const AidRecord& r = c.aid.record;
  ObservedRows out = rows_of(0, p.size);
  if (!r.place.empty() && r.place[o.row].allFinite()) out = joined_rows(out, observe_place(p, c, o, at, r.place[o.row]));
  if (r.attitude[o.row].allFinite()) out = joined_rows(out, observe_attitude(p, c, o, at, Eigen::Quaterniond(r.attitude[o.row])));
  return out;
}

void align_channels(Problem& p, const Recording& recording) {
  for (Channel& c : p.channels) {
    if (!has_attitude(c.aid.kind)) continue;
    for (const Channel& other : p.channels)
      if (other.aid.kind == AidKind::gnss || other.aid.kind == AidKind::heading)
        throw Error(c.name + " and " + other.name + ": poses in a frame of their own beside aids on the Earth; expected one of the two");
    const std::string name = c.aid.file.empty() ? c.name : c.aid.file;
    const PoseAlignment found = align_poses(recording, c.aid, name);
    c.body_start = found.body, c.frame_start = found.frame, c.scale_start = found.scale;
    if (c.aid.delay) continue;
    constexpr double found_to = 0.02;  // s
    c.aid.delay = found.offset;
    StateBlock& delay = *std::ranges::find(p.blocks, c.delay, &StateBlock::first);
    delay.prior[0] = c.aid.delay_sigma.value_or(found_to);
  }
}

std::optional<PoseStart> start_by_poses(const Problem& p, double begin) {
  constexpr double span = 0.2;  // s: of a mean velocity
  std::optional<PoseStart> out;
  Vector3d first = Vector3d::Zero();
  for (const Observation& o : p.observations) {
    const Channel& c = p.channels[o.channel];
    if (!has_attitude(c.aid.kind) || o.withheld) continue;
    const AidRecord& r = c.aid.record;
    const bool places = !r.place.empty();
    const double time = o.stamp - c.aid.delay.value_or(0);
    if (time < begin - p.interval || !has_pose(r, o.row, places)) continue;
    const Matrix3d C = c.frame_start * Eigen::Quaterniond(r.attitude[o.row]).toRotationMatrix() * c.body_start.transpose();
    const Vector3d place = places ? Vector3d(c.scale_start * (c.frame_start * r.place[o.row])) : Vector3d::Zero();
    const Vector3d here = place - C * c.aid.lever_arm.value_or(Vector3d::Zero());
    if (!out) {
      Eigen::Matrix<double, 9, 1> from_place = Eigen::Matrix<double, 9, 1>::Zero();
      from_place.segment<3>(At::position) = here;
      out = PoseStart{plus(at_place(p.place), from_place), time};
      out->state.q_nb = Eigen::Quaterniond(C);
      first = here;
      if (!places) return out;
    } else if (time - out->time >= span) {
      out->state.velocity = (here - first) / (time - out->time);
      break;
    }
  }
  return out;
}

}  // namespace imulab::aided
