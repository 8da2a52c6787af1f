// The Kalman filter of the hybrid method: the calibration from the computed velocity and attitude of an IMU that turns in one place (Cheng 2014
// sec 2). The only reference is that the IMU stays there; a table's angles are not used.
#pragma once

#include "imulab/estimate/hybrid/separation.hpp"
#include "imulab/estimate/hybrid/states.hpp"
#include "imulab/navigation/in_place/navigator.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

namespace imulab::hybrid {

using in_place::Block;

/// The data that are the same in every pass.
struct Data {
  const Recording& recording;
  std::vector<Block> blocks;
  Place place;
  Noise noise;
  SensorModel coarse;  ///< the coarse solution
  Terms terms = {};
  Unmodeled unmodeled = {};

  /// Velocities: one of each block that is observed.
  std::ptrdiff_t observed() const {
    return std::count_if(blocks.begin(), blocks.end(), [](const Block& b) { return b.observed; });
  }
};

/// The point of linearization.
struct Linearization {
  SensorModel model;
  Place place;
  std::optional<Matrix3d> start = {};  ///< attitude at the start, C_nb; absent: by alignment on the first rest
  double delay = 0;                    ///< of what lever arms make of the motion [s]; the state is the whole delay
  Eigen::VectorXd effects = {};        ///< known values; empty: zero
};

struct PassOptions {
  double outlier = std::numeric_limits<double>::infinity();  ///< what has an innovation beyond this chi-square is not used
  double curve_interval = 0;                                 ///< s between the points of `curve`; 0: none
  bool rates = false;                                        ///< at rest, for `rates`
  bool effects = true;                                       ///< estimates those of `Data`; false: they are as the linearization has them
};

/// The estimate after a block.
struct CurvePoint {
  double time;  ///< s
  Eigen::VectorXd x, sigma;
};

/// The gyros' mean rate in a block at rest, by the computed attitude in east-north-up: the Earth's rate, turned by the heading's error.
struct RestRate {
  double time, duration;  ///< s; `time` since the first block's end
  Vector3d rate_n;        ///< rad/s
};

/// What the gyros' errors were seen to add to the heading in a rest, in its standard deviations, and the variance of that.
struct SeenHeading {
  std::size_t last;  ///< block of the rest
  double whitened, variance;
};

/// Correlation of each value with the next, and its standard deviation where they are white.
struct Serial {
  double correlation = 0, sigma = 0;
};

struct Pass {
  Matrix3d start;     ///< attitude at the start about which the pass was linearized
  Eigen::VectorXd x;  ///< constants, and errors of attitude and velocity at the end
  Eigen::MatrixXd covariance;
  std::vector<double> chi2;  ///< of the innovations by block, three degrees of freedom each; zero where nothing was observed
  Serial serial;             ///< of these
  std::vector<SeenHeading> headings;
  std::vector<CurvePoint> curve;  ///< thinned
  std::vector<RestRate> rates;
  Separation::Estimate effects = {};  ///< empty: none were estimated
  Eigen::MatrixXd across = {};        ///< covariance of x and the effects
  std::vector<EffectState> states;    ///< at the end of each block, where effects were estimated

  double total_chi2() const { return std::accumulate(chi2.begin(), chi2.end(), 0.0); }
  double chi2_of_headings() const {
    return std::accumulate(headings.begin(), headings.end(), 0.0, [](double sum, const SeenHeading& h) { return sum + h.whitened * h.whitened; });
  }
};

/// One pass over the blocks. The errors are states beside the model that they are linearized about; only the level is fed back, after each block at
/// rest. `known`: the prior of the constants.
Pass filter_pass(const Data& data, const Linearization& about, const States& states, const kernel::Parameters& known,
                 const PassOptions& options = {});

}  // namespace imulab::hybrid
