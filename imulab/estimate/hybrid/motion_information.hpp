// The hybrid filter's equations as information: what a rest or a turn tells of the constants and of the attitude errors at its ends. Stretches of
// motion add up in any order of joining, so that paths can be put together from parts.
//
//   phi1 = phi0 - T w_in x phi0 - int C dw
//   0    = int f_n x phi + int C df            the velocity is zero at both ends
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/estimate/hybrid/prediction.hpp"
#include "imulab/navigation/in_place/navigator.hpp"

#include <vector>

namespace imulab::hybrid {

/// White noise alone: offsets that wander are not in it, and neither are terms that are only considered.
struct InformationModel {
  Place place;
  Noise noise;
  States states;
  bool observe_motion;
  std::vector<Eigen::Index> constants;  ///< that are unknown, but for the attitude at the start

  explicit InformationModel(const Plan& plan);
  Eigen::Index size() const { return static_cast<Eigen::Index>(constants.size()); }
};

/// Information on (constants, attitude error at the beginning, attitude error at the end).
using MotionInformation = Eigen::MatrixXd;
/// Information on (constants, attitude error now).
using Knowledge = Eigen::MatrixXd;

/// The parts of the rests before and after a turn by hand that belong to the turn [s]: their settling, and the first second after which the velocity
/// is seen again.
inline constexpr int unseen_before = 1, unseen_after = 2;
static_assert(unseen_before == in_place::settling_time && unseen_after == in_place::settling_time + 1);

/// A turn from rest to rest about an axis that is fixed in n, in a trapezoid of rate.
struct Turn {
  Vector3d axis;                     ///< of n, unit vector
  double angle, rate, acceleration;  ///< rad, rad/s, rad/s^2; the sign is the angle's
};
/// What is used of a rest [s]: while it is still, and while it settles. The velocity is zero in both; in the first the heading stays.
struct RestSeconds {
  int still, settling = 0;
};
/// Of a rest between two turns, or at the beginning or end of the recording, whose outermost second is not used.
RestSeconds used_seconds(const InformationModel& model, int rest, bool outermost);
MotionInformation rest_information(const InformationModel& model, const Matrix3d& C_nb, RestSeconds seconds);
MotionInformation turn_information(const InformationModel& model, const Matrix3d& C_nb, const Turn& turn);

MotionInformation joined(const MotionInformation& first, const MotionInformation& second);

/// Before anything is seen.
Knowledge prior_knowledge(const InformationModel& model);
/// The knowledge after a predicted procedure.
Knowledge knowledge_of(const InformationModel& model, const FilterPrediction& prediction);
Knowledge after(const Knowledge& before, const MotionInformation& motion);

/// Standard uncertainties of the constants.
Eigen::VectorXd sigma_of(const Knowledge& knowledge);

}  // namespace imulab::hybrid
