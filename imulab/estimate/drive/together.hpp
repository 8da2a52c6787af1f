// Several drives of one unit as one estimate of its constants.
//
// A drive states x of covariance P under a prior of mean zero and covariance P0, so that its data alone say N = P^-1 - P0^-1 and g = P^-1 x. An
// offset is that of the unit and a change of the drive's own, t of covariance T = S S^T, which is eliminated:
//
//   N <- N - N S (I + S^T N S)^-1 S^T N,   g <- g - N S (I + S^T N S)^-1 S^T g
//
// The unit's constants have the covariance (P0^-1 + sum of N)^-1, with P0 less the change of a turn-on. What each drive adds to the others is as
// large as the covariances say, or it contradicts them.
#pragma once

#include "imulab/navigation/aided/aided.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace imulab::drive {

struct Drive {
  std::string name;  // of its recording
  AidedNavigation navigation;
  double gyro_change = 0, accel_change = 0;    // variances of the offsets from those of the unit: turn-on and slow noise [SI]
  double gyro_turn_on = 0, accel_turn_on = 0;  // those of them that the prior has, too
};

/// A constant of the unit; the others are of an aid, or an effect in one drive.
bool of_unit(const AidedConstant& constant);
bool of_aid(const AidedConstant& constant);

/// A drive against all others: the square of what it adds to them, in its covariance.
struct Contradiction {
  std::string drive, worst;  // the constant that is farthest off
  double chi2 = 0, freedom = 0, sigmas = 0;
};

struct Together {
  AidedNavigation navigation;  // constants: of the unit, then those of each drive's aids, with its name in front
  std::vector<Contradiction> contradictions;
};

/// Of one drive its own constants. All drives have the same priors.
Together together(const std::vector<Drive>& drives);

}  // namespace imulab::drive
