#include "imulab/estimate/kernel/size_inference.hpp"

#include "imulab/core/decomposition.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double log_unit_spread = 1.6094379124341003;  // ln 5, one sigma of ln lambda
constexpr double log_own_spread = std::numbers::ln2;    // one sigma of ln t and ln o
constexpr int grid_points = 24;                         // number of points of ln lambda, within four sigmas on either side
constexpr double negligible = 8;                        // difference of ln weight from the largest: a weight of 3e-4

double log_lambda(int point) {
  const double begin = std::log(0.0016), end = std::log(125.0);
  return begin + (end - begin) * point / (grid_points - 1);
}

/// The most probable logarithm of a factor, and its variance.
struct Factor {
  double log = 0, variance = log_own_spread * log_own_spread;
};

bool has_unit_factor(SizedGroup::Of of) { return of != SizedGroup::Of::declared && of != SizedGroup::Of::rig; }
int triad_of(SizedGroup::Of of) { return of == SizedGroup::Of::accel ? 0 : of == SizedGroup::Of::gyro ? 1 : -1; }

/// Factors of all groups and triads at one lambda.
struct Factors {
  std::vector<Factor> own;
  std::array<Factor, 2> triad = {};

  double log_of(std::size_t k, SizedGroup::Of of) const {
    return own[k].log + (triad_of(of) < 0 ? 0 : triad[static_cast<std::size_t>(triad_of(of))].log);
  }
  double variance_of(std::size_t k, SizedGroup::Of of) const {
    return own[k].variance + (triad_of(of) < 0 ? 0 : triad[static_cast<std::size_t>(triad_of(of))].variance);
  }
};

/// Values, variances and evidence of c under given sizes.
struct Conditional {
  VectorXd value, variance;
  double log_evidence = 0;
};

/// With S = diag(size^2): P = (L + S^-1)^-1, c = P eta, ln p(r | sizes) = -1/2 ln det(I + S^1/2 L S^1/2) + 1/2 eta.c. For columns that the data do
/// not resolve at this size, P = S, with an error of about 1e-4.
Conditional conditional(const ReducedEffects& data, const VectorXd& size) {
  constexpr double unseen = 1e-4;
  Conditional out{size.cwiseAbs2().cwiseProduct(data.eta), size.cwiseAbs2()};
  std::vector<Index> seen;
  for (Index k = 0; k < size.size(); ++k)
    if (out.variance[k] * std::max(data.L(k, k), data.eta[k] * data.eta[k]) > unseen) seen.push_back(k);
  const VectorXd s = size(seen);
  MatrixXd root = s.asDiagonal() * data.L(seen, seen) * s.asDiagonal();
  root.diagonal().array() += 1;
  const Cholesky factor(root);
  const MatrixXd inverse = factor.inverse_lower();
  const VectorXd whitened = inverse * s.cwiseProduct(data.eta(seen));
  out.value(seen) = s.cwiseProduct(inverse.transpose() * whitened);
  out.variance(seen) = s.cwiseAbs2().cwiseProduct(inverse.colwise().squaredNorm().transpose());
  out.log_evidence = 0.5 * whitened.squaredNorm() - factor.lower().diagonal().array().log().sum();
  return out;
}

/// The inference under one hypothesis.
class Sizes {
 public:
  Sizes(const ReducedEffects& data, const std::vector<SizedGroup>& groups, const SizeHypothesis& hypothesis)
      : data_(data), groups_(groups), hypothesis_(hypothesis) {}

  /// Returns a node before normalization of weights. `factors` are the start, and are replaced by those of this node, the start of the next.
  SizeNode at(double log_factor, Factors& factors) const {
    constexpr int most_rounds = 20;
    constexpr double still = 0.01;
    Conditional c = conditional(data_, sizes(log_factor, factors));
    for (int round = 0; round < most_rounds && update(factors, c, log_factor, round) > still; ++round)
      c = conditional(data_, sizes(log_factor, factors));
    SizeNode node;
    node.log_factor = log_factor;
    node.weight = c.log_evidence + hypothesis_.log_weight - 0.5 * std::pow(log_factor / log_unit_spread, 2);
    const auto add = [&](const Factor& f) {  // Laplace approximation: the largest density times the width
      node.weight += 0.5 * (std::log(f.variance) - std::pow(f.log / log_own_spread, 2)) - std::log(log_own_spread);
    };
    for (const Factor& f : factors.triad) add(f);
    for (std::size_t k = 0; k < groups_.size(); ++k) {
      const bool declared = groups_[k].of == SizedGroup::Of::declared;
      if (!declared) add(factors.own[k]);
      node.log_own.push_back(declared ? 0 : factors.own[k].log), node.own_variance.push_back(declared ? 0 : factors.own[k].variance);
      node.log_all.push_back(log_size(k, log_factor, factors)), node.all_variance.push_back(declared ? 0 : factors.variance_of(k, groups_[k].of));
    }
    return node;
  }

