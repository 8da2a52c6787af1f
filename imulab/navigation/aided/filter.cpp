#include "imulab/navigation/aided/filter.hpp"

#include "imulab/stop.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

namespace imulab::aided {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Returns the observations at each epoch, keyed by the number of samples before it.
std::map<std::size_t, std::vector<std::size_t>> schedule(const Problem& p, const FilterStart& start, const VectorXd& x, std::size_t end) {
  std::map<std::size_t, std::vector<std::size_t>> out;
  const auto first = p.time.begin() + static_cast<std::ptrdiff_t>(start.sample), last = p.time.begin() + static_cast<std::ptrdiff_t>(end);
  const double begin = start.sample > 0 ? p.time[start.sample - 1] : p.begin, half = p.interval / 2;
  for (std::size_t k = 0; k < p.observations.size(); ++k) {
    const Channel& c = p.channels[p.observations[k].channel];
    const double t = p.observations[k].stamp - delay_at(p, c, x, p.observations[k].stamp);
    if (t < begin - half || t > p.time[end - 1] + half) continue;
    auto after = std::lower_bound(first, last, t);
    if (after == last || (after != first && t - *(after - 1) < *after - t)) --after;
    out[static_cast<std::size_t>(after - p.time.begin()) + 1].push_back(k);
  }
  out[start.sample], out[end];
  for (auto here = out.begin(), next = std::next(here); next != out.end(); here = next++) {  // no step exceeds the longest
    double from = here->first > 0 ? p.time[here->first - 1] : p.begin;
    for (std::size_t i = here->first + 1; i < next->first; ++i)
      if (p.time[i] - from > p.longest_step) {
        out[i];
        from = p.time[i - 1];
      }
  }
  return out;
}

/// Returns the error state that takes `from` to `to`.
VectorXd difference(const FullState& to, const FullState& from) {
  VectorXd out = to.x - from.x;
  out.head<9>() = minus(to.motion, from.motion);
  return out;
}

struct Filter {
  const Problem& p;
  const FilterStart& start;
  const FilterOptions& options;
  FilterPass out{};

  double weight_of(std::size_t observation, Eigen::Index row, double innovation, double variance) const {
    if (options.about && !options.about->weights.empty()) {
      const VectorXd& known = options.about->weights[observation];
      if (row < known.size()) return known[row];
    }
    return tail_weight(innovation * innovation / variance);
  }

  /// Updates with one row after another, in the form that keeps the covariance positive.
  void update(Node& node, EpochRows& e) {
    e.gain.resize(p.size, e.rows.residual.size());
    for (Eigen::Index k = 0; k < e.rows.residual.size(); ++k) {
      const VectorXd h = e.rows.derivative.row(k);
      const VectorXd Ph = times(node.covariance, h);
      const double spread = h.dot(Ph), noise = row_variance(p, e.rows, k);
      const double innovation = e.rows.residual[k] - h.dot(node.error);
      e.innovation[k] = innovation, e.innovation_variance[k] = spread + noise;
      e.weight[k] = weight_of(e.observation, k, innovation, spread + noise);
      const double variance = spread + noise / e.weight[k];
      out.log_likelihood -= (std::log(variance) + innovation * innovation / variance) / 2;
      e.gain.col(k) = Ph / variance;
      node.error += e.gain.col(k) * innovation;
      update_covariance(node.covariance, h, e.gain.col(k), noise / e.weight[k]);
    }
    node.covariance = (node.covariance + node.covariance.transpose()).eval() / 2;
  }

  EpochRows linearized(std::size_t k, const Instant& at) const {
    EpochRows e{.observation = k, .rows = observe(p, p.observations[k], at), .weight = {}, .innovation = {}, .innovation_variance = {}, .gain = {}};
    e.weight = e.innovation = e.innovation_variance = VectorXd::Ones(e.rows.residual.size());
    return e;
  }

  void predict(const Node& node, EpochRows& e) const {
    e.innovation = e.rows.residual - e.rows.derivative * node.error;
    for (Eigen::Index k = 0; k < e.innovation.size(); ++k) {
      const VectorXd h = e.rows.derivative.row(k);
      e.innovation_variance[k] = h.dot(times(node.covariance, h)) + row_variance(p, e.rows, k);
    }
  }

