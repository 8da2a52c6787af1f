// The Kalman filter of the hybrid method: calibrates from the computed velocity and attitude of an IMU that turns in one place (Cheng 2014 sec 2).
// The only reference is the fixed position of the IMU; the angles of a table are not used.
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

/// The data common to all passes.
struct Data {
  const Recording& recording;
  std::vector<Block> blocks;
  Place place;
  Noise noise;
  SensorModel coarse;  ///< coarse solution
  Terms terms = {};
  Unmodeled unmodeled = {};

  /// Returns the number of observed velocities, one for each observed block.
  std::ptrdiff_t observed() const {
    return std::count_if(blocks.begin(), blocks.end(), [](const Block& b) { return b.observed; });
  }
};

/// The point of linearization.
struct Linearization {
  SensorModel model;
  Place place;
  std::optional<Matrix3d> start = {};  ///< C_nb at the start; absent: from alignment on the first rest
  double delay = 0;                    ///< delay of the motion due to lever arms [s]; the state is the whole delay
  Eigen::VectorXd effects = {};        ///< known values; empty: zero
};

struct PassOptions {
  double outlier = std::numeric_limits<double>::infinity();  ///< innovations beyond this chi-square are not used
  double curve_interval = 0;                                 ///< [s] between the points of `curve`; 0: none
  bool rates = false;                                        ///< records `rates` at rest
  bool effects = true;                                       ///< estimates the effects of `Data`; false: uses those of the linearization
};

/// The estimate after one block.
struct CurvePoint {
  double time;  ///< s
  Eigen::VectorXd x, sigma;
};

/// Mean rate of the gyros in a block at rest, in east-north-up of the computed attitude: the Earth's rate, rotated by the heading error.
struct RestRate {
  double time, duration;  ///< [s]; `time` is relative to the end of the first block
  Vector3d rate_n;        ///< rad/s
};

/// The observed heading error of the gyros in a rest, in its standard deviations, and its variance.
struct SeenHeading {
  std::size_t last;  ///< last block of the rest
  double whitened, variance;
};

/// Correlation of successive values, and its standard deviation if they are white.
struct Serial {
  double correlation = 0, sigma = 0;
};

struct Pass {
  Matrix3d start;     ///< attitude at the start about which the pass was linearized
  Eigen::VectorXd x;  ///< constants, and errors of attitude and velocity at the end
  Eigen::MatrixXd covariance;
  std::vector<double> chi2;  ///< chi-square of each block's innovation, with three degrees of freedom; zero without observation
  Serial serial;             ///< serial correlation of the innovations
  std::vector<SeenHeading> headings;
  std::vector<CurvePoint> curve;  ///< thinned
  std::vector<RestRate> rates;
  Separation::Estimate effects = {};  ///< empty: no effects were estimated
  Eigen::MatrixXd across = {};        ///< covariance of x with the effects
  std::vector<EffectState> states;    ///< at the end of each block, if effects were estimated

  double total_chi2() const { return std::accumulate(chi2.begin(), chi2.end(), 0.0); }
  double chi2_of_headings() const {
    return std::accumulate(headings.begin(), headings.end(), 0.0, [](double sum, const SeenHeading& h) { return sum + h.whitened * h.whitened; });
  }
};

/// Makes one pass over the blocks. States are errors of the model about which they are linearized; only the level is fed back, after each block at
/// rest. `known` is the prior of the constants.
Pass filter_pass(const Data& data, const Linearization& about, const States& states, const kernel::Parameters& known,
                 const PassOptions& options = {});

}  // namespace imulab::hybrid
