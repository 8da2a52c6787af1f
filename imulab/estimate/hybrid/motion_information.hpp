// The equations of the hybrid filter as information: a rest or turn is informative about the constants and the attitude errors at its ends. Motions
// can be joined in any grouping, so that paths can be assembled from parts.
//
//   phi1 = phi0 - T w_in x phi0 - int C dw
//   0    = int f_n x phi + int C df            the velocity is zero at both ends
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/navigation/in_place/navigator.hpp"

#include <vector>

namespace imulab::hybrid {

/// The unknowns of the information. It includes white noise only, without wandering offsets and terms that are only considered.
struct InformationModel {
  Place place;
  Noise noise;
  States states;
  bool observe_motion;
  std::vector<Eigen::Index> constants;  ///< unknown constants, except for the attitude at the start

  explicit InformationModel(const Plan& plan);
  Eigen::Index size() const { return static_cast<Eigen::Index>(constants.size()); }
};

/// Information about (constants, attitude error at the start, attitude error at the end).
using MotionInformation = Eigen::MatrixXd;
/// Information about (constants, present attitude error).
using Knowledge = Eigen::MatrixXd;

/// Parts of the rests before and after a turn by hand that belong to the turn [s]: settling, and the first second before the velocity is observed.
inline constexpr int unseen_before = 1, unseen_after = 2;
static_assert(unseen_before == in_place::settling_time && unseen_after == in_place::settling_time + 1);

/// A turn from rest to rest about an axis fixed in n, with a trapezoidal rate.
struct Turn {
  Vector3d axis;                     ///< unit vector in n
  double angle, rate, acceleration;  ///< rad, rad/s, rad/s^2; the angle determines the sign
};
/// The used parts of a rest [s]: still, and settling. The velocity is zero in both; the heading is constant in the first.
struct RestSeconds {
  int still, settling = 0;
};
/// Returns the used parts of a rest; `outermost`: at the start or end of the recording, where the outermost second is not used.
RestSeconds used_seconds(const InformationModel& model, int rest, bool outermost);
MotionInformation rest_information(const InformationModel& model, const Matrix3d& C_nb, RestSeconds seconds);
MotionInformation turn_information(const InformationModel& model, const Matrix3d& C_nb, const Turn& turn);

MotionInformation joined(const MotionInformation& first, const MotionInformation& second);

/// Returns the knowledge before any observation.
Knowledge prior_knowledge(const InformationModel& model);
/// Returns the knowledge after a predicted procedure.
Knowledge knowledge_of(const InformationModel& model, const FilterPrediction& prediction);
Knowledge after(const Knowledge& before, const MotionInformation& motion);

/// Returns the standard uncertainties of the constants.
Eigen::VectorXd sigma_of(const Knowledge& knowledge);

}  // namespace imulab::hybrid