  /// Returns true if the motion known so far excludes a rest, which steady motion resembles for an IMU; the row must not even count as an outlier.
  bool no_rest(const EpochRows& e) const {
    constexpr double beyond = 5;  // in sigmas: a true rest deviates as much with p = 1e-6
    return (e.innovation.array().square() > beyond * beyond * e.innovation_variance.array()).any();
  }

  /// Returns true if a correction rotates the axes too far: velocities in rotated axes are not linear in the angle.
  bool turned_far(const VectorXd& correction) const {
    constexpr double far = 0.02;  // rad: the neglected part is 0.2 mm/s at 1 m/s
    const bool motion = correction.head<3>().cwiseAbs().maxCoeff() > far;
    return std::ranges::any_of(p.channels, [&](const Channel& c) {
      return (c.mount >= 0 && (motion || correction.segment<2>(c.mount).cwiseAbs().maxCoeff() > far)) ||
             (c.body >= 0 && (motion || correction.segment<3>(c.body).cwiseAbs().maxCoeff() > far));
    });
  }

  void use(Node& node, const std::vector<std::size_t>& observations) {
    node.rows.clear(), node.withheld.clear();
    const Instant at = instant_at(p, node.samples, node.reference);
    for (const std::size_t k : observations) {
      EpochRows e = linearized(k, at);
      const bool withheld = p.observations[k].withheld, rest = p.channels[p.observations[k].channel].aid.kind == AidKind::zero_velocity;
      if (withheld || rest) predict(node, e);
      if (rest && no_rest(e)) continue;
      if (!withheld) update(node, e);
      (withheld ? node.withheld : node.rows).push_back(std::move(e));
    }
    for (EpochRows& e : node.withheld) e.rows.residual -= e.rows.derivative * node.error;
  }

  /// Observes about the filter's own point of linearization: the mean after the update, repeated if it is far away (Bell and Cathey 1993,
  /// doi:10.1109/9.250476).
  void observe_all(Node& node, const std::vector<std::size_t>& observations) {
    if (observations.empty()) return;
    if (options.about) return use(node, observations);
    constexpr int repeats = 4;
    const FullState before = node.reference;
    const MatrixXd covariance = node.covariance;
    const double likelihood = out.log_likelihood;
    for (int k = 0; k < repeats; ++k) {
      use(node, observations);
      node.reference = plus(node.reference, node.error);
      if (k + 1 == repeats || !turned_far(node.error)) break;
      node.covariance = covariance, out.log_likelihood = likelihood;
      node.error = difference(before, node.reference);
    }
    node.error.setZero();
  }

  Node first() const {
    Node node{.samples = start.sample, .reference = start.mean, .error = VectorXd::Zero(p.size)};
    node.covariance = start_variance(p, start).asDiagonal();
    if (p.joint.size() > 0) node.covariance.topLeftCorner(p.sensors_end, p.sensors_end) += p.joint;
    if (!options.about) return node;
    node.reference = {options.about->at(start.sample), options.about->x};
    node.error = difference(start.mean, node.reference);
    return node;
  }

  Node next(Node& node, std::size_t samples) const {
    Integrated step = integrate(p, node.samples, samples, node.reference, true);
    Node reached{.samples = samples, .reference = {step.end, node.reference.x}};
    reached.error = propagated_mean(step.transition, node.error);
    // The error is the integrated state minus the reference there; a slow state of the reference also decays.
    if (options.about) {
      reached.reference.motion = options.about->at(samples);
      reached.error.head<9>() += minus(step.end, reached.reference.motion);
    }
    reached.error.tail(p.size - 9).array() += (step.transition.decay.tail(p.size - 9).array() - 1) * node.reference.x.tail(p.size - 9).array();
    reached.covariance = propagated(p, step.transition, node.covariance);
    node.next = std::move(step.transition);
    if (!options.about) {
      reached.reference = plus(reached.reference, reached.error);
      reached.error.setZero();
    }
    return reached;
  }

