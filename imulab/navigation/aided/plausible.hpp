// What contradicts itself in the data of an aided navigation: in the aids' records before the filter, and in its estimates after it.
#pragma once

#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/filter.hpp"

#include <string>
#include <vector>

namespace imulab::aided {

/// Takes away what a receiver did not measure, and says so in `out`; a doubt where that is most of its positions: rows of latitude and longitude 0;
/// positions that repeat the one before exactly, five times in a row or more, and with them a velocity that repeats and is not zero; and at the begin
/// of the navigation positions from which no motion leads to the others. Names an aid that is nowhere near the initial state or the site. Throws
/// Error where a receiver's displacements fit its velocities with latitude and longitude swapped alone.
void take_unmeasured(std::vector<Aid>& aids, const Session& session, const Recording& recording, AidedNavigation& out);

/// Where many values of a source in a row are suspects.
std::vector<std::string> runs_of_suspects(const AidedNavigation& navigation);

/// Levels that a receiver's slow error reaches though its law forbids them: another datum or geoid, a permanent jump, a second receiver that
/// contradicts. Which level is right is not known: the covariance of the positions gets its square.
/// `times`: of the smoothed nodes [s].
void widen_by_levels(const Problem& problem, const std::vector<double>& times, const SmootherPass& smoothed, AidedNavigation& out);

/// Doubts about a navigation without observations, and about estimates that the declarations exclude: constants far from their priors, noise of the
/// IMU far above its declaration.
std::vector<std::string> implausible_estimates(const Problem& problem, const SmoothedNode& last, const AidedNavigation& out);

}  // namespace imulab::aided
