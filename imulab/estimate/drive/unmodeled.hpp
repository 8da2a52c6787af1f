// Errors of the sensors beyond offsets, matrices and g-sensitivity, as constants of their output under priors: quadratic and cubic terms, and the
// effects of the table (docs/theory/effects.md).
//
// Excluded are offset drifts and turn-ons, which are states and changes of the navigation itself, and rectification of vibration.
#pragma once

#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/navigation/aided/aided.hpp"
#include "imulab/navigation/aided/problem.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <span>
#include <string>
#include <string_view>

namespace imulab::drive {

/// Prefix of the names of effects: "effect.gyro.asymmetry.0".
inline constexpr std::string_view effect_prefix = "effect.";
/// Return true for effects, and for effects of the unit rather than of each drive.
bool is_effect(const std::string& constant);
bool is_effect_of_unit(const std::string& constant);
/// Returns "gyro.asymmetry" for an effect, else the name of the constant.
std::string shown_name(const std::string& constant);

/// Properties common to all drives of a unit: temperatures in K, the largest force and rate.
struct Shared {
  bool thermometer = true;
  double full_force = 0, full_rate = 0;
};
Shared shared_by(std::span<const Recording> recordings, const Session& session);

/// Returns the terms of a drive, whose recording must outlive them. Its readings must be in SI and close to the motion.
aided::OutputTerms output_terms(const Recording& recording, const Session& session, const Shared& shared);

/// Returns the effects among the constants, with their values.
kernel::Effects found_effects(const AidedNavigation& navigation, const Session& session);

}  // namespace imulab::drive
