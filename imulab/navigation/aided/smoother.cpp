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

/// F^T from the right: the covariance with the state at the next epoch.
MatrixXd with_next(const Transition& t, const MatrixXd& P) {
  const Index n = P.rows(), m = t.motion.cols();
  MatrixXd out(n, n);
  out.leftCols<9>() = P.leftCols(m) * t.motion.transpose();
  out.rightCols(n - 9) = P.rightCols(n - 9) * t.decay.tail(n - 9).asDiagonal();
  return out;
}

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

  void judge_withheld(const Node& node, std::size_t index, const Smoothed& s) {
    const VectorXd total = node.correction + s.error;
    for (std::size_t i = 0; i < node.withheld.size(); ++i) {
      const ObservedRows& rows = node.withheld[i].rows;
      VectorXd variance = (rows.derivative * s.covariance * rows.derivative.transpose()).diagonal();
      for (Index k = 0; k < variance.size(); ++k) variance[k] += row_variance(p, rows, k);
      out.withheld.push_back({index, i, rows.residual - rows.derivative * total, variance});
    }
  }

  /// The noise between two epochs.
  void judge_driving(const Node& node, const Smoothed& here, const Smoothed& next, const MatrixXd& gain) {
    const Transition& t = node.next;
    const Index m = t.motion.cols();
    const VectorXd noise = next.error - propagated_mean(t, here.error) - node.defect;
    const MatrixXd common = gain.topRows(m) * next.covariance.leftCols<9>();  // of this epoch's sensors and motion with the next motion
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
          const double a = t.decay[k], both = gain.row(k).dot(next.covariance.col(k));
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
  /// identity, of J zero.
  Smoothed step(const Node& node, const Node& after, const Smoothed& next) {
    const Transition& t = node.next;
    const MatrixXd cross = with_next(t, node.covariance)(changing, Eigen::all), predicted = propagated(p, t, node.covariance);
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
    Smoothed here{next.error + after.correction, next.covariance};
    here.covariance(changing, Eigen::all) = spread;
    here.covariance(Eigen::all, changing) = spread.transpose();
    here.covariance(changing, changing) = (own + own.transpose()) / 2;
    const VectorXd learned = next.error + after.correction - propagated_mean(t, node.error) - node.defect;
    here.error(changing) = node.error(changing) + G * learned;
    Smoothed relative = next;
    relative.error += after.correction;
    MatrixXd gain = MatrixXd::Identity(p.size, p.size);
    gain(changing, Eigen::all) = G;
    judge_driving(node, here, relative, gain);
    return here;
  }

  void keep(const Node& node, std::size_t index, const Smoothed& s) {
    if (index == out.middle) out.middle_covariance = s.covariance;
    out.nodes[index] = {plus(node.reference, s.error), s.error, s.covariance.topLeftCorner<9, 9>(), s.covariance.diagonal()};
    if (index == 0) judge_start(s, out.nodes[0].state);
    judge_rows(node, s);
    judge_withheld(node, index, s);
  }
};

}  // namespace

SmootherPass smooth(const Problem& problem, const FilterPass& pass) {
  Smoother s{problem};
  for (Index k = 0; k < 9; ++k) s.changing.push_back(k);
  for (const StateBlock& b : problem.blocks)
    for (Index k = b.first; k < b.first + b.size; ++k)
      if (std::isfinite(b.time) || b.walk.size() > 0) s.changing.push_back(k);
  s.out.nodes.resize(pass.nodes.size());
  s.out.evidence.resize(problem.sources.size());
  s.out.weights.resize(problem.observations.size());
  const auto before_middle = [&](const Node& node) { return node.samples == 0 || problem.time[node.samples - 1] < problem.middle(); };
  s.out.middle = static_cast<std::size_t>(std::ranges::find_if_not(pass.nodes, before_middle) - pass.nodes.begin());
  s.out.middle = std::min(s.out.middle, pass.nodes.size() - 1);
  Smoothed now{pass.nodes.back().error, pass.nodes.back().covariance};
  s.keep(pass.nodes.back(), pass.nodes.size() - 1, now);
  for (std::size_t k = pass.nodes.size() - 1; k-- > 0;) {
    now = s.step(pass.nodes[k], pass.nodes[k + 1], now);
    stop_point();
    s.keep(pass.nodes[k], k, now);
  }
  std::ranges::reverse(s.out.withheld);
  return std::move(s.out);
}

}  // namespace imulab::aided
