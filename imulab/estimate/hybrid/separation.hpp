// Effects in the filter, by bias separation (Friedland 1969). The filter runs without effects and additionally propagates the derivatives U of its
// states x by the constants c of the effects. Whitened innovations are linear in c and determine c by least squares under its prior. Then
//
//   x + U c,   P + U C U^T            C the covariance of c,
//
// is the result of a filter with c among its states. The time of such a filter grows with the cube of their number, that of U linearly.
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

/// The effects, and the inputs of their functions other than motion.
struct Unmodeled {
  kernel::Effects effects = {};  ///< values are zero: each pass estimates them anew
  double full_rate = 1;          ///< rad/s: largest rate of the session, at least the smallest range of a gyro
  std::optional<Thermometer> thermometer = {};
  Eigen::Index size() const { return effects.size(); }
};

/// Returns the triads' effects of a session, if any, with the sizes of the optional terms. A table only turns the unit; its angles are not used, so
/// its deformation between them is not an error.
Unmodeled unmodeled_of(const Session& session, const Recording& recording, const std::vector<in_place::Block>& blocks, const SensorModel& coarse,
                       const std::vector<CoefficientIndex>& wanted, const kernel::SeenOfUnit& seen, bool with_effects);

/// The states of the unit along a recording, in the order of its blocks.
class EffectStates {
 public:
  EffectStates(const Recording& recording, const Unmodeled& unmodeled, const Noise& noise, double gravity);

  /// Returns the derivatives of attitude and velocity errors after a block with respect to each c.
  Eigen::Matrix<double, 6, Eigen::Dynamic> columns(const in_place::Block& block, const in_place::BlockSums& sums);
  const EffectState& last() const { return state_; }

 private:
  const Recording& recording_;
  const kernel::Effects& effects_;
  std::optional<Thermometer> thermometer_;
  Vector3d variance_;  // variance of the accelerometer samples due to their noise
  double begin_s_, span_s_;
  PlayOperator play_;
  EffectState state_;
};

/// Returns the parameters of the effects alone.
kernel::Parameters parameters_of(const kernel::Effects& effects);

/// Derivatives U of the filter's states by c, and the information of the innovations about c.
class Separation {
 public:
  Separation(kernel::Parameters c, Eigen::Index states);

  /// Starts a new attitude, which does not depend on c.
  void begin() { U.bottomRows<6>().setZero(); }
  /// Predicts the last N states.
  template <int N>
  void predict(const Eigen::Matrix<double, N, Eigen::Dynamic>& transition, const Eigen::Matrix<double, N, Eigen::Dynamic>& by_c) {
    const Eigen::Matrix<double, N, Eigen::Dynamic> next = transition * U + by_c;
    U.bottomRows<N>() = next;
  }
  /// Observes states from `state` on, before the filter does: its factor, the lower Cholesky factor of the innovation's covariance, and the
  /// innovation in units of that factor. Returns the index of the innovation.
  template <int N>
  Eigen::Index observe(const SquareRootEstimate& estimate, Eigen::Index state, const Eigen::Matrix<double, N, N>& lower,
                       const Eigen::Matrix<double, N, 1>& whitened);

  struct Estimate {
    kernel::Information information;  ///< about c, from the innovations
    Eigen::VectorXd value;
    Eigen::MatrixXd covariance;
  };
  /// Estimates c from the innovations so far.
  Estimate estimate();
  /// Returns the whitened innovation at this index with the effects c.
  template <int N>
  Eigen::Matrix<double, N, 1> innovation(Eigen::Index at, const Eigen::VectorXd& c) const {
    return Eigen::Map<const Eigen::Matrix<double, N, 1>>(&innovations_[static_cast<std::size_t>(at)]) + rows_.middleCols<N>(at).transpose() * c;
  }

  Eigen::MatrixXd U;

 private:
  kernel::Parameters parameters_;
  Eigen::MatrixXd rows_;             // whitened derivatives, transposed, a column for each innovation
  std::vector<double> innovations_;  // whitened
  kernel::Information information_;  // information of the first `summed_` innovations
  Eigen::Index summed_ = 0;
};

}  // namespace imulab::hybrid
