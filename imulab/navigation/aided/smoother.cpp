#include "imulab/navigation/aided/filter.hpp"
#include "imulab/stop.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::aided {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Smoothed error and covariance of all states at one epoch.
struct Smoothed {
  VectorXd error;
  MatrixXd covariance;
};

struct Smoother {
  const Problem& p;
  std::vector<Index> changing{};  // states that are no constants
  SmootherPass out{};

  void add(std::size_t source, double square_over_variance, double explained) {
    out.evidence[source].squares += square_over_variance;
    out.evidence[source].resolved += std::max(0., 1 - explained);
  }

  /// A jump is no noise: it does not make that of the slow error larger.
  void add_slow(std::size_t source, double square_over_variance, double explained) {
    const double weight = tail_weight(square_over_variance + explained);
    add(source, weight * square_over_variance, weight * explained);
  }

  /// The rows' noise as it is smoothed, and their new weights.
  void judge_rows(const Node& node, const Smoothed& s) {
    const VectorXd total = node.correction + s.error;
    for (const EpochRows& e : node.rows) {
      VectorXd& weight = out.weights[e.observation];
      weight = VectorXd::Ones(e.weight.size());
      for (Index k = 0; k < e.rows.residual.size(); ++k) {
        const VectorXd h = e.rows.derivative.row(k);
        const std::size_t source = e.rows.source[static_cast<std::size_t>(k)];
        const double noise = p.sources[source].factor * e.rows.variance[k], residual = e.rows.residual[k] - h.dot(total);
        const double spread = h.dot(s.covariance * h);
        add(source, residual * residual * e.weight[k] / noise, spread * e.weight[k] / noise);
        weight[k] = tail_weight((residual * residual + spread) / noise);
      }
    }
  }

  void judge_withheld(const Node& node, const Smoothed& s) {
    const VectorXd total = node.correction + s.error;
    for (const EpochRows& e : node.withheld) {
      const ObservedRows& rows = e.rows;
      VectorXd variance = (rows.derivative * s.covariance * rows.derivative.transpose()).diagonal();
      for (Index k = 0; k < variance.size(); ++k) variance[k] += row_variance(p, rows, k);
      if (variance.size() > 0) out.withheld.push_back({e.observation, rows.source.front(), rows.residual - rows.derivative * total, variance});
    }
  }

  /// The noise between two epochs. `gain`: of the changing states.
  void judge_driving(const Node& node, const Smoothed& here, const Smoothed& next, const MatrixXd& gain) {
    const Transition& t = node.next;
    const Index m = t.motion.cols();
    const VectorXd noise = next.error - propagated_mean(t, here.error) - node.defect;
    MatrixXd with_motion = next.covariance.leftCols<9>();  // of this epoch's states with the next motion
    with_motion(changing, Eigen::all) = gain * next.covariance.leftCols<9>();
    const MatrixXd common = with_motion.topRows(m);
    const NineRows F = t.motion;
    const Matrix9 spread =
        next.covariance.topLeftCorner<9, 9>() - F * common - (F * common).transpose() + F * here.covariance.topLeftCorner(m, m) * F.transpose();
    const Matrix9 Q = motion_noise(p, t);
    for (Index k = 0; k < 6; ++k) add(k < 3 ? p.gyro_source : p.accel_source, noise[k] * noise[k] / Q(k, k), spread(k, k) / Q(k, k));
    const VectorXd q = slow_noise(p, t);
    for (const StateBlock& b : p.blocks)
      if (b.noise)
        for (Index k = b.first; k < b.first + b.size; ++k) {
          if (q[k] == 0) continue;  // declared as constant
          const double a = t.decay[k], both = gain.row(std::ranges::lower_bound(changing, k) - changing.begin()).dot(next.covariance.col(k));
          const double variance = next.covariance(k, k) - 2 * a * both + a * a * here.covariance(k, k);
          add_slow(*b.noise, noise[k] * noise[k] / q[k], variance / q[k]);
        }
  }

  /// Slow errors at the start, drawn from what their noise has made before.
  void judge_start(const Smoothed& s, const FullState& state) {
    for (const StateBlock& b : p.blocks)
      for (Index k = b.first; b.stationary() && k < b.first + b.size; ++k) {
        const double variance = p.sources[*b.noise].factor * b.prior[k - b.first] * b.prior[k - b.first];
        add_slow(*b.noise, state.x[k] * state.x[k] / variance, s.covariance(k, k) / variance);
      }
  }

