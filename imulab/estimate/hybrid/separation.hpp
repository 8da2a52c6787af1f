// Effects in the filter, by bias separation (Friedland 1969). The filter runs as if there were none; beside its states x go their derivatives U by
// the constants c of the effects. Whitened innovations are linear in c, so that they give c by least squares under its prior, and then
//
//   x + U c,   P + U C U^T            C the covariance of c,
//
// which is what the filter with c among its states arrives at. Its time would grow with the cube of their number, that of U with the number.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/estimate/hybrid/states.hpp"
#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/navigation/in_place/navigator.hpp"
#include "imulab/rig/thermal_scale.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace imulab {
struct SquareRootEstimate;
}

namespace imulab::hybrid {

/// The effects, and what their functions need besides the motion.
struct Unmodeled {
  kernel::Effects effects = {};  ///< values are zero: each pass estimates them anew
  double full_rate = 1;          ///< rad/s: the largest of the session, but no gyro's range is less than this
  std::optional<Thermometer> thermometer = {};
  Eigen::Index size() const { return effects.size(); }
};

/// The triads' effects of a session, or none, with the sizes of the optional terms. The table turns the unit, but its angles are not used: what bends
/// between them is no error.
Unmodeled unmodeled_of(const Session& session, const Recording& recording, const std::vector<in_place::Block>& blocks, const SensorModel& coarse,
                       const std::vector<CoefficientIndex>& wanted, const kernel::SeenOfUnit& seen, bool with_effects);

/// The states of the unit along a recording, in the order of its blocks.
class EffectStates {
 public:
  EffectStates(const Recording& recording, const Unmodeled& unmodeled, const Noise& noise, double gravity);

  /// Errors of attitude and velocity after a block by each c.
  Eigen::Matrix<double, 6, Eigen::Dynamic> columns(const in_place::Block& block, const in_place::BlockSums& sums);
  const EffectState& last() const { return state_; }

 private:
  const Recording& recording_;
  const kernel::Effects& effects_;
  std::optional<Thermometer> thermometer_;
  Vector3d variance_;  // of the accelerometers' samples by their noise
  double begin_s_, span_s_;
  PlayOperator play_;
  EffectState state_;
};

/// Theirs alone.
kernel::Parameters parameters_of(const kernel::Effects& effects);

/// Derivatives U of the filter's states by c, and what the innovations tell of c.
class Separation {
 public:
  Separation(kernel::Parameters c, Eigen::Index states);

  /// A new attitude, which does not depend on c.
  void begin() { U.bottomRows<6>().setZero(); }
  /// Of the last N states.
  template <int N>
  void predict(const Eigen::Matrix<double, N, Eigen::Dynamic>& transition, const Eigen::Matrix<double, N, Eigen::Dynamic>& by_c) {
    const Eigen::Matrix<double, N, Eigen::Dynamic> next = transition * U + by_c;
    U.bottomRows<N>() = next;
  }
  /// States from `state` on, before the filter does: its factor, the lower Cholesky factor of the innovation's covariance, and the innovation in
  /// units of that. Returns the innovation's place.
  template <int N>
  Eigen::Index observe(const SquareRootEstimate& estimate, Eigen::Index state, const Eigen::Matrix<double, N, N>& lower,
                       const Eigen::Matrix<double, N, 1>& whitened);

  struct Estimate {
    kernel::Information information;  ///< on c, of the innovations
    Eigen::VectorXd value;
    Eigen::MatrixXd covariance;
  };
  /// By the innovations so far.
  Estimate estimate();
  /// With c: the whitened innovation at this place.
  template <int N>
  Eigen::Matrix<double, N, 1> innovation(Eigen::Index at, const Eigen::VectorXd& c) const {
    return Eigen::Map<const Eigen::Matrix<double, N, 1>>(&innovations_[static_cast<std::size_t>(at)]) + rows_.middleCols<N>(at).transpose() * c;
  }

  Eigen::MatrixXd U;

 private:
  kernel::Parameters parameters_;
  Eigen::MatrixXd rows_;             // a column for each of the innovations: whitened derivatives, transposed
  std::vector<double> innovations_;  // whitened
  kernel::Information information_;  // of the first `summed_`
  Eigen::Index summed_ = 0;
};

}  // namespace imulab::hybrid
