// The Kalman filter of the hybrid method: what the computed velocity and attitude of a unit that turns in its place say about its calibration
// (Cheng 2014 sec 2). Nothing of a table's angles enters: the only reference is that the unit stays where it is.
//
//   phi' = -w_in x phi - C_nb dw        attitude error, C_hat = (I - [phi x]) C
//   dV'  =  f_n x phi + C_nb df         velocity error; the velocity is zero
//   df = ba + Ma f,  dw = bg + Mg w     of the calibrated output; Ma lower triangular
#pragma once

#include "imulab/model/sensor_model.hpp"
#include "imulab/recording/recording.hpp"

#include <Eigen/Core>

#include <limits>
#include <optional>
#include <vector>

namespace imulab {

/// Terms beyond the paper's 27 states.
struct HybridTerms {
  bool lever_arm = false;      ///< nine lengths: the accelerometers' size effect
  bool quadratic = false;      ///< accelerometers, one an axis
  bool g_sensitivity = false;  ///< nine
  bool delay = false;          ///< of the accelerometers behind the gyros [s]
  bool operator==(const HybridTerms&) const = default;
};

/// Where the states are; -1: absent. Constants come first, then attitude and velocity: what changes stands last.
struct HybridLayout {
  static constexpr Eigen::Index accel_offset = 0, accel_matrix = 3;  ///< ba; Ma: xx, yx, yy, zx, zy, zz
  static constexpr Eigen::Index gyro_offset = 9, gyro_matrix = 12;   ///< bg; Mg row by row
  static constexpr Eigen::Index gravity = 21;                        ///< relative error of the declared gravity
  static constexpr Eigen::Index start = 22;                          ///< attitude error at the start
  Eigen::Index latitude = -1, lever_arm = -1, quadratic = -1, g_sensitivity = -1, delay = -1;
  Eigen::Index constants = 25;
  Eigen::Index attitude() const { return constants; }
  Eigen::Index velocity() const { return constants + 3; }
  Eigen::Index size() const { return constants + 6; }
};
HybridLayout hybrid_layout(const HybridTerms& terms, bool latitude);

/// A stretch of samples after which the filter looks at the velocity, if that is known to be zero then.
struct HybridBlock {
  Range samples;
  bool at_rest = false, observed = true;
  bool lost = false;  ///< the motion before it was not seen (a gap, a saturated sample): its attitude begins anew
};

struct HybridSite {
  double latitude, gravity;  // rad, m/s^2
  double latitude_sigma = 0, gravity_sigma = 0;
};

/// Densities of the calibrated output, per axis; velocity: how far from zero it is after a block [m/s].
struct HybridNoise {
  Vector3d gyro, accel;                                                  // rad/s/sqrt(Hz), m/s^2/sqrt(Hz)
  Vector3d gyro_walk = Vector3d::Zero(), accel_walk = Vector3d::Zero();  // of the offsets, u/sqrt(s)
  double velocity = 0;
};

/// The estimate after a block.
struct HybridPoint {
  double time;  // s
  Eigen::VectorXd x, sigma;
};

struct HybridPass {
  Matrix3d start;     ///< attitude at the start, as the pass took it
  Eigen::VectorXd x;  ///< constants, and attitude and velocity at the end
  Eigen::MatrixXd covariance;
  std::vector<double> chi2;          ///< of the innovations, three degrees of freedom each; NaN where nothing was observed or it was rejected
  std::vector<Vector3d> innovation;  ///< whitened, by block
  std::vector<HybridPoint> curve;    ///< thinned
};

struct HybridSettings {
  HybridLayout layout;
  std::optional<Matrix3d> start;        ///< attitude at the start where the pass is linearised; absent: by alignment on the first rest
  std::optional<Vector3d> start_sigma;  ///< of `start`; absent: that of an alignment
  double outlier = std::numeric_limits<double>::infinity();  ///< an innovation beyond this chi-square is left out
  double curve_interval = 0;                                 ///< s between the points of `curve`; 0: none
};

/// One pass over the blocks with the sensor model as the point of linearisation; the errors stay small states beside it. `prior`, `prior_sigma`: of
/// the constants, the start's attitude left to the alignment. Lever arms of the model are removed from the readings. The covariance is carried as its
/// Cholesky factor: exactly known velocities after wide priors would leave nothing of a covariance's digits.
HybridPass hybrid_pass(const Recording& recording, const std::vector<HybridBlock>& blocks, const SensorModel& model, const HybridSite& site,
                       const HybridNoise& noise, const HybridSettings& settings, const Eigen::VectorXd& prior, const Eigen::VectorXd& prior_sigma);

}  // namespace imulab
