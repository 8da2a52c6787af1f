// The states of the hybrid filter in one table: meaning, order, prior, and corrected coefficient. The constants come first, group by group, then the
// errors of attitude and velocity.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/estimate/kernel/information.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/navigation/in_place/navigator.hpp"
#include "imulab/session.hpp"

#include <array>
#include <set>
#include <string_view>
#include <vector>

namespace imulab::hybrid {

using in_place::Noise;

/// The location of the IMU.
struct Place {
  double latitude, gravity;  ///< rad, m/s^2
  double latitude_sigma = 0, gravity_sigma = 0;
};
/// Returns the place of a site. Throws Error if the site has no latitude.
Place place_of(const Site& site);
/// Adds the latitude sigma of the effect if the site declares none.
Place with_latitude_effect(Place place, const Session& session);

/// Priors of the optional terms.
struct OptionalPriors {
  kernel::PriorSizes sizes{.accel = {.quadratic = 1e-3}, .gyro = {}, .g_sensitivity = 1e-3, .lever_arm = 1};  ///< nearly uninformative
  double delay = 0.1;                                                                                         ///< s
  double smear = 0.01;                                                                                        ///< s^2
};

/// Returns true if the IMU also stays in one place while it turns.
bool on_turntable(const Session& session);

/// The constants in their order (Cheng 2014 eq 19, and more): errors ba, Ma, bg, Mg of the calibrated output df = ba + Ma f, dw = bg + Mg w (Ma lower
/// triangular), relative error of gravity, attitude error at the start. The groups from `latitude` on are optional: latitude error [rad], lever arms
/// [m], quadratic terms, g-sensitivity, delay of the accelerometers' output relative to the gyros' [s], and its mean square `smear` if a filter
/// spreads it over time [s^2]. With slow noise: `flicker`, the processes of each axis, accelerometers first; and `mean`, the mean offsets so far, to
/// which each block adds its part, the offsets that are stated. Last `rest_heading`: heading change due to gyro errors in the present rest [rad].
enum class Group {
  accel_offset,
  accel_matrix,
  gyro_offset,
  gyro_matrix,
  gravity,
  start,
  latitude,
  lever_arm,
  quadratic,
  g_sensitivity,
  delay,
  smear,
  flicker,
  mean,
  rest_heading
};
using Groups = std::set<Group>;

/// The relation of a group of states to the point of linearization.
enum class Linearity {
  corrected,  ///< corrects the model or the place: the state is the remainder
  whole,      ///< one value, which each pass estimates anew
  path        ///< values along the motion, which each pass estimates anew
};
Linearity linearity(Group group);

struct Terms {
  std::vector<CoefficientIndex> wanted = {};  ///< empty: all
  Groups optional = {};                       ///< estimated under their priors
  OptionalPriors priors = {};
};
/// Returns the terms that a calibration of this session estimates or considers, and their priors, from the observed properties of the IMU and the
/// sample interval. `wanted` is CalibrationOptions::terms. Throws TermsError.
Terms terms_of(const Session& session, const std::vector<CoefficientIndex>& wanted, const kernel::SeenOfUnit& seen, double interval_s);

/// Returns a name: "accel.lever_arm", "latitude", ...
std::string_view name(Group group);

/// Returns the standard deviations of an alignment on one rest: level, level, heading [rad].
Eigen::Vector3d alignment_sigma();

class States {
 public:
  /// Includes optional groups of the terms, the latitude if it is uncertain, and states for slow noise. Coefficients that are not wanted are fixed.
  States(const Terms& terms, const Place& place, const Noise& noise = {});

  Eigen::VectorXd prior;  ///< prior sigma of each constant about the coarse solution; 0: fixed there
  CoefficientIndex corrects(Eigen::Index constant) const { return corrects_[static_cast<std::size_t>(constant)]; }  ///< -1: none

  Groups groups() const;                ///< groups in the model
  in_place::OptionalSums sums() const;  ///< sums that the terms need
  bool has(Group group) const { return first(group) >= 0; }
  Eigen::Index first(Group group) const { return places_[static_cast<std::size_t>(group)].first; }  ///< place of its first state; -1: absent
  Eigen::Index size(Group group) const { return places_[static_cast<std::size_t>(group)].size; }
  Eigen::Index offset(Eigen::Index axis) const;  ///< axes of the accelerometers, then of the gyros
  Eigen::Index constants() const { return prior.size(); }
  Eigen::Index attitude() const { return constants(); }
  Eigen::Index size() const { return constants() + 6; }

  /// Returns the constants that correct a coefficient and are not fixed.
  std::vector<Eigen::Index> corrections() const;
  /// Returns the constants of a model that was corrected by `total` since the coarse solution.
  kernel::Parameters parameters(const Eigen::VectorXd& total) const;
  /// Returns the sigmas below which coefficients count as determined (half the prior), optional ones as observable (nine tenths); else infinite.
  Eigen::VectorXd needed() const;

 private:
  struct Span {
    Eigen::Index first = -1, size = 0;
  };
  std::array<Span, 15> places_;
  std::vector<CoefficientIndex> corrects_;
};

/// Returns all coefficients that constants can correct, and the optional groups of given coefficients.
std::vector<CoefficientIndex> all_coefficients();
Groups optional_groups(const std::vector<CoefficientIndex>& coefficients);

/// Returns the model whose output is that of `model` minus the errors x (model/forward_model.hpp).
SensorModel corrected(const SensorModel& model, const Eigen::VectorXd& x, const States& states);

/// Returns the model with the mean offsets over the recording if slow noise changes them.
SensorModel with_mean_offsets(const SensorModel& model, const Eigen::VectorXd& x, const States& states);

/// Returns errors of attitude (first three rows) and velocity after a block from all states before it.
Eigen::Matrix<double, 6, Eigen::Dynamic> transition(const in_place::BlockSums& sums, const States& states, const Place& place);

/// Returns derivatives of the coefficients `indices` of the corrected model with its mean offsets by the constants, at x = 0.
Eigen::MatrixXd correction_jacobian(const SensorModel& model, const std::vector<CoefficientIndex>& indices, const States& states);

}  // namespace imulab::hybrid
