// The states of the hybrid filter, in one table: their meaning, their order, their priors, and the coefficient that each corrects. The constants come
// first, group by group, then the errors of attitude and velocity.
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

/// The place of the IMU.
struct Place {
  double latitude, gravity;  ///< rad, m/s^2
  double latitude_sigma = 0, gravity_sigma = 0;
};
/// Throws Error where the site has no latitude.
Place place_of(const Site& site);
/// With the latitude's sigma of the effects, where the site declares none.
Place with_latitude_effect(Place place, const Session& session);

/// Priors of the optional terms.
struct OptionalPriors {
  kernel::PriorSizes sizes{.accel = {.quadratic = 1e-3}, .gyro = {}, .g_sensitivity = 1e-3, .lever_arm = 1};  ///< as good as none
  double delay = 0.1;                                                                                         ///< s
  double smear = 0.01;                                                                                        ///< s^2
};

/// The IMU stays in one place while it turns, too.
bool on_turntable(const Session& session);

/// The constants in their order (Cheng 2014 eq 19, and more): errors ba, Ma, bg, Mg of the calibrated output df = ba + Ma f, dw = bg + Mg w (Ma lower
/// triangular), relative error of gravity, attitude error at the start. From `latitude` on they are optional: error of the latitude [rad], lever arms
/// [m], quadratic terms, g-sensitivity, delay of the accelerometers' output behind the gyros' [s], and its mean square `smear` where it is spread
/// over a time, as by a filter [s^2]. With slow noise `flicker`, the processes of each axis, accelerometers first; and `mean`, of the offsets over
/// the time so far, of which each block adds its part: the offsets that are stated. Last, `rest_heading`: what the gyros' errors add to the heading
/// in the present rest [rad].
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
  corrected,  ///< the model or the place is corrected by it: the state is what remains
  whole,      ///< one value that each pass estimates anew
  path        ///< values along the motion, which each pass estimates anew
};
Linearity linearity(Group group);

struct Terms {
  std::vector<CoefficientIndex> wanted = {};  ///< empty: all
  Groups optional = {};                       ///< estimated under their priors
  OptionalPriors priors = {};
};
/// The terms that a calibration of this session estimates or considers, and their priors: with what is seen of the IMU and a sample's interval.
/// `wanted` as CalibrationOptions::terms. Throws TermsError.
Terms terms_of(const Session& session, const std::vector<CoefficientIndex>& wanted, const kernel::SeenOfUnit& seen, double interval_s);

/// "accel.lever_arm", "latitude", ...
std::string_view name(Group group);

/// Standard deviation of an alignment on one rest: level, level, heading [rad].
Eigen::Vector3d alignment_sigma();

class States {
 public:
  /// With the optional groups of the terms, the latitude where it is uncertain, and what slow noise needs. Coefficients that are not wanted are
  /// fixed.
  States(const Terms& terms, const Place& place, const Noise& noise = {});

  Eigen::VectorXd prior;  ///< by constant: standard deviation about the coarse solution; 0: fixed there
  CoefficientIndex corrects(Eigen::Index constant) const { return corrects_[static_cast<std::size_t>(constant)]; }  ///< -1: none

  Groups groups() const;                ///< that are in the model
  in_place::OptionalSums sums() const;  ///< that its terms need
  bool has(Group group) const { return first(group) >= 0; }
  Eigen::Index first(Group group) const { return places_[static_cast<std::size_t>(group)].first; }  ///< place of its first state; -1: absent
  Eigen::Index size(Group group) const { return places_[static_cast<std::size_t>(group)].size; }
  Eigen::Index offset(Eigen::Index axis) const;  ///< of the accelerometers, then of the gyros
  Eigen::Index constants() const { return prior.size(); }
  Eigen::Index attitude() const { return constants(); }
  Eigen::Index size() const { return constants() + 6; }

  /// Constants that correct a coefficient and are not fixed.
  std::vector<Eigen::Index> corrections() const;
  /// The constants of a model that has been corrected by `total` since the coarse solution.
  kernel::Parameters parameters(const Eigen::VectorXd& total) const;
  /// The data determine a coefficient where they halve its prior, and say something of an optional one where they take a tenth of it; infinite for
  /// the other constants.
  Eigen::VectorXd needed() const;

 private:
  struct Span {
    Eigen::Index first = -1, size = 0;
  };
  std::array<Span, 15> places_;
  std::vector<CoefficientIndex> corrects_;
};

/// All coefficients that constants can correct, and the optional groups that these are of.
std::vector<CoefficientIndex> all_coefficients();
Groups optional_groups(const std::vector<CoefficientIndex>& coefficients);

/// The model whose output is that of `model` less the errors x (model/forward_model.hpp).
SensorModel corrected(const SensorModel& model, const Eigen::VectorXd& x, const States& states);

/// The model with the mean of its offsets over the recording, where slow noise lets them change.
SensorModel with_mean_offsets(const SensorModel& model, const Eigen::VectorXd& x, const States& states);

/// Errors of attitude (first three rows) and velocity after a block from all states before it.
Eigen::Matrix<double, 6, Eigen::Dynamic> transition(const in_place::BlockSums& sums, const States& states, const Place& place);

/// Derivatives of the table coefficients `indices` of the corrected model with its mean offsets by the constants, at x = 0.
Eigen::MatrixXd correction_jacobian(const SensorModel& model, const std::vector<CoefficientIndex>& indices, const States& states);

}  // namespace imulab::hybrid
