// What contradicts itself in the estimates of an aided navigation.
#pragma once

#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/filter.hpp"

#include <string>
#include <vector>

namespace imulab::aided {

/// Where many values of a source in a row are suspects.
void find_runs_of_suspects(AidedNavigation& navigation);

/// Levels that a receiver's slow error reaches though its law forbids them: another datum or geoid, a permanent jump, a second receiver that
/// contradicts. Which level is right is not known: the covariance of the positions gets its square.
void widen_by_levels(const Problem& problem, const SmootherPass& smoothed, AidedNavigation& out);

/// Doubts about a navigation without observations, and about estimates that the declarations exclude: constants far from their priors, noise of the
/// IMU far above its declaration.
void judge_estimates(const Problem& problem, const SmoothedNode& last, AidedNavigation& out);

}  // namespace imulab::aided