  /// J P J^T + G (Q + P') G^T with J = I - G F: positive by its form. Constants are those of the next epoch: their rows of G are those of the
  /// identity, of J zero. `correction`: by the next epoch's update.
  Smoothed step(const Node& node, const VectorXd& correction, const Smoothed& next) {
    const Transition& t = node.next;
    const NineRows moved = t.motion * node.covariance.topRows(t.motion.cols());
    const MatrixXd predicted = propagated(p, t, node.covariance, moved);
    MatrixXd cross(std::ssize(changing), p.size);  // of the changing states with all at the next epoch
    cross.leftCols<9>() = moved(Eigen::all, changing).transpose();
    cross.rightCols(p.size - 9) = node.covariance(changing, Eigen::seq(9, Eigen::last)) * t.decay.tail(p.size - 9).asDiagonal();
    const VectorXd scale = predicted.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const MatrixXd scaled = scale.asDiagonal() * predicted * scale.asDiagonal();
    const MatrixXd G = scaled.ldlt().solve(scale.asDiagonal() * cross.transpose()).transpose() * scale.asDiagonal();
    MatrixXd J = MatrixXd::Zero(G.rows(), p.size);
    J.rightCols(p.size - 9) = -G.rightCols(p.size - 9) * t.decay.tail(p.size - 9).asDiagonal();
    J.leftCols(t.motion.cols()) -= G.leftCols<9>() * t.motion;
    for (Index k = 0; k < J.rows(); ++k) J(k, changing[static_cast<std::size_t>(k)]) += 1;
    MatrixXd inner = next.covariance;
    inner.topLeftCorner<9, 9>() += motion_noise(p, t);
    inner.diagonal() += slow_noise(p, t);
    const MatrixXd spread = G * inner;
    const MatrixXd own = J * node.covariance * J.transpose() + spread * G.transpose();
    Smoothed here{next.error + correction, next.covariance};
    here.covariance(changing, Eigen::all) = spread;
    here.covariance(Eigen::all, changing) = spread.transpose();
    here.covariance(changing, changing) = (own + own.transpose()) / 2;
    const VectorXd learned = next.error + correction - propagated_mean(t, node.error) - node.defect;
    here.error(changing) = node.error(changing) + G * learned;
    Smoothed relative = next;
    relative.error += correction;
    judge_driving(node, here, relative, G);
    return here;
  }

  void keep(const Node& node, std::size_t index, const Smoothed& s) {
    const bool last = index + 1 == out.nodes.size();
    if (last || (node.samples > 0 && p.time[node.samples - 1] >= p.middle())) out.middle = index, out.middle_covariance = s.covariance;
    out.nodes[index] = {node.samples, plus(node.reference, s.error), s.covariance.topLeftCorner<9, 9>(), {}};
    if (last) out.nodes[index].variance = s.covariance.diagonal();
    if (index == 0) judge_start(s, out.nodes[0].state);
    judge_rows(node, s);
    judge_withheld(node, s);
  }
};

}  // namespace

SmootherPass smooth(const Problem& problem, FilterPass pass) {
  Smoother s{problem};
  for (Index k = 0; k < 9; ++k) s.changing.push_back(k);
  for (const StateBlock& b : problem.blocks)
    for (Index k = b.first; k < b.first + b.size; ++k)
      if (std::isfinite(b.time) || b.walk.size() > 0) s.changing.push_back(k);
  s.out.nodes.resize(pass.nodes.size());
  s.out.evidence.resize(problem.sources.size());
  s.out.weights.resize(problem.observations.size());
  Node node = pass.nodes.pop();
  Smoothed now{node.error, node.covariance};
  s.keep(node, pass.nodes.size(), now);
  while (!pass.nodes.empty()) {
    const VectorXd correction = std::move(node.correction);
    node = pass.nodes.pop();
    now = s.step(node, correction, now);
    stop_point();
    s.keep(node, pass.nodes.size(), now);
  }
  std::ranges::reverse(s.out.withheld);
  return std::move(s.out);
}

}  // namespace imulab::aided