 private:
  /// Returns the logarithm of the product of all factors in a group's size.
  double log_size(std::size_t k, double log_factor, const Factors& factors) const {
    const SizedGroup::Of of = groups_[k].of;
    return (has_unit_factor(of) ? log_factor : 0) + (of == SizedGroup::Of::declared ? 0 : factors.log_of(k, of));
  }

  /// Returns the most probable sizes by column.
  VectorXd sizes(double log_factor, const Factors& factors) const {
    VectorXd out(data_.eta.size());
    for (std::size_t k = 0; k < groups_.size(); ++k)
      out.segment(groups_[k].first, groups_[k].size).setConstant(hypothesis_.sizes[k] * std::exp(log_size(k, log_factor, factors)));
    return out;
  }

  /// Takes a step to the most probable factors about this answer; returns the largest change of a logarithm. For u = ln o_k of m columns with squares
  /// q = (|c|^2 + tr P) / size^2, the derivative of the evidence is q - m - u/spread^2. That of q, for columns that do not depend on each other, is
  /// -2 sum(c^2/size^2 (2g - 1) + g P/size^2) with the data's share g = 1 - P/size^2. A triad's factor moves all of its groups.
  double update(Factors& factors, const Conditional& c, double log_factor, int round) const {
    static constexpr double weight = 1 / (log_own_spread * log_own_spread), longest = 1;
    constexpr int patience = 3;  // then columns are correlated, and the bend is at least q, its value for known c
    struct Slope {
      double value = 0, bend = 0;  // `bend` excludes the spread of the factor itself
      double step(double by_others = 0) const { return std::clamp((value - by_others) / (bend + weight), -longest, longest); }
    };
    std::vector<Slope> own(groups_.size());
    std::array<Slope, 2> of_triad{Slope{-weight * factors.triad[0].log}, Slope{-weight * factors.triad[1].log}};
    std::array<double, 2> squares{};
    const auto triad_at = [&](std::size_t k) { return static_cast<std::size_t>(triad_of(groups_[k].of)); };
    for (std::size_t k = 0; k < groups_.size(); ++k) {
      const SizedGroup& g = groups_[k];
      if (g.of == SizedGroup::Of::declared) continue;
      const double variance = std::pow(hypothesis_.sizes[k] * std::exp(log_size(k, log_factor, factors)), 2);
      const auto seen = (1 - c.variance.segment(g.first, g.size).array() / variance).eval();
      const auto square = (c.value.segment(g.first, g.size).array().square() / variance).eval();
      const double q = square.sum() + (1 - seen).sum(), pull = q - static_cast<double>(g.size);
      const double alone = std::max(0.0, 2 * (square * (2 * seen - 1) + seen * (1 - seen)).sum());
      const double bend = round < patience ? alone : std::max(alone, q);
      own[k] = {pull - weight * factors.own[k].log, bend};
      factors.own[k].variance = 1 / (2 * q + weight);
      if (triad_of(g.of) < 0) continue;
      Slope& t = of_triad[triad_at(k)];  // includes the reaction of the group's own factor
      t.value += pull - bend * own[k].value / (bend + weight), t.bend += bend * weight / (bend + weight);
      squares[triad_at(k)] += q;
    }
    std::array<double, 2> steps{};
    double moved = 0;
    for (std::size_t t = 0; t < 2; ++t) {
      steps[t] = of_triad[t].step();
      factors.triad[t].log += steps[t], factors.triad[t].variance = 1 / (2 * squares[t] + weight);
      moved = std::max(moved, std::abs(steps[t]));
    }
    for (std::size_t k = 0; k < groups_.size(); ++k) {
      if (groups_[k].of == SizedGroup::Of::declared) continue;
      const double step = own[k].step(triad_of(groups_[k].of) < 0 ? 0 : own[k].bend * steps[triad_at(k)]);
      factors.own[k].log += step;
      moved = std::max(moved, std::abs(step));
    }
    return moved;
  }

  const ReducedEffects& data_;
  const std::vector<SizedGroup>& groups_;
  const SizeHypothesis& hypothesis_;
};

/// Extrapolates the factors to the next lambda: most of them change at a constant rate with lambda.
Factors continued(const Factors& last, const Factors& before) {
  Factors out = last;
  for (std::size_t k = 0; k < out.own.size(); ++k) out.own[k].log += last.own[k].log - before.own[k].log;
  for (std::size_t t = 0; t < out.triad.size(); ++t) out.triad[t].log += last.triad[t].log - before.triad[t].log;
  return out;
}

