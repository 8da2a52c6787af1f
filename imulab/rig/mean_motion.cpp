#include "imulab/rig/mean_motion.hpp"

#include "imulab/compensate.hpp"
#include "imulab/model/compensation_derivatives.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace imulab {

namespace {

// Gauss-Legendre on (-1, 1), three nodes. Its error on a harmonic that turns by theta in the panel is 5e-7 theta^6 of the amplitude; at 0.1 rad
// 5e-13, and 3e-11 on the second harmonic, the centripetal acceleration.
constexpr std::array<double, 3> gauss_node{-0.77459666924148337704, 0, 0.77459666924148337704};
constexpr std::array<double, 3> gauss_weight{5.0 / 18, 8.0 / 18, 5.0 / 18};
constexpr double panel_angle = 0.1;      // rad, sum over the axes
constexpr double least_angle = 1e-3;     // rad: over less, differences of sines lose digits
constexpr double shortest_stencil = 32;  // samples in a piece, so that the stencil reaches little beyond its ends
constexpr double panels_of_a_piece = 8;  // at least, so that the polynomial in time itself is resolved

/// A bound on the sum of the axes' rates in a piece [rad/s].
double rate_bound(const MotionPiece& piece) {
  double sum = 0;
  for (const AnglePolynomial& p : piece.angle) {
    if (p[3] == 0 && p[4] == 0 && p[5] == 0) {
      sum += std::abs(p[1]) + 2 * std::abs(p[2]);
    } else {  // rates r and s at its ends, and besides their mean a way w by 10 u^3 - 15 u^4 + 6 u^5, steepest at its middle: 15/8
      const double r = p[1], s = p[1] + 2 * p[2] + 3 * p[3] + 4 * p[4] + 5 * p[5], w = p[1] + p[2] + p[3] + p[4] + p[5] - (r + s) / 2;
      sum += std::max(std::abs(r), std::abs(s)) + 1.875 * std::abs(w);
    }
  }
  return sum / (piece.end - piece.begin);
}

/// The rate of the one axis that turns, if it does so evenly; else 0.
double steady_rate(const MotionPiece& piece) {
  double rate = 0;
  for (const AnglePolynomial& p : piece.angle) {
    const bool even = std::all_of(p.begin() + 2, p.end(), [](double c) { return c == 0; });
    if (!even || (p[1] != 0 && rate != 0)) return 0;
    if (p[1] != 0) rate = p[1] / (piece.end - piece.begin);
  }
  return rate;
}

BodyState state_of(const RigMotion& motion, std::size_t piece, double t) { return body_state(motion, motion.pieces[piece], t); }

}  // namespace

MeanMotion::MeanMotion(RigMotion motion, const Surroundings& surroundings)
    : motion_(std::move(motion)),
      force_t_(surroundings.gravity * motion_.C_nt.row(2).transpose()),
      rate_ie_t_(motion_.C_nt.transpose() * surroundings.rate_ie_n) {
  for (std::size_t a = 0; a < 3; ++a) cross_[a] = skew<double>(motion_.axes[a]), cross_square_[a] = cross_[a] * cross_[a];
  Vector3d rate_before = motion_.rate_before * motion_.axes[0];  // in the table's frame, where a new mount is no jump
  for (std::size_t k = 0; k < motion_.pieces.size(); ++k) {
    const MotionPiece& p = motion_.pieces[k];
    const BodyState first = state_of(motion_, k, p.begin);
    Surroundings around = surroundings;
    around.lever_arm += p.arm;
    const Vector3d jump = p.C_tb.transpose() * (p.C_tb * first.rate_nb_b - rate_before);
    const double bound = rate_bound(p), panel = std::min((p.end - p.begin) / panels_of_a_piece, bound > 0 ? panel_angle / bound : p.end - p.begin);
    pieces_.push_back({p.begin,
                       p.end,
                       p.at_rest(),
                       panel,
                       !around.lever_arm.isZero(0),
                       around,
                       sensed_motion(first, around),
                       size_effect(Vector3d::Zero(), jump, around.lever_arm),
                       steady_rate(p),
                       {}});
    if (pieces_.back().steady_rate != 0) find_harmonics(k);
    rate_before = p.C_tb * state_of(motion_, k, p.end).rate_nb_b;
  }
}

