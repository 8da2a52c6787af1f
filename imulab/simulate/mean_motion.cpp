#include "imulab/simulate/mean_motion.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace {

// Gauss-Legendre on (-1, 1), three nodes. Its error on a harmonic that turns by theta in the panel is 5e-7 theta^6 of the amplitude; at 0.1 rad
// 5e-13, and 3e-11 on the second harmonic, the centripetal acceleration.
constexpr std::array<double, 3> node{-0.77459666924148337704, 0, 0.77459666924148337704};
constexpr std::array<double, 3> weight{5.0 / 18, 8.0 / 18, 5.0 / 18};
constexpr double panel_angle = 0.1;      // rad, sum over the axes
constexpr double panels_of_a_piece = 8;  // at least, so that the polynomial in time itself is resolved

/// A bound on the sum of the axes' rates in a piece [rad/s].
double rate_bound(const MotionPiece& piece) {
  double sum = 0;
  for (const AnglePolynomial& p : piece.angle) {
    if (p[3] == 0) {
      sum += std::abs(p[1]) + 2 * std::abs(p[2]);
    } else {
      sum += 1.875 * std::abs(p[1] + p[2] + p[3] + p[4] + p[5]);  // 10 u^3 - 15 u^4 + 6 u^5 is steepest at its middle: 15/8
    }
  }
  return sum / (piece.end - piece.begin);
}

BodyState state_of(const RigMotion& motion, std::size_t piece, double t) {
  return turntable_state(motion.axes, axis_states(motion.pieces[piece], t), motion.C_nt);
}

Vector3d size_effect_of_jump(const Vector3d& rate_jump, const Matrix3d& lever_arm) {
  Vector3d force;
  for (int i = 0; i < 3; ++i) force(i) = rate_jump.cross(Vector3d(lever_arm.row(i)))(i);
  return force;
}

}  // namespace

MeanMotion::MeanMotion(RigMotion motion, const Surroundings& surroundings) : motion_(std::move(motion)), surroundings_(surroundings) {
  Vector3d rate_before = Vector3d::Zero();
  for (std::size_t k = 0; k < motion_.pieces.size(); ++k) {
    const MotionPiece& p = motion_.pieces[k];
    const BodyState first = state_of(motion_, k, p.begin);
    const double bound = rate_bound(p), panel = std::min((p.end - p.begin) / panels_of_a_piece, bound > 0 ? panel_angle / bound : p.end - p.begin);
    pieces_.push_back({p.begin, p.end, p.at_rest(), panel, sensed_motion(first, surroundings_),
                       size_effect_of_jump(first.rate_nb_b - rate_before, surroundings_.lever_arm)});
    rate_before = state_of(motion_, k, p.end).rate_nb_b;
  }
}

Motion MeanMotion::integral(std::size_t piece, double begin, double end) const {
  const Piece& p = pieces_[piece];
  if (p.at_rest) return {p.rest.force * (end - begin), p.rest.rate * (end - begin)};
  const int panels = std::max(1, static_cast<int>(std::ceil((end - begin) / p.panel - 1e-6)));
  const double width = (end - begin) / panels;
  Motion sum{Vector3d::Zero(), Vector3d::Zero()};
  for (int k = 0; k < panels; ++k) {
    const double middle = begin + (k + 0.5) * width;
    for (std::size_t n = 0; n < node.size(); ++n) {
      const Motion m = sensed_motion(state_of(motion_, piece, middle + 0.5 * width * node[n]), surroundings_);
      sum.force += weight[n] * width * m.force;
      sum.rate += weight[n] * width * m.rate;
    }
  }
  return sum;
}

void MeanMotion::over(std::size_t begin, double interval_s, const MotionColumns& out) const {
  const auto time = [&](std::size_t sample) { return static_cast<double>(sample) * interval_s; };
  std::size_t piece = 0;  // the first that ends after the sample's begin
  for (std::size_t k = 0; k < out.rate[0].size(); ++k) {
    const double t0 = time(begin + k), t1 = time(begin + k + 1);
    while (piece + 1 < pieces_.size() && pieces_[piece].end <= t0) ++piece;
    Motion mean = pieces_[piece].rest;
    if (!pieces_[piece].at_rest || t0 <= pieces_[piece].begin || t1 > pieces_[piece].end) {
      Motion sum{Vector3d::Zero(), Vector3d::Zero()};
      for (std::size_t j = piece; j < pieces_.size() && pieces_[j].begin < t1; ++j) {
        // The last piece holds on beyond its end by rounding alone.
        const Motion part = integral(j, std::max(t0, pieces_[j].begin), j + 1 < pieces_.size() ? std::min(t1, pieces_[j].end) : t1);
        sum.force += part.force;
        sum.rate += part.rate;
        if (pieces_[j].begin >= t0) sum.force += pieces_[j].force_jump;
      }
      mean = {sum.force / (t1 - t0), sum.rate / (t1 - t0)};
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.force[axis][k] = mean.force(static_cast<Eigen::Index>(axis));
      out.rate[axis][k] = mean.rate(static_cast<Eigen::Index>(axis));
    }
  }
}

}  // namespace imulab