/// Returns the relevant nodes of a hypothesis, from the middle of the grid to both sides. `most_of_others`: largest weight of earlier hypotheses.
std::vector<SizeNode> nodes_of(const Sizes& sizes, std::size_t groups, double most_of_others) {
  std::vector<SizeNode> out;
  double most = -HUGE_VAL;
  Factors middle_factors{std::vector<Factor>(groups)};
  constexpr int middle = grid_points * 4 / 7;  // lambda of about 1
  for (const int direction : {1, -1}) {
    Factors factors = middle_factors, before = factors;
    double last_weight = -HUGE_VAL;
    for (int point = direction > 0 ? middle : middle - 1; point >= 0 && point < grid_points; point += direction) {
      const Factors last = factors;
      factors = point == middle || point == middle + 1 || point == middle - 1 ? last : continued(last, before);
      before = last;
      out.push_back(sizes.at(log_lambda(point), factors));
      if (point == middle) middle_factors = factors;
      const double weight = out.back().weight;
      if (weight < most - negligible || (weight < most_of_others - negligible && weight < last_weight)) break;
      most = std::max(most, weight), last_weight = weight;
    }
  }
  return out;
}

/// Returns the probability that a normal variable exceeds a limit; with zero variance 0 or 1.
double above(double limit, double mean, double variance) {
  return variance > 0 ? 0.5 * std::erfc((limit - mean) / std::sqrt(2 * variance)) : mean > limit ? 1 : 0;
}

template <class Probability>
double mean_over(const std::vector<SizeNode>& nodes, Probability&& probability) {
  double sum = 0;
  for (const SizeNode& node : nodes) sum += node.weight * probability(node);
  return sum;
}

}  // namespace

double SizePosterior::exceeds(std::size_t group, double factor) const {
  return mean_over(nodes, [&](const SizeNode& n) { return above(std::log(factor), n.log_all[group], n.all_variance[group]); });
}

double SizePosterior::stands_out(std::size_t group, double factor) const {
  return mean_over(nodes, [&](const SizeNode& n) { return above(std::log(factor), n.log_own[group], n.own_variance[group]); });
}

double SizePosterior::factor_exceeds(double factor) const {
  return mean_over(nodes, [&](const SizeNode& n) { return n.log_factor > std::log(factor) ? 1.0 : 0.0; });
}

double log_evidence(const ReducedEffects& data, const VectorXd& size) { return conditional(data, size).log_evidence; }
double explained_cost(const ReducedEffects& data, const VectorXd& size) { return data.eta.dot(conditional(data, size).value); }

SizePosterior infer_sizes(const ReducedEffects& data, const std::vector<SizedGroup>& groups, const std::vector<SizeHypothesis>& hypotheses) {
  SizePosterior out;
  double most = -HUGE_VAL;
  std::vector<std::size_t> likeliest_first(hypotheses.size());
  std::iota(likeliest_first.begin(), likeliest_first.end(), std::size_t{0});
  std::ranges::sort(likeliest_first, std::greater<>(), [&](std::size_t h) { return hypotheses[h].log_weight; });
  for (const std::size_t h : likeliest_first) {
    // The factors allow any hypothesis to take the sizes of any other, but with a lower probability.
    constexpr double hopeless = 20;
    if (hypotheses[h].log_weight < hypotheses[likeliest_first.front()].log_weight - hopeless) break;
    for (SizeNode& node : nodes_of(Sizes(data, groups, hypotheses[h]), groups.size(), most)) {
      node.hypothesis = h;
      most = std::max(most, node.weight);
      out.nodes.push_back(std::move(node));
    }
  }
  double sum = 0;
  for (SizeNode& node : out.nodes) sum += node.weight = std::exp(node.weight - most);
  for (SizeNode& node : out.nodes) node.weight /= sum;
  out.log_evidence = most + std::log(sum);
  // A unit counts as far worse than its class only if the data at least double the odds: otherwise the result is the mean square of the prior.
  constexpr double far_worse = 4, was = 0.195, ratio = 2;
  const double worse = out.factor_exceeds(far_worse);
  const bool of_class = worse < ratio * was / (1 - was + ratio * was);
  double kept = 0;
  out.rms.resize(groups.size()), out.weights.resize(hypotheses.size());
  for (const SizeNode& node : out.nodes) {
    const double w = node.weight, log_factor = node.log_factor;
    out.weights[node.hypothesis] += w;
    out.log_factor += w * log_factor, out.sigma += w * log_factor * log_factor;
    if (of_class && log_factor > std::log(far_worse)) continue;
    kept += w;
    // Use the mean square of a size: the most probable size is too small for weakly observable effects.
    for (std::size_t k = 0; k < groups.size(); ++k)
      out.rms[k] += w * std::pow(hypotheses[node.hypothesis].sizes[k] * std::exp(node.log_all[k] + node.all_variance[k]), 2);
  }
  for (double& size : out.rms) size /= kept;
  for (double& size : out.rms) size = std::sqrt(size);
  out.sigma = std::sqrt(std::max(0.0, out.sigma - out.log_factor * out.log_factor));
  return out;
}

}  // namespace imulab::kernel
