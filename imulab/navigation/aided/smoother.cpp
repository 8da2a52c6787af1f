// The fixed-interval smoother in its adjoint form (Bryson and Frazier 1963; de Jong 1989; Koopman 1993), which inverts no covariance. It propagates
// backward the derivatives of the likelihood of all later data by the state: the gradient r and, with opposite sign, the Hessian N.
//
//   row     u = v / S - K r,   D = 1 / S + K N K        its noise comes out R u, of variance R - R D R
//           r <- r + h u,      N <- (I - h K) N (I - K h) + h h / S
//   step    its noise comes out Q r, of variance Q - Q N Q
//           r <- F^T r,        N <- F^T N F
//   state   x + P r of covariance P - P N P             x, P: filtered
//
// This is equivalent to the Rauch-Tung-Striebel form.
#include "imulab/navigation/aided/filter.hpp"
#include "imulab/stop.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::aided {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Fraction of P that P - P N P may lose by rounding, and that counts as unknown: 1 cm of 1 km.
constexpr double rounding = 1e-10;

struct Smoother {
  const Problem& p;
  VectorXd r = VectorXd::Zero(p.size);
  MatrixXd N = MatrixXd::Zero(p.size, p.size);
  SmootherPass out{};

  /// Adds the evidence of a noise: its square over its variance, and the resolved fraction of the variance.
  void add(std::size_t source, double square, double resolved) { out.evidence[source].add(square, resolved); }

  /// Adds the evidence of a slow error. A jump is not noise and does not enlarge it.
  void add_slow(std::size_t source, Index state, double variance) {
    const double square = variance * r[state] * r[state], explained = 1 - variance * N(state, state), weight = tail_weight(square + explained);
    add(source, weight * square, 1 - weight * explained);
  }

  /// Goes back over a row and returns the weight of its estimated noise. N is multiplied by one factor at a time: a precise row after a long gap
  /// leaves 1e-10 of N or less, which a product preserves and a difference loses.
  double row(const EpochRows& e, Index k) {
    const VectorXd h = e.rows.derivative.row(k), K = e.gain.col(k), NK = N * K;
    const double noise = row_variance(p, e.rows, k), R = noise / e.weight[k], S = e.innovation_variance[k] - noise + R;
    const double u = e.innovation[k] / S - K.dot(r), D = 1 / S + K.dot(NK);
    add(e.rows.source[static_cast<std::size_t>(k)], R * u * u, R * D);
    r += u * h;
    for (Index i = 0; i < p.size; ++i)
      if (h[i] != 0) N.row(i) -= h[i] * NK.transpose();
    const VectorXd change = h / S - N * K;
    for (Index i = 0; i < p.size; ++i)
      if (h[i] != 0) N.col(i) += h[i] * change;
    return tail_weight(R / noise * (R * u * u + std::max(0., 1 - R * D)));
  }

  void rows(const Node& node) {
    for (auto e = node.rows.rbegin(); e != node.rows.rend(); ++e) {
      VectorXd& weight = out.weights[e->observation] = e->weight;
      for (Index k = weight.size() - 1; k >= 0; --k) weight[k] = row(*e, k);
    }
  }

  /// Goes back over the time between two epochs.
  void step(const Transition& t) {
    const Matrix9 Q = motion_noise(p, t);
    const Eigen::Matrix<double, 9, 1> noise = Q * r.head<9>(), resolved = (Q * N.topLeftCorner<9, 9>() * Q).diagonal();
    for (Index k = 0; k < 6; ++k) {
      const double square = noise[k] * noise[k] / Q(k, k), fraction = resolved[k] / Q(k, k);
      add(k < 3 ? p.gyro_source : p.accel_source, square, fraction);
      MotionEvidence& motion = out.motion[t.motion_kind];
      (k < 3 ? motion.gyro : motion.accel).add(square, fraction);
    }
    const VectorXd q = slow_noise(p, t);
    for (const StateBlock& b : p.blocks)
      for (Index k = b.first; b.noise && k < b.first + b.size; ++k)
        if (q[k] > 0) add_slow(*b.noise, k, q[k]);  // others are declared as constant
    const Index m = t.motion.cols();
    const Eigen::Matrix<double, 9, 1> of_motion = r.head<9>();
    r.head<9>().setZero();
    r = t.decay.cwiseProduct(r);
    r.head(m) += t.motion.transpose() * of_motion;
    // With F = [M; 0 D], compute M^T A M + M^T B D + D B^T M + D C D.
    NineRows half = N.topRows<9>() * t.decay.asDiagonal();
    half.leftCols<9>().setZero();
    half.leftCols(m) += N.topLeftCorner<9, 9>() * t.motion / 2;
    const MatrixXd both = t.motion.transpose() * half;
    N.topRows<9>().setZero(), N.leftCols<9>().setZero();
    decay_slow(t, N);
    N.topRows(m) += both, N.leftCols(m) += both.transpose();
    N = (N + N.transpose()).eval() / 2;
  }

  /// Adds the evidence of slow errors at the start, which follow from the earlier noise.
  void begin() {
    for (const StateBlock& b : p.blocks)
      for (Index k = b.first; b.stationary() && k < b.first + b.size; ++k)
        add_slow(*b.noise, k, p.sources[*b.noise].factor * b.prior[k - b.first] * b.prior[k - b.first]);
  }

  /// Returns the covariance of the first `size` states.
  MatrixXd covariance(const MatrixXd& P, Index size) const {
    const MatrixXd NP = N * P.leftCols(size), less = P.topRows(size) * NP;
    return (1 + rounding) * P.topLeftCorner(size, size) - (less + less.transpose()) / 2;
  }

  void state(const Node& node, std::size_t index, bool with_covariance) {
    const VectorXd learned = node.covariance * r;
    out.nodes[index] = {node.samples, plus(node.reference, node.error + learned), {}, {}};
    if (with_covariance) out.nodes[index].covariance = covariance(node.covariance, 9);
    for (const EpochRows& e : node.withheld) {
      VectorXd variance(e.rows.residual.size());
      for (Index k = 0; k < variance.size(); ++k) {
        const VectorXd h = e.rows.derivative.row(k), Ph = times(node.covariance, h);
        variance[k] = (1 + rounding) * h.dot(Ph) - Ph.dot(N * Ph) + row_variance(p, e.rows, k);
      }
      if (variance.size() > 0)
        out.withheld.push_back({e.observation, e.rows.source.front(), e.rows.residual - e.rows.derivative * learned, variance});
    }
  }
};

}  // namespace

SmootherPass smooth(const Problem& problem, FilterPass pass, bool covariances) {
  Smoother s{problem};
  s.out.nodes.resize(pass.nodes.size());
  s.out.evidence.resize(problem.sources.size());
  s.out.weights.resize(problem.observations.size());
  const VectorXd variance = pass.nodes.back().covariance.diagonal();
  const auto late = [&](const Node& node) { return node.samples > 0 && problem.time[node.samples - 1] >= problem.middle(); };
  while (!pass.nodes.empty()) {
    stop_point();
    const Node node = pass.nodes.pop();
    const std::size_t index = pass.nodes.size();
    if (index + 1 < s.out.nodes.size()) s.step(node.next);
    s.state(node, index, covariances);
    if (index == 0 ? s.out.middle_covariance.size() == 0 : late(node) && !late(pass.nodes.back()))
      s.out.middle = index, s.out.middle_covariance = s.covariance(node.covariance, problem.size);
    s.rows(node);
  }
  s.begin();
  s.out.nodes.back().variance = variance;
  std::ranges::reverse(s.out.withheld);
  return std::move(s.out);
}

}  // namespace imulab::aided
