// Whole-unit calibration as least squares: at every point, the compensated means must equal the motion of the machine (Dai 2011 eqs 5, 7, 10),
//
//   e = compensate(theta; raw, temperature) - motion(eta)
//
// where theta are the coefficients and eta the errors common to many points: g and the machines' errors, each with its declared sigma. The
// contribution of effects of the table is subtracted from the compensated means.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/estimate/kernel/information.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/rig/machine_points.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/simulate.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace imulab::whole_unit {

/// Declared colored noise of a channel: one of its independent shapes along the points of a recording.
struct ChannelDrift {
  std::size_t recording = 0;
  int channel = 0;
  Eigen::VectorXd shape;  ///< one element per step
  /// Returns the output at a point for one unit of the drift; 0 in other recordings.
  double at(const MachinePoint& point) const;
};

/// An error common to several points: of g, a machine, or a channel.
struct CommonError {
  std::string rig;  ///< name of the rig; empty: gravity
  RigErrorSource source{};
  double sigma = 0;  ///< declared sigma; 0: known exactly
  double value = 0;  ///< estimated difference from the declaration
  std::optional<ChannelDrift> drift = {};
  std::string name() const;
};

/// Residuals and derivatives of one point.
struct PointEquations {
  Vector6d residual;                                  ///< e: m/s^2, rad/s
  Vector6d white;                                     ///< e divided by the Cholesky factor of its noise
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian;  ///< likewise, with respect to theta, eta and the effects
};

/// The coefficients that have a prior in a fit.
enum class Priors {
  /// Of considered coefficients only offsets, so that other terms do not have to explain them; the others keep their starting values, because a scale
  /// that nothing excites would shrink under a prior to reduce the noise of its row. Used for the estimate.
  offsets,
  considered,  ///< all considered coefficients; used for the covariance
  all,         ///< estimated ones, too; used for a start, and to decide what the data determine
};

struct PointProblem {
  /// `starting_model` applies to readings minus `reading_center`.
  PointProblem(MachinePoints used, const Session& declared, const SensorModel& starting_model, const Vector6d& reading_center);

  MachinePoints points;
  const Session* session;
  Site site;                                   ///< as declared, or mirrored
  SensorModel start, model;                    ///< models of readings minus `center`: prior value and present value
  Vector6d center;                             ///< raw
  std::vector<CoefficientIndex> coefficients;  ///< theta
  /// Roles of theta. Estimated: from the data alone. Considered: not determined by the data. Fixed: left out.
  std::vector<kernel::Role> role;
  Eigen::VectorXd prior_sigma, needed_sigma;             ///< sigmas of theta: before the data; below which it is determined
  std::vector<CommonError> common;                       ///< eta, follows theta in every parameter vector
  kernel::Effects effects;                               ///< follow eta in every parameter vector
  std::vector<std::vector<Eigen::MatrixXd>> by_effects;  ///< derivatives of the residuals, by recording and point
  Vector6d noise;                                        ///< variance of one sample of force and rate
  std::vector<Vector6d> point_variance;  ///< variance of a point's means, by recording, due to declared noise that is independent between points
  double noise_factor = 1;               ///< factor on standard deviations
  bool ideal = false;                    ///< error-free points: effects keep their expected sizes

  Eigen::Index size() const { return static_cast<Eigen::Index>(coefficients.size() + common.size()) + effects.size(); }
  /// Also estimates effects of the table; the grade follows from the observations if none is declared.
  void add_effects(const kernel::SeenOfUnit& seen);
  /// Moves the latitude to the other side of the equator.
  void mirror_latitude();
  /// Updates the effects for the present motion of the machines.
  void update_effects();
  RawSample sample(const MachinePoint& point) const;
  /// Returns the machine's motion at this point with the drift of the channels, and its derivative with respect to eta.
  Motion motion(const MachinePoint& point, Eigen::Matrix<double, 6, Eigen::Dynamic>* motion_by_common = nullptr) const;
  std::array<double, 2> full_scale() const;  ///< largest force and rate that the machines produced along an axis, m/s^2 and rad/s
  /// Returns the variance of one sample of force and rate within the points, with the slopes of the present model.
  Vector6d measured_noise() const;
  /// Sets `noise` to the declared densities, else as measured; larger for correlated noise.
  void update_noise();
  PointEquations equations(const MachinePoint& point) const;
  /// Returns the information of the points p with p % parts == part.
  kernel::Information information(std::size_t part = 0, std::size_t parts = 1) const;
  kernel::Parameters parameters(Priors priors = Priors::offsets) const;
  void correct(const Eigen::VectorXd& x);

 private:
  /// Adds declared colored noise: in each recording, its shapes along the points that exceed independent noise. Shapes that differ from independent
  /// noise by less than a tenth count as such, because thermal terms have such slow shapes.
  void add_drifts();
  /// Returns the parameters on which the points of a recording depend.
  std::vector<Eigen::Index> acting_columns(std::size_t recording) const;

  /// Sets the place for the present latitude, and dependent properties of the points.
  void set_place();

  std::vector<std::vector<std::size_t>> acting_;  ///< indices of effective elements of eta, by recording
  MachinePlace<double> place_;
  Eigen::Index latitude_ = -1;  ///< index among the effects: the motion of the machine is not linear in the latitude
};

/// Returns compensation_derivatives with accelerometer rows and columns before those of gyros, as in the points.
CompensationDerivatives accel_first_derivatives(const SensorModel& model, const RawSample& raw);

struct Fit {
  kernel::Information data;       ///< before the last correction
  kernel::Parameters parameters;  ///< before the last correction
  bool converged = false;
  kernel::Solution solution() const { return kernel::solve(data, parameters, "the points"); }
};

/// Iterates Gauss-Newton steps until every correction is below 1 % of its sigma. Throws Unsupported if the normal equations are singular.
Fit fit(PointProblem& problem, Priors priors = Priors::offsets);

}  // namespace imulab::whole_unit
