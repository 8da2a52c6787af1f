// Whole-unit calibration as least squares: at every point the compensated means must equal the motion of the machine (Dai 2011 eqs 5, 7, 10 in
// one),
//
//   e = compensate(theta; raw, temperature) - motion(eta)
//
// with theta the coefficients and eta the errors that many points share: g and the machines' errors, each with its declared sigma. With effects of
// the table, what they add to the compensated means is taken off.
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

/// Declared noise of a channel that is not white: one of the independent shapes that it has along the points of a recording.
struct ChannelDrift {
  std::size_t recording = 0;
  int channel = 0;
  Eigen::VectorXd shape;  ///< by number of the step
  /// The output of a point for one unit of the drift; 0 in other recordings.
  double at(const MachinePoint& point) const;
};

/// An error common to several points: of g, of a machine, or of a channel.
struct CommonError {
  std::string rig;  ///< its name; empty: gravity
  RigErrorSource source{};
  double sigma = 0;  ///< as declared; 0: known exactly
  double value = 0;  ///< estimated, beyond what is declared
  std::optional<ChannelDrift> drift = {};
  std::string name() const;
};

/// One point's residuals and derivatives.
struct PointEquations {
  Vector6d residual;                                  ///< e itself: m/s^2, rad/s
  Vector6d white;                                     ///< divided by the Cholesky factor of its noise
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian;  ///< likewise, by theta, eta and the effects
};

/// Which coefficients have a prior in a fit.
enum class Priors {
  offsets,  ///< of the considered ones the offsets alone, as other terms would have to explain them; the others stay at their starting values: left
            ///< to a prior, a scale that nothing excites would shrink to rid its row of noise. For the estimate.
  considered,  ///< all the considered ones: for the covariance
  all,         ///< the estimated ones, too: for a start, and for what the data determine
};

struct PointProblem {
  /// `starting_model`: of readings less `reading_center`.
  PointProblem(MachinePoints used, const Session& declared, const SensorModel& starting_model, const Vector6d& reading_center);

  MachinePoints points;
  const Session* session;
  Site site;                                   ///< as declared, or mirrored
  SensorModel start, model;                    ///< of readings less `center`: the prior value, and the present one
  Vector6d center;                             ///< raw
  std::vector<CoefficientIndex> coefficients;  ///< theta
  /// The roles of theta. Estimated: by the data alone. Considered: the data do not determine it. Fixed: left out.
  std::vector<kernel::Role> role;
  Eigen::VectorXd prior_sigma, needed_sigma;             ///< of theta: before the data; below this they determine it
  std::vector<CommonError> common;                       ///< eta, after theta in every vector of parameters
  kernel::Effects effects;                               ///< after eta in every vector of parameters
  std::vector<std::vector<Eigen::MatrixXd>> by_effects;  ///< by recording and number of the point: derivatives of the residuals
  Vector6d noise;                                        ///< variance of one sample of force and rate
  std::vector<Vector6d> point_variance;  ///< by recording: of a point's means, from declared noise that is independent from point to point
  double noise_factor = 1;               ///< of the standard deviations
  bool ideal = false;                    ///< points without errors: sizes of effects stay the expected ones

  Eigen::Index size() const { return static_cast<Eigen::Index>(coefficients.size() + common.size()) + effects.size(); }
  /// Estimates the effects of the table, too; their grade is that of what is seen if none is declared.
  void add_effects(const kernel::SeenOfUnit& seen);
  /// Takes the latitude as that on the other side of the equator.
  void mirror_latitude();
  /// The effects at the present motion of the machines.
  void update_effects();
  RawSample sample(const MachinePoint& point) const;
  /// The machine's motion at this point with the channels' drift, and its derivative by eta.
  Motion motion(const MachinePoint& point, Eigen::Matrix<double, 6, Eigen::Dynamic>* motion_by_common = nullptr) const;
  std::array<double, 2> full_scale() const;  ///< the largest force and rate along an axis that the machines made, m/s^2 and rad/s
  /// Variance of one sample of force and rate within the points, with the slopes of the present model.
  Vector6d measured_noise() const;
  /// Sets `noise`: the declared densities, else as measured; larger where the noise is correlated.
  void update_noise();
  PointEquations equations(const MachinePoint& point) const;
  /// The information of the points p with p % parts == part.
  kernel::Information information(std::size_t part = 0, std::size_t parts = 1) const;
  kernel::Parameters parameters(Priors priors = Priors::offsets) const;
  void correct(const Eigen::VectorXd& x);

 private:
  /// Declared noise that is not white: in each recording its shapes along the points that stand out of independent noise; the others, which differ
  /// from it by less than a tenth, count as that: thermal terms are seen in just such slow shapes.
  void add_drifts();
  /// The parameters on which the points of a recording depend.
  std::vector<Eigen::Index> acting_columns(std::size_t recording) const;

  /// The place at the present latitude, and what the points depend on it.
  void set_place();

  std::vector<std::vector<std::size_t>> acting_;  ///< by recording: indices of eta that may act
  MachinePlace<double> place_;
  Eigen::Index latitude_ = -1;  ///< among the effects: it is in the machine's motion, which is not linear in it
};

/// compensation_derivatives with the rows and columns of accelerometers before those of gyros, as the points have them.
CompensationDerivatives accel_first_derivatives(const SensorModel& model, const RawSample& raw);

struct Fit {
  kernel::Information data;       ///< before the last correction
  kernel::Parameters parameters;  ///< likewise
  bool converged = false;
  kernel::Solution solution() const { return kernel::solve(data, parameters, "the points"); }
};

/// Gauss-Newton until the correction is below a hundredth of its standard deviation everywhere. Throws Unsupported where the normal equations are
/// singular.
Fit fit(PointProblem& problem, Priors priors = Priors::offsets);

}  // namespace imulab::whole_unit