Motion MeanMotion::at(std::size_t piece, double t) const {
  if (pieces_[piece].size_effect) return sensed_motion(state_of(motion_, piece, t), pieces_[piece].around);
  // Without lever arms: vectors are turned back through the axes, from the outer to the inner, as sensed_motion(turntable_state) does by matrices.
  const AxisStates states = axis_states(motion_.pieces[piece], t);
  Vector3d force = force_t_, earth = rate_ie_t_, turning = Vector3d::Zero();
  for (std::size_t a = 0; a < 3; ++a) {
    Matrix3d back = Matrix3d::Identity();
    if (states[a].angle != 0) back += (1 - std::cos(states[a].angle)) * cross_square_[a] - std::sin(states[a].angle) * cross_[a];
    force = (back * force).eval(), earth = (back * earth).eval();
    if (a > 0) turning = (back * turning).eval();
    turning += states[a].rate * motion_.axes[a];
  }
  const Matrix3d C_bt = motion_.pieces[piece].C_tb.transpose();
  return {.rate = C_bt * (turning + earth), .force = C_bt * force};
}

/// Samples first .. last of out, all inside one moving piece and each less than a panel long. The mean of a smooth function over a sample by its
/// values at the middles of seven samples: 1 + d^2/24 - 17 d^4/5760 + 367 d^6/967680, d^2 the second difference. What is left out, 6e-5 d^8, is
/// 6e-13 of a harmonic that turns by 0.1 rad a sample, and 2e-10 of the second one, in the size effect alone. The pieces' polynomials continue beyond
/// their ends.
void MeanMotion::means_inside(std::size_t piece, std::size_t begin, double interval_s, std::size_t first, std::size_t last,
                              const MotionColumns& out) const {
  constexpr double d2 = 1.0 / 24, d4 = -17.0 / 5760, d6 = 367.0 / 967680;
  constexpr double c0 = 1 - 2 * d2 + 6 * d4 - 20 * d6, c1 = d2 - 4 * d4 + 15 * d6, c2 = d4 - 6 * d6, c3 = d6;
  const std::size_t n = last - first;
  std::vector<double> values(6 * (n + 6));
  const auto column = [&](std::size_t axis) { return values.data() + axis * (n + 6); };
  for (std::size_t k = 0; k < n + 6; ++k) {
    const Motion m = at(piece, (static_cast<double>(begin + first + k) - 2.5) * interval_s);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      column(axis)[k] = m.rate(static_cast<Eigen::Index>(axis));
      column(axis + 3)[k] = m.force(static_cast<Eigen::Index>(axis));
    }
  }
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const double* const v = column(axis);
    double* const mean = (axis < 3 ? out.rate[axis] : out.force[axis - 3]).data() + first;
    for (std::size_t k = 0; k < n; ++k) mean[k] = c0 * v[k + 3] + c1 * (v[k + 2] + v[k + 4]) + c2 * (v[k + 1] + v[k + 5]) + c3 * (v[k] + v[k + 6]);
  }
}

/// Turning about one axis, vectors fixed outside are seen with the cosine and sine of the angle, and products of two, the size effect, with those of
/// twice the angle as well: five values at equal angles tell all.
void MeanMotion::find_harmonics(std::size_t piece) {
  Piece& p = pieces_[piece];
  p.harmonic.fill({});
  for (int j = 0; j < 5; ++j) {
    const double angle = 2 * std::numbers::pi * j / 5;
    const Motion m = at(piece, p.begin + angle / p.steady_rate);
    const std::array<double, 5> share{0.2, 0.4 * std::cos(angle), 0.4 * std::sin(angle), 0.4 * std::cos(2 * angle), 0.4 * std::sin(2 * angle)};
    for (std::size_t h = 0; h < 5; ++h) p.harmonic[h].force += share[h] * m.force, p.harmonic[h].rate += share[h] * m.rate;
  }
}