  void run() {
    const std::size_t end = std::min(options.end, p.samples.size());
    const auto epochs = schedule(p, start, options.about ? options.about->x : start.mean.x, end);
    for (const auto& [samples, observations] : epochs) {
      stop_point();
      Node node = out.nodes.empty() ? first() : next(out.nodes.back(), samples);
      const Matrix9 predicted = node.covariance.topLeftCorner<9, 9>();
      observe_all(node, observations);
      if (options.each) options.each(out.nodes.empty() ? nullptr : &out.nodes.back().next, predicted, node);
      if (options.keep)
        out.nodes.push(std::move(node));
      else
        out.nodes.replace(std::move(node));
    }
  }
};

}  // namespace

VectorXd times(const MatrixXd& matrix, const VectorXd& h) {
  VectorXd out = VectorXd::Zero(matrix.rows());
  for (Eigen::Index k = 0; k < h.size(); ++k)
    if (h[k] != 0) out += h[k] * matrix.col(k);
  return out;
}

VectorXd start_variance(const Problem& p, const FilterStart& start) {
  VectorXd out = start.sigma.cwiseAbs2();
  for (const StateBlock& b : p.blocks)
    if (b.stationary()) out.segment(b.first, b.size) *= p.sources[*b.noise].factor;
  return out;
}

void update_covariance(MatrixXd& covariance, const VectorXd& h, const VectorXd& gain, double noise) {
  const VectorXd Ph = times(covariance, h);
  for (Eigen::Index k = 0; k < covariance.cols(); ++k) covariance.col(k) -= Ph[k] * gain;
  const VectorXd rest = noise * gain - times(covariance, h);  // the second update also corrects rounding
  for (Eigen::Index k = 0; k < covariance.cols(); ++k) covariance.col(k) += gain[k] * rest;
}

FilterPass filter(const Problem& problem, const FilterStart& start, const FilterOptions& options) {
  Filter f{problem, start, options};
  f.run();
  return std::move(f.out);
}

namespace {

/// A step integrated from its first epoch; the small misfit at the end is distributed evenly.
struct StepStates {
  std::vector<NavigationState> integrated = {};
  Eigen::Matrix<double, 9, 1> misfit = {};
  double begin = 0, length = 0;

  StepStates(const Problem& p, const EpochStates& epochs, std::size_t k) {
    const std::size_t first = epochs.samples[k], last = epochs.samples[k + 1];
    integrated.reserve(last - first);
    misfit = minus(epochs.states[k + 1].motion, integrate(p, first, last, epochs.states[k], false, &integrated).end);
    begin = first > 0 ? p.time[first - 1] : p.begin, length = p.time[last - 1] - begin;
  }
  NavigationState at(std::size_t i, double time) const { return plus(integrated[i], Eigen::Matrix<double, 9, 1>((time - begin) / length * misfit)); }
};

/// Keeps the last step because adjacent states are requested in order.
struct TrajectoryWalk {
  const Problem& p;
  EpochStates epochs;
  std::size_t number = 0;
  std::optional<StepStates> step = {};

  NavigationState at(std::size_t samples) {
    const auto k = static_cast<std::size_t>(std::ranges::lower_bound(epochs.samples, samples) - epochs.samples.begin());
    if (epochs.samples[k] == samples) return epochs.states[k].motion;
    if (!step || number != k - 1) number = k - 1, step.emplace(p, epochs, number);
    return step->at(samples - epochs.samples[number] - 1, p.time[samples - 1]);
  }
};

}  // namespace

std::vector<NavigationState> states_between(const Problem& p, const EpochStates& epochs, std::size_t k) {
  const StepStates step(p, epochs, k);
  std::vector<NavigationState> out;
  out.reserve(step.integrated.size());
  for (std::size_t i = 0; i < step.integrated.size(); ++i) out.push_back(step.at(i, p.time[epochs.samples[k] + i]));
  return out;
}

std::function<NavigationState(std::size_t)> trajectory_of(const Problem& p, EpochStates epochs) {
  return [walk = std::make_shared<TrajectoryWalk>(TrajectoryWalk{p, std::move(epochs)})](std::size_t samples) { return walk->at(samples); };
}

}  // namespace imulab::aided
