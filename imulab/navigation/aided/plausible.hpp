// Checks of the estimates of an aided navigation for contradictions.
#pragma once

#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/filter.hpp"

#include <string>
#include <vector>

namespace imulab::aided {

/// Finds runs of many successive suspects from one source.
void find_runs_of_suspects(AidedNavigation& navigation);

/// Finds improbable levels of a receiver's slow error: another datum or geoid, a permanent jump, a contradictory second receiver. The correct level
/// is unknown, so the covariance of the positions grows by its square.
void widen_by_levels(const Problem& problem, const SmootherPass& smoothed, AidedNavigation& out);

/// Adds doubts about a navigation without observations, and about estimates that the declarations exclude: constants far from their priors, or noise
/// of the IMU far above its declaration.
void judge_estimates(const Problem& problem, const SmoothedNode& last, AidedNavigation& out);

}  // namespace imulab::aided