Motion MeanMotion::integral(std::size_t piece, double begin, double end) const {
  const Piece& p = pieces_[piece];
  if (p.at_rest) return {.rate = p.rest.rate * (end - begin), .force = p.rest.force * (end - begin)};
  if (const double w = p.steady_rate; std::abs(w) * (end - begin) > least_angle) {
    const double from = w * (begin - p.begin), to = w * (end - p.begin);
    const double s0 = std::sin(from), c0 = std::cos(from), s1 = std::sin(to), c1 = std::cos(to);
    const std::array<double, 5> share{end - begin, (s1 - s0) / w, (c0 - c1) / w, (s1 * c1 - s0 * c0) / w, (s1 * s1 - s0 * s0) / w};
    Motion sum;
    for (std::size_t h = 0; h < 5; ++h) sum.force += share[h] * p.harmonic[h].force, sum.rate += share[h] * p.harmonic[h].rate;
    return sum;
  }
  const int panels = std::max(1, static_cast<int>(std::ceil((end - begin) / p.panel - 1e-6)));
  const double width = (end - begin) / panels;
  Motion sum;
  for (int k = 0; k < panels; ++k) {
    const double middle = begin + (k + 0.5) * width;
    for (std::size_t n = 0; n < gauss_node.size(); ++n) {
      const Motion m = at(piece, middle + 0.5 * width * gauss_node[n]);
      sum.force += gauss_weight[n] * width * m.force;
      sum.rate += gauss_weight[n] * width * m.rate;
    }
  }
  return sum;
}

/// Mean over an interval that may hold joints of pieces; `piece` is the first that ends after its begin.
Motion MeanMotion::mean_across(std::size_t piece, double begin, double end) const {
  Motion sum;
  for (std::size_t j = piece; j < pieces_.size() && pieces_[j].begin < end; ++j) {
    // The last piece holds on beyond its end by rounding alone.
    const Motion part = integral(j, std::max(begin, pieces_[j].begin), j + 1 < pieces_.size() ? std::min(end, pieces_[j].end) : end);
    sum.force += part.force;
    sum.rate += part.rate;
    if (pieces_[j].begin >= begin) sum.force += pieces_[j].force_jump;
  }
  return {.rate = sum.rate / (end - begin), .force = sum.force / (end - begin)};
}

void MeanMotion::over(std::size_t begin, double interval_s, const MotionColumns& out) const {
  const auto time = [&](std::size_t sample) { return static_cast<double>(begin + sample) * interval_s; };
  const auto fill = [&](std::size_t first, std::size_t last, const Motion& m) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::fill(out.force[axis].begin() + static_cast<std::ptrdiff_t>(first), out.force[axis].begin() + static_cast<std::ptrdiff_t>(last),
                m.force(static_cast<Eigen::Index>(axis)));
      std::fill(out.rate[axis].begin() + static_cast<std::ptrdiff_t>(first), out.rate[axis].begin() + static_cast<std::ptrdiff_t>(last),
                m.rate(static_cast<Eigen::Index>(axis)));
    }
  };
  const std::size_t count = out.rate[0].size();
  std::size_t piece = 0;
  for (std::size_t k = 0; k < count;) {
    while (piece + 1 < pieces_.size() && pieces_[piece].end <= time(k)) ++piece;
    const Piece& p = pieces_[piece];
    std::size_t inside = k;  // first sample that is not inside the piece
    if (time(k) > p.begin)
      while (inside < count && time(inside + 1) <= p.end) ++inside;
    if (inside == k) {
      fill(k, k + 1, mean_across(piece, time(k), time(k + 1)));
      ++k;
    } else if (p.at_rest) {
      fill(k, inside, p.rest);
      k = inside;
    } else if (!(p.size_effect && std::abs(p.steady_rate) * interval_s > least_angle) &&  // there one integral is cheaper than one value
               interval_s <= std::min(p.panel, (p.end - p.begin) / shortest_stencil)) {
      means_inside(piece, begin, interval_s, k, inside, out);
      k = inside;
    } else {
      for (; k < inside; ++k) fill(k, k + 1, mean_across(piece, time(k), time(k + 1)));
    }
  }
}

}  // namespace imulab
