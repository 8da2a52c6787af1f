// Combines several drives of one unit into one estimate of its constants.
//
// A drive has the estimate x with covariance P under a zero-mean prior with covariance P0, so its data alone have N = P^-1 - P0^-1 and g = P^-1 x. An
// offset is the sum of the unit's offset and a change in the drive, t of covariance T = S S^T, which is eliminated:
//
//   N <- N - N S (I + S^T N S)^-1 S^T N,   g <- g - N S (I + S^T N S)^-1 S^T g
//
// The unit's constants have the covariance (P0^-1 + sum of N)^-1, where P0 excludes the turn-on change. The change of the combined estimate by a
// drive must agree with the covariances; otherwise the drive contradicts the others.
#pragma once

#include "imulab/navigation/aided/aided.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace imulab::drive {

struct Drive {
  std::string name;  // name of the recording
  AidedNavigation navigation;
  double gyro_change = 0, accel_change = 0;    // variances of the offsets relative to those of the unit: turn-on and slow noise [SI]
  double gyro_turn_on = 0, accel_turn_on = 0;  // part of these variances that is also in the prior
};

/// Return true for a constant of the unit, and of an aid. Other constants are effects in one drive.
bool of_unit(const AidedConstant& constant);
bool of_aid(const AidedConstant& constant);

/// A drive compared with all others: chi-square of its change of their estimate.
struct Contradiction {
  std::string drive, worst;  // `worst` is the constant with the largest contradiction
  double chi2 = 0, freedom = 0, sigmas = 0;
};

struct Together {
  AidedNavigation navigation;  // constants of the unit, then those of each drive's aids, prefixed with its name
  std::vector<Contradiction> contradictions;
};

/// Combines drives; a single drive keeps its own constants. All drives must have the same priors.
Together together(const std::vector<Drive>& drives);

}  // namespace imulab::drive
