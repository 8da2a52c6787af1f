#include "imulab/navigation/aided/split_covariance.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::aided {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

SplitCovariance::SplitCovariance(const Problem& p, const FilterStart& start)
    : p_(p), by_start_(MatrixXd::Identity(p.size, p.size)), total_(start_variance(p, start).asDiagonal()) {
  for (std::size_t k = 0; k < p.sources.size(); ++k) {
    Problem alone;
    alone.size = p.size, alone.blocks = p.blocks, alone.sources = p.sources;
    alone.gyro_source = p.gyro_source, alone.accel_source = p.accel_source;
    for (std::size_t other = 0; other < p.sources.size(); ++other)
      if (other != k) alone.sources[other].factor = 0;
    noises_.push_back({std::move(alone), MatrixXd::Zero(p.size, p.size)});
  }
}

void SplitCovariance::step(const Transition& t) {
  for (Index k = 0; k < by_start_.cols(); ++k) by_start_.col(k) = propagated_mean(t, by_start_.col(k));
  for (Noise& n : noises_) n.covariance = propagated(n.alone, t, n.covariance);
  total_ = propagated(p_, t, total_);
}

void SplitCovariance::update(const Node& node) {
  for (const EpochRows& e : node.rows)
    for (Index k = 0; k < e.rows.residual.size(); ++k) {
      const std::size_t source = e.rows.source[static_cast<std::size_t>(k)];
      const VectorXd h = e.rows.derivative.row(k), Ph = total_ * h;
      const double noise = row_variance(p_, e.rows, k) / e.weight[k];
      const VectorXd gain = Ph / (h.dot(Ph) + noise);
      update_covariance(total_, h, gain, noise);
      for (std::size_t s = 0; s < noises_.size(); ++s) update_covariance(noises_[s].covariance, h, gain, s == source ? noise : 0);
      const Eigen::RowVectorXd seen = h.transpose() * by_start_;
      by_start_.noalias() -= gain * seen;
    }
}

double SplitCovariance::variance(const CovariancePart& part, Index state) const {
  double sum = 0;
  for (const auto& [from, size] : part.states) sum += size * std::pow(by_start_(state, from), 2);
  for (const auto& [source, share] : part.noises) sum += share * noises_[source].covariance(state, state);
  return std::max(0., sum);
}

}  // namespace imulab::aided
