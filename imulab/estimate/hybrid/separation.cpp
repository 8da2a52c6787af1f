#include "imulab/estimate/hybrid/separation.hpp"

#include "imulab/core/decomposition.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using in_place::Block;
using in_place::BlockSums;

Unmodeled unmodeled_of(const Session& session, const Recording& recording, const std::vector<Block>& blocks, const SensorModel& coarse,
                       const std::vector<CoefficientIndex>& wanted, const kernel::SeenOfUnit& seen, bool with_effects) {
  const auto calibrates = [&](Triad triad) {
    return wanted.empty() || std::any_of(wanted.begin(), wanted.end(), [&](CoefficientIndex index) { return coefficient(index).triad == triad; });
  };
  const std::optional<Thermometer> thermometer = thermometer_of(recording, session.source_of(recording.name));
  const EffectSetting setting{
      .accel = with_effects && calibrates(Triad::accel), .gyro = with_effects && calibrates(Triad::gyro), .thermometer = thermometer.has_value()};
  Unmodeled out{.effects = kernel::Effects(kernel::effect_sizes(session, seen), setting), .thermometer = thermometer};
  for (const Block& block : blocks)
    if (!block.at_rest)
      out.full_rate = std::max(
          out.full_rate, (coarse.gyro.matrix * reading_at(recording.gyro, (block.samples.begin + block.samples.end) / 2)).cwiseAbs().maxCoeff());
  return out;
}

EffectStates::EffectStates(const Recording& recording, const Unmodeled& unmodeled, const Noise& noise, double gravity)
    : recording_(recording),
      effects_(unmodeled.effects),
      thermometer_(unmodeled.thermometer),
      variance_(noise.accel.cwiseAbs2() / recording.interval_s),
      begin_s_(recording.time_s(0)),
      span_s_(std::max(recording.time_s(recording.size() - 1) - begin_s_, 1e-9)),
      play_(gravity) {
  state_.gravity = state_.full_force = gravity;
  state_.full_rate = unmodeled.full_rate;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> EffectStates::columns(const Block& block, const BlockSums& sums) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> out = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, effects_.size());
  const double begin_s = recording_.time_s(block.samples.begin) - begin_s_;
  double elapsed = 0;
  state_.shaking = block.at_rest ? Vector3d(sums.shaking - variance_) : Vector3d::Zero();
  if (thermometer_) state_.warming = thermometer_->warming(block.samples.begin);
  for (const in_place::BlockPart& part : sums.parts) {
    state_.rate = part.rate / part.duration;
    state_.force = part.force / part.duration;
    state_.play = play_(state_.force);
    state_.time = (begin_s + elapsed + 0.5 * part.duration) / span_s_ - 0.5;
    elapsed += part.duration;
    for (Index k = 0; k < effects_.size(); ++k) {
      const OutputChange change = effects_.columns()[static_cast<std::size_t>(k)].at(state_);
      out.col(k) += part.by_output(change.rate, change.force);
    }
  }
  return out;
}

kernel::Parameters parameters_of(const kernel::Effects& effects) {
  kernel::Parameters out(effects.size());
  effects.add_to(out);
  return out;
}

Separation::Separation(kernel::Parameters c, Index states)
    : U(MatrixXd::Zero(states, c.size())), parameters_(std::move(c)), information_(parameters_.size()) {}

template <int N>
Index Separation::observe(const SquareRootEstimate& e, Index state, const Eigen::Matrix<double, N, N>& lower,
                          const Eigen::Matrix<double, N, 1>& whitened) {
  const Index at = std::ssize(innovations_);
  if (at + N > rows_.cols()) rows_.conservativeResize(U.cols(), std::max<Index>(3 * 256, 2 * at));
  const auto in_units = lower.template triangularView<Eigen::Lower>();
  // The innovation is z - x_v, so its derivative by c is -U_v.
  const Eigen::Matrix<double, N, Eigen::Dynamic> scaled = in_units.solve(U.middleRows<N>(state));
  rows_.middleCols<N>(at) = -scaled.transpose();
  innovations_.insert(innovations_.end(), whitened.begin(), whitened.end());
  // K = P H^T (L L^T)^-1, and U - K U_v.
  const MatrixXd gain = in_units.solve((e.factor * e.factor.middleRows<N>(state).transpose()).transpose()).transpose();
  U.noalias() -= gain * scaled;
  return at;
}

template Index Separation::observe(const SquareRootEstimate&, Index, const Eigen::Matrix<double, 1, 1>&, const Eigen::Matrix<double, 1, 1>&);
template Index Separation::observe(const SquareRootEstimate&, Index, const Matrix3d&, const Vector3d&);

Separation::Estimate Separation::estimate() {
  const Index count = std::ssize(innovations_);
  if (count > summed_) {  // Eigen's update with zero columns divides by zero
    const auto rows = rows_.middleCols(summed_, count - summed_);
    const Eigen::Map<const VectorXd> innovations(&innovations_[static_cast<std::size_t>(summed_)], rows.cols());
    information_.N.selfadjointView<Eigen::Lower>().rankUpdate(rows);
    information_.g += rows * innovations;
    information_.chi2 += innovations.squaredNorm();
  }
  information_.rows = static_cast<int>(count);
  summed_ = count;
  Estimate out{information_, {}, {}};
  out.information.N.triangularView<Eigen::StrictlyUpper>() = information_.N.transpose();
  kernel::Solution solution = kernel::solve(out.information, parameters_, "the effects");
  out.value = std::move(solution.x);
  out.covariance = std::move(solution.covariance);
  return out;
}

}  // namespace imulab::hybrid
